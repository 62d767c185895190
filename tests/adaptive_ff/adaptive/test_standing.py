"""What the integral winds up at rest: what of it is friction, and what that brings between rests."""

import math

import numpy as np
import pytest

from adaptive_ff import AdaptiveController
from adaptive_ff.adaptive.standing import FADES, Standing, advance_standing, having_left, initial_standing, wound_up
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
    assert advance_standing(left, 5.0, 0.0, 0.0, 10.0, False, FADES).left == pytest.approx(4.0 / math.e)


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


def errors_behind_a_position_loop(controller, plan, load=0.0, inertia=5.0, coulomb=20.0, stiction=26.0, gain=12.0):
    """Errors of velocity (rad/s) and position (rad) of a joint that sticks, seen by an encoder behind a low-pass."""
    count, low_pass, steps = 2e-6, math.exp(-2.0 * math.pi * 150.0 * PERIOD), 10
    velocity = position = planned = seen = 0.0
    last, found = 0.0, np.empty((2, plan.size - 2))
    for k in range(plan.size - 2):
        reading = count * math.floor(position / count)
        seen, last = low_pass * seen + (1.0 - low_pass) * (reading - last) / PERIOD, reading
        found[:, k] = plan[k] - velocity, planned - position
        torque = controller.step(
            plan[k], seen, next_reference=plan[k + 1], correction=gain * (planned - reading), position=reading
        )
        for _ in range(steps):
            holds = coulomb + (stiction - coulomb) * math.exp(-abs(velocity) / 0.02)
            free = velocity + PERIOD / steps * (torque - load - 20.0 * velocity) / inertia
            velocity = math.copysign(max(0.0, abs(free) - PERIOD / steps * holds / inertia), free)
            position += PERIOD / steps * velocity
        planned += 0.5 * PERIOD * (plan[k] + plan[k + 1])
    return found


def better_by(plan, **joint):
    """Settled errors of PI over those of the adaptive controller, of velocity and position."""
    design = PI.design(inertia=5.0, period=PERIOD, bandwidth=12.0)
    gains = design.proportional, design.integral, PERIOD
    own = AdaptiveController(*gains, inertia=5.0, stribeck_velocity=0.02)
    both = [errors_behind_a_position_loop(each, plan, **joint) for each in (PI(*gains), own)]
    alone, with_it = (np.sqrt(np.mean(found[:, found.shape[1] // 2 :] ** 2, axis=1)) for found in both)
    return alone / with_it


@pytest.mark.parametrize(("seed", "load"), [(102, 0.0), (103, 0.0), (102, 50.0), (103, -50.0)])
def test_moves_between_rests_of_seconds_are_no_worse_than_those_of_the_loop_alone(seed, load):
    """PI winds up for the next move where it overshoots its stops; the velocity error was 1.5 to 3 times its."""
    assert np.all(better_by(moves(seed, 120.0, (4.0, 20.0)), load=load) > 0.95)


@pytest.mark.parametrize("seed", [101, 102])
def test_a_joint_is_not_thrown_by_the_clicks_of_a_hand_wheel(seed):
    """Friction was fed on top of an integral that was at breakaway already: up to 1.3 times the error of PI."""
    assert np.all(better_by(clicks(seed, 60.0)) > 0.95)
