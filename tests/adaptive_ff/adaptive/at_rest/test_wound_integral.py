"""What the integral winds up at rest: what of it is friction, and what that brings between rests."""

import math

import numpy as np
import pytest

from adaptive_ff import AdaptiveController
from adaptive_ff.adaptive.at_rest.wound_integral import (
    Standing,
    advance_standing,
    having_left,
    initial_standing,
    wound_up,
)
from adaptive_ff.adaptive.supervision.trust import MEMORY
from controllers import PI

PERIOD = 0.002


def rested(asked, *, held=None, torque=0.0, friction=10.0):
    """State after a rest in which an outer loop asks for so much at each sample, and the integral follows it."""
    state, integral = advance_standing(initial_standing(), 0.0, 0.0, torque, friction, True, PERIOD), 0.0
    for each in asked:
        integral += each
        state = advance_standing(state, integral if held is None else held, each, torque, friction, True, PERIOD)
    return state


@pytest.mark.parametrize("sign", [1.0, -1.0])
def test_what_an_outer_loop_asks_for_is_wound_up_as_far_as_friction_holds_it(sign):
    assert rested([sign] * 8, torque=0.0).wound == pytest.approx(sign * 8.0)
    # stands with a torque of 8 and a friction of 10: the load is -2 at least, so of 30 at most 2 + 30 are friction
    assert rested([sign] * 30, torque=sign * 8.0).wound == pytest.approx(sign * 30.0)
    # stands with a torque of 30: the load is 20 at least, of which the integral holds 30
    assert rested([sign] * 30, torque=sign * 30.0).wound == pytest.approx(sign * 10.0)
    assert rested([sign] * 30, torque=sign * 60.0).wound == 0.0


def test_without_an_outer_loop_nothing_is_wound_up():
    assert rested([0.0] * 50, held=7.0, torque=3.0).wound == 0.0
    assert rested([0.0] * 50, held=7.0, torque=40.0, friction=1.0).wound == 0.0


def test_what_is_wound_up_goes_when_the_plan_sets_out_and_only_then():
    resting = rested([0.5] * 10)
    moving = advance_standing(resting, 5.0, 0.5, 0.0, 10.0, False, PERIOD)
    assert wound_up(resting, moving) == pytest.approx(5.0)
    assert wound_up(resting, rested([0.5] * 11)) == 0.0
    later = advance_standing(moving, 5.0, 0.5, 0.0, 10.0, False, PERIOD)
    assert wound_up(moving, later) == 0.0
    assert moving == Standing(0.0, False, 0.0)
    left = having_left(moving, 4.0)
    assert left.left == 4.0
    assert advance_standing(left, 5.0, 0.0, 0.0, 10.0, False, MEMORY).left == pytest.approx(4.0 / math.e)


def moves(seed, duration, rests, speed=0.4):
    """Plan of moves to and fro between rests, rad/s, at every sample."""
    generator, plan = np.random.default_rng(seed), np.zeros(round(duration / PERIOD) + 2)
    place, direction = round(1.0 / PERIOD), 1.0
    while True:
        peak = speed * generator.uniform(0.3, 1.0)
        ramp = np.linspace(0.0, peak, round(peak / PERIOD))
        move = direction * np.concatenate([ramp, np.full(round(0.5 / PERIOD), peak), ramp[::-1]])
        if place + move.size >= plan.size:
            return plan
        plan[place : place + move.size] = move
        place += move.size + round(generator.uniform(*rests) / PERIOD)
        direction = -direction


def clicks(seed, duration, path=1e-3, length=0.05):
    """Plan of a hand wheel: steps of the same path either way, two in four seconds, rad/s."""
    generator, plan, click = np.random.default_rng(seed), np.zeros(round(duration / PERIOD) + 2), round(length / PERIOD)
    for start in np.arange(round(1.0 / PERIOD), plan.size - click, round(2.0 / PERIOD)):
        plan[start : start + click] = generator.choice([-1.0, 1.0]) * path / length
    return plan


def errors_behind_a_position_loop(controller, plan, load=0.0, bristles=None, inertia=5.0):
    """Errors of velocity (rad/s) and position (rad) of a joint that sticks, seen by an encoder behind a low-pass.

    It holds by 26 N m and slides with 20, or is held by bristles of a stiffness, N m/rad.
    """
    count, low_pass, steps = 2e-6, math.exp(-2.0 * math.pi * 150.0 * PERIOD), 20
    step = PERIOD / steps
    velocity = position = planned = seen = bent = last = 0.0
    found = np.empty((2, plan.size - 2))
    for k in range(plan.size - 2):
        reading = count * math.floor(position / count)
        seen, last = low_pass * seen + (1.0 - low_pass) * (reading - last) / PERIOD, reading
        found[:, k] = plan[k] - velocity, planned - position
        torque = controller.step(
            plan[k], seen, next_reference=plan[k + 1], correction=12.0 * (planned - reading), position=reading
        )
        for _ in range(steps):
            holds = 20.0 + 6.0 * math.exp(-abs(velocity) / 0.02)
            free = velocity + step * (torque - load - 20.0 * velocity) / inertia
            if bristles is None:
                velocity = math.copysign(max(0.0, abs(free) - step * holds / inertia), free)
            else:
                before, stiff = bent, bristles / holds
                bent = (bent + step * velocity) / (1.0 + step * stiff * abs(velocity))
                damping = math.sqrt(bristles * inertia) * (bent - before) / step
                velocity = free - step * (bristles * bent + damping) / inertia
            position += step * velocity
        planned += 0.5 * PERIOD * (plan[k] + plan[k + 1])
    return found


def better_by(plan, *, torque_limit=math.inf, **joint):
    """Settled errors of PI over those of the adaptive controller, of velocity and position."""
    design = PI.design(inertia=5.0, period=PERIOD, bandwidth=12.0)
    gains = design.proportional, design.integral, PERIOD
    own = AdaptiveController(*gains, inertia=5.0, stribeck_velocity=0.02, torque_limit=torque_limit)
    both = [errors_behind_a_position_loop(each, plan, **joint) for each in (PI(*gains), own)]
    alone, with_it = (np.sqrt(np.mean(found[:, found.shape[1] // 2 :] ** 2, axis=1)) for found in both)
    return alone / with_it


def mean_of(ratios):
    """Geometric mean of velocities and of positions: what single plans do hangs on a few moves."""
    return np.exp(np.mean(np.log(list(ratios)), axis=0))


@pytest.mark.parametrize("load", [0.0, -40.0])
def test_moves_between_rests_of_seconds_are_better_than_those_of_the_loop_alone(load):
    """PI winds up for the next move where it overshoots its stops; the velocity error was 1.5 to 3 times its."""
    assert np.all(mean_of(better_by(moves(seed, 100.0, (4.0, 20.0)), load=load) for seed in (102, 103, 104)) > 1.0)


def test_so_they_are_with_a_load_that_helps_the_first_one_where_the_limit_is_told():
    """Untold, the drive seems to saturate on the way back, and the friction is not learnt: 0.23 and 0.35."""
    ratios = (better_by(moves(seed, 100.0, (4.0, 20.0)), load=-20.0, torque_limit=400.0) for seed in (104, 105))
    assert np.all(mean_of(ratios) > 1.0)


def test_bristles_are_as_far_bent_as_what_was_wound_up():
    """Those that were taken for bent all the way kept most of it in the integral: 2.0 and 2.7."""
    assert np.all(mean_of(better_by(moves(seed, 80.0, (4.0, 10.0)), bristles=2e4) for seed in (102, 103)) > 3.0)


@pytest.mark.parametrize("seed", [101, 102])
def test_a_joint_is_not_thrown_by_the_clicks_of_a_hand_wheel(seed):
    """Friction was fed on top of an integral that was at breakaway already: up to 1.3 times the error of PI."""
    assert np.all(better_by(clicks(seed, 60.0)) > 0.95)


def learnt_controller():
    """A controller that knows 20 N m of friction, at rest, with a position loop that asks for more and more."""
    design = PI.design(inertia=5.0, period=PERIOD, bandwidth=12.0)
    model = {"inertia": 5.0, "coulomb": 20.0, "stiction": 20.0, "viscous": 0.0, "friction_lag": 0.0}
    controller = AdaptiveController(
        design.proportional, design.integral, PERIOD, inertia=5.0, stribeck_velocity=0.02, model=model
    )
    for _ in range(100):
        controller.step(0.0, 0.0, next_reference=0.0)
    return controller


def held_by(controller):
    """What integral and observer give, N m."""
    state = controller.state
    return state.feedback.integral + state.observer.gain * state.observer.disturbance


def test_the_integral_gives_up_what_was_wound_up_as_far_as_the_friction_is_fed():
    controller = learnt_controller()
    for _ in range(500):
        controller.step(0.0, 0.0, next_reference=0.0, correction=1e-3)
    wound, trust, before = controller.state.standing.wound, controller.trust, held_by(controller)
    assert 2.0 < wound < 20.0
    assert 0.1 < trust < 0.9
    controller.step(0.0, 0.0, next_reference=1e-5, correction=1e-3)
    assert before - held_by(controller) == pytest.approx(trust * wound, rel=0.05)
    assert controller.state.standing == (0.0, False, pytest.approx(wound, rel=0.01))


def test_what_is_not_measured_winds_nothing_up():
    controller = learnt_controller()
    for _ in range(200):
        controller.step(0.0, 0.0, next_reference=0.0, correction=1e-3)
    wound = controller.state.standing.wound
    for _ in range(500):
        controller.step(0.0, math.nan, next_reference=0.0, correction=1e-3)
    assert controller.state.standing.wound == pytest.approx(wound, rel=0.05)


def test_a_controller_that_takes_over_has_wound_nothing_up():
    controller = learnt_controller()
    for _ in range(200):
        controller.step(0.0, 0.0, next_reference=0.0, correction=1e-3)
    assert controller.state.standing.wound > 0.0
    controller.take_over(3.0, 0.0, 0.0)
    assert controller.state.standing == initial_standing()
