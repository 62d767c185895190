"""The observer of the torque that the feedforward leaves: its pole, and the hand-over to it."""

import math

import numpy as np
import pytest
from closed_loops import SCENARIO, make
from hypothesis import given
from hypothesis import strategies as st
from observed_joint import FEEDBACK, INERTIA, OBSERVER, PERIOD, after, observed

from adaptive_ff import AdaptiveController
from adaptive_ff.adaptive.settings import FASTEST
from adaptive_ff.adaptive.supervision.circumstances import CLAMPED, strains
from adaptive_ff.adaptive.supervision.observer import bridged_torque
from adaptive_ff.adaptive.supervision.observer_hand_over import hand_over_to_observer, take_up
from adaptive_ff.adaptive.supervision.observer_state import initial_observer, start_observer
from controllers import PI
from tests.helpers.driven_joint import behind_a_position_loop


def test_what_is_not_measured_is_bridged():
    """A velocity that is not measured costs no torque: the difference is taken over the whole gap."""
    state = start_observer(initial_observer(FEEDBACK), 0.0, 0.0)
    torques, mean = 10.0 * np.random.default_rng(1).standard_normal(8), 0.0
    for k, torque in enumerate(torques):
        mean = bridged_torque(mean, torque, (k + 1) * PERIOD, PERIOD)
    velocity = float(np.sum(torques + 5.0)) * PERIOD / INERTIA
    state = after(OBSERVER, state, mean, 0.0, 0.0, velocity, False, 1.0, math.inf, duration=8 * PERIOD)
    assert state.disturbance == pytest.approx(-5.0 * (1.0 - math.exp(-20.0 * 8 * PERIOD)))


@pytest.mark.parametrize(("learnt", "velocity", "pole"), [(False, 0.0, 40.0), (True, 0.0, 20.0), (False, 0.09, 20.0)])
def test_a_joint_that_stands_before_anything_is_learnt_is_observed_faster(learnt, velocity, pole):
    observer = OBSERVER._replace(standing_pole=40.0)
    state = start_observer(initial_observer(FEEDBACK), 0.1, velocity)
    state = after(observer, state, 10.0, 0.1, 0.0, velocity, False, 1.0, False, learnt=learnt)
    assert state.disturbance == pytest.approx(10.0 * -math.expm1(-pole * PERIOD))


def test_a_constant_disturbance_is_found_with_the_pole():
    """What holds the speed against a load, and was not fed forward, is the load."""
    states = observed(np.full(100, 25.0), np.full(101, 0.1), np.full(101, 0.1))
    times = PERIOD * np.arange(1, 101)
    assert [state.disturbance for state in states] == pytest.approx(25.0 * (1.0 - np.exp(-20.0 * times)), rel=1e-9)


def test_torque_that_accelerates_the_joint_is_no_disturbance():
    """The error changes by what the torque beyond the feedforward does to the inertia."""
    torques = 10.0 * np.random.default_rng(1).standard_normal(50)
    velocities = np.concatenate([[0.0], np.cumsum(torques) * PERIOD / INERTIA])
    assert all(abs(state.disturbance) < 1e-9 for state in observed(torques, velocities, np.zeros(51)))


@pytest.mark.parametrize("lag", [0.0, 0.03])
def test_a_leap_of_the_plan_that_was_not_foreseen_is_no_disturbance(lag):
    """No inertia torque was fed for it, so the joint need not have made it."""
    observer = OBSERVER._replace(velocity_lag=lag)
    for foreseen in (False, True):
        state = start_observer(initial_observer(FEEDBACK), 0.3, 0.3)
        for k in range(20):
            leap = 0.0 if foreseen or k > 0 else -0.3
            state = after(observer, state, 0.0, 0.0, 0.0, 0.3, False, 1.0, False, unforeseen=leap)
            if not foreseen:
                assert state.disturbance == pytest.approx(0.0, abs=1e-9)
        assert foreseen == (abs(state.disturbance) > 1.0)


def test_what_was_fed_forward_is_not_observed():
    state = start_observer(initial_observer(FEEDBACK), 0.1, 0.1)
    for _ in range(50):
        state, _ = hand_over_to_observer(state, 0.0, 1.0, 40.0, 0.0, 0.0)
        state = after(OBSERVER, state, 40.0, 0.1, 0.0, 0.1, False, 1.0, False)
    assert state.disturbance == pytest.approx(0.0, abs=1e-12)


def test_while_the_plan_rests_what_was_observed_is_held():
    state = observed(np.full(100, 25.0), np.full(101, 0.1), np.full(101, 0.1))[-1]
    for torque in (50.0, -400.0, 0.0):  # a stuck joint answers to none of these
        held = after(OBSERVER, state, torque, 0.0, 0.0, 0.0, True, 1.0, False)
        assert (held.disturbance, held.squared) == (state.disturbance, state.squared)
        assert (held.predicted_squared, held.error_squared) == (state.predicted_squared, state.error_squared)
        state = held


@pytest.mark.parametrize(("velocity", "asked", "moves"), [(0.0, -50.0, False), (0.0, 50.0, True), (0.05, -50.0, True)])
def test_while_the_joint_sticks_the_disturbance_does_not_grow_against_the_error(velocity, asked, moves):
    """The plan moves forward. What the integral asks for from before is no disturbance of a joint that sticks."""
    state = start_observer(initial_observer(FEEDBACK), 0.1, velocity)
    following = after(OBSERVER, state, asked, 0.1, 0.0, velocity, False, 1.0, False)
    assert (following.disturbance != 0.0) == moves


def test_an_error_as_small_as_noise_does_not_tell_that_the_joint_sticks():
    state = start_observer(initial_observer(FEEDBACK), 0.1, 0.0)
    for deviation, moves in ((0.03, False), (0.04, True)):
        noisy = state._replace(noise=state.noise._replace(variance=deviation**2))
        following = after(OBSERVER, noisy, -50.0, 0.1, 0.0, 0.0, False, 1.0, False)
        assert (following.disturbance != 0.0) == moves


SIZES = st.floats(-1e3, 1e3)
GAINS = st.floats(0.0, 1.0)


def total(state, fed, integral):
    return fed + state.gain * state.disturbance + integral


def handed_over(disturbance, old, new, change, integral):
    """Torque before and after the hand-over of a change of the feedforward and of the gain."""
    state = initial_observer(FEEDBACK)._replace(disturbance=disturbance, gain=old)
    after, leaves = hand_over_to_observer(state, change, new, change, integral, 0.0)
    assert after.gain == new
    return total(state, 0.0, integral), total(after, change, integral - leaves)


@given(disturbance=SIZES, integral=SIZES, change=SIZES, gains=st.tuples(GAINS, GAINS))
def test_neither_feedforward_nor_a_falling_gain_lets_the_torque_jump(disturbance, integral, change, gains):
    before, after = handed_over(disturbance, max(gains), min(gains), change, integral)
    assert after == pytest.approx(before, rel=1e-12, abs=1e-10)


@given(disturbance=SIZES, change=SIZES, gains=st.tuples(st.floats(0.0, 0.999), GAINS))
def test_a_rising_gain_does_not_where_the_integral_holds_the_rest_of_the_disturbance(disturbance, change, gains):
    old, new = gains[0], max(gains)
    before, after = handed_over(disturbance, old, new, change, (1.0 - old) * disturbance)
    assert after == pytest.approx(before, rel=1e-9, abs=1e-7)


@given(disturbance=SIZES, integral=SIZES, change=SIZES, gains=st.tuples(st.floats(0.0, 0.99), GAINS))
def test_a_rising_gain_adds_its_share_of_what_nobody_gives_yet(disturbance, integral, change, gains):
    """That is how the observer answers a load; the change of the feedforward has no part in it."""
    old, new = gains[0], max(gains)
    before, after = handed_over(disturbance, old, new, change, integral)
    lacking = (1.0 - old) * disturbance - integral
    assert after - before == pytest.approx((new - old) / (1.0 - old) * lacking, rel=1e-9, abs=1e-6)


def test_the_pole_is_at_most_the_crossover_of_the_feedback():
    crossover = FEEDBACK.proportional / INERTIA
    assert 0.0 < make("adaptive").parameters.observer.pole <= crossover * (1.0 + 1e-12)
    assert math.isfinite(crossover)


def adaptive_in_a_loop_of(crossover, **settings):
    """Make an adaptive controller for 1 kHz whose PI loop crosses over there (rad/s)."""
    inertia = 2.0
    return AdaptiveController(
        crossover * inertia, 0.1 * crossover**2 * inertia, 0.001, stribeck_velocity=0.05, inertia=inertia, **settings
    )


def test_observer_of_a_fast_loop_is_slower_than_the_loop():
    """What it is for changes no faster, and it would take the margin that the loop has left."""
    assert adaptive_in_a_loop_of(40.0).parameters.observer.pole == pytest.approx(40.0)
    assert adaptive_in_a_loop_of(300.0).parameters.observer.pole == FASTEST


def test_a_late_drive_makes_the_observer_slower_but_for_a_joint_that_stands():
    late = adaptive_in_a_loop_of(50.0, delay=5.0).parameters.observer
    assert late.pole == pytest.approx(50.0 / (1.0 + 2.0 * 0.005 * 50.0))
    assert late.standing_pole == FASTEST
    assert adaptive_in_a_loop_of(20.0, delay=5.0).parameters.observer.standing_pole == pytest.approx(24.0)
    assert adaptive_in_a_loop_of(300.0, delay=5.0).parameters.observer.standing_pole == FASTEST


@pytest.mark.parametrize(
    ("hertz", "delay", "pole", "standing"),
    [
        (5.0, 0.0, 10.0 * math.pi, 10.0 * math.pi),
        (100.0, 0.0, 300.0, 300.0),
        (100.0, 5.0, 300.0, 300.0),
        (0.5, 5.0, math.pi, 16.0 * math.pi),
    ],
)
def test_observer_that_is_asked_for_may_be_as_fast_as_the_loop(hertz, delay, pole, standing):
    asked = adaptive_in_a_loop_of(300.0, delay=delay, observer_bandwidth=hertz).parameters.observer
    assert asked.pole == pytest.approx(pole)
    assert asked.standing_pole == pytest.approx(standing)


def test_line_up_has_no_faster_observer_either():
    fast = SCENARIO.modified(sampling={"period": 0.001}, feedback={"bandwidth": 50.0}, sensor={"velocity_noise": 0.0})
    assert make("adaptive", fast).parameters.observer.pole == pytest.approx(FASTEST)


def test_a_joint_that_sticks_at_more_torque_than_it_ever_moved_with_is_held_by_a_brake():
    """What was observed fades, and stays away until the torque is a plausible one again, though the joint moves."""
    state = start_observer(initial_observer(FEEDBACK)._replace(disturbance=100.0), 0.1, 0.0)

    def asked(state, torque, velocity, moved):
        return after(OBSERVER, state, torque, 0.1, 0.0, velocity, False, 1.0, strains(torque, moved))

    for moved, fades in ((math.inf, False), (110.0, False), (100.0, True)):
        assert (asked(state, 310.0, 0.0, moved).disturbance < 100.0) == fades
    held = asked(state, 310.0, 0.0, 100.0)
    let_go = asked(held, 310.0, 0.09, 100.0)
    assert let_go.disturbance < held.disturbance
    assert asked(let_go, 290.0, 0.09, 100.0).stuck == 0.0


def stuck_for(seconds, friction=50.0):
    """The observer beside a joint that a plan does not move for so long, and then the joint sliding along its plan."""
    state = start_observer(initial_observer(FEEDBACK), 0.1, 0.0)
    for _ in range(round(seconds / PERIOD)):
        state = after(OBSERVER, state, friction, 0.1, 0.0, 0.0, False, 1.0, False)
    for _ in range(5):
        state = after(OBSERVER, state, friction, 0.1, 0.0, 0.1, False, 1.0, False)
    return state


def test_what_the_integral_has_grown_to_beside_a_stuck_joint_goes_to_the_observer_once_it_moves():
    """Else friction that is learnt then comes on top of it. The torque of both is what it was."""
    state = stuck_for(5.0)
    assert state.let_go
    assert take_up(state, 40.0, False) == (state, 0.0)  # it does not surely move
    taken, leaves = take_up(state, 40.0, True)
    assert leaves == pytest.approx(state.gain * 40.0)
    assert taken.gain * taken.disturbance - leaves == pytest.approx(state.gain * state.disturbance)
    assert take_up(taken, 40.0, True) == (taken, 0.0)  # once


def test_a_joint_that_sticks_for_a_moment_leaves_the_integral_alone():
    state = stuck_for(0.5 * CLAMPED)
    assert not state.let_go
    assert take_up(state, 40.0, True) == (state, 0.0)


def largest_torque_of_a_heavy_joint(controller, told):
    """Largest torque (N m) on moves and rests behind a position loop, of a joint of 8 kg m^2."""
    times = np.arange(0.0, 10.0, 0.001)
    plan = np.maximum(0.0, np.sin(math.pi / 1.5 * (times % 2.0))) * (-1.0) ** (times // 2.0)
    joint = {"period": 0.001, "bandwidth": 20.0, "inertia": 8.0, "friction": 6.0, "noise": 2e-4}
    return np.max(np.abs(behind_a_position_loop(controller, plan.tolist(), **joint, given={"inertia": told})[1]))


def test_inertia_that_is_given_is_that_of_the_observer():
    """With the one of the design it oscillates behind a position loop on six times as much; PI alone does not."""
    design = PI.design(inertia=1.0, period=0.001, bandwidth=20.0)
    alone = largest_torque_of_a_heavy_joint(PI(design.proportional, design.integral, 0.001), None)
    controller = AdaptiveController(design.proportional, design.integral, 0.001, inertia=1.0, stribeck_velocity=0.05)
    assert largest_torque_of_a_heavy_joint(controller, 8.0) < alone


@pytest.mark.parametrize("name", ["stuck", "away", "one_way", "squared", "quiet"])
def test_a_state_with_a_negative_time_or_square_is_refused(name):
    controller = make("adaptive")
    controller.state = controller.state._replace(observer=controller.state.observer._replace(**{name: -1.0}))
    with pytest.raises(ValueError, match=rf"state\.observer\.{name} = -1\.0 is not allowed"):
        controller.state_from_json(controller.state_to_json())
