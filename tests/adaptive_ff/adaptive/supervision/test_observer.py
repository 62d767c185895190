"""The observer of the torque that the feedforward leaves: its pole, its gates, and the hand-over to it."""

import math

import numpy as np
import pytest
from closed_loops import SCENARIO, begin, course_along, make, run_compiled
from hypothesis import given
from hypothesis import strategies as st

from adaptive_ff import AdaptiveController
from adaptive_ff.adaptive.settings import FASTEST
from adaptive_ff.adaptive.supervision.circumstances import CLAMPED, Circumstances, strains
from adaptive_ff.adaptive.supervision.observer import (
    bridged_torque,
    misfit,
    observe,
    observed_inertia,
    observer_gain,
    short_mean,
    tells_at_once,
)
from adaptive_ff.adaptive.supervision.observer_hand_over import hand_over_to_observer, take_up
from adaptive_ff.adaptive.supervision.observer_state import ObserverParameters, initial_observer, start_observer
from adaptive_ff.simulation.experiment import empty_record
from controllers import PI, check_gains
from tests.helpers.driven_joint import behind_a_position_loop

PERIOD = 0.01
FEEDBACK = check_gains(*SCENARIO.feedback.gains, 0.01)
INERTIA = SCENARIO.feedback.inertia
OBSERVER = ObserverParameters(20.0, 20.0, INERTIA, 0.0, PERIOD)


def after(
    observer,
    state,
    torque,
    reference,
    correction,
    velocity,
    held,
    peak,
    strained,
    duration=PERIOD,
    unforeseen=0.0,
    learnt=True,
):
    """State after a period over which the drive gave a torque."""
    lacking = torque - state.fed[0]
    known = Circumstances(
        held,
        peak,
        strained,
        falls=False,
        believed=True,
        saturates=False,
        friction=0.0,
        unforeseen=unforeseen,
        learnt=learnt,
    )
    return observe(observer, state, FEEDBACK, lacking, INERTIA, reference, correction, velocity, duration, known)


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


def observed(torques, velocities, references, observer=OBSERVER):
    """States while the drive gives torques; velocity and reference have one value more, of the start."""
    state, states = start_observer(initial_observer(FEEDBACK), references[0], velocities[0]), []
    for torque, reference, velocity in zip(torques, references[1:], velocities[1:], strict=True):
        state = after(observer, state, torque, reference, 0.0, velocity, False, 1.0, math.inf)
        states.append(state)
    return states


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


@pytest.mark.parametrize(
    ("identified", "squared", "inertia"),
    [(0.5, 4.0, 0.5), (0.5, 6.0, 0.75), (0.5, 8.0, 1.0), (0.5, 100.0, 1.0), (2.0, 0.0, 1.0), (2.0, 8.0, 1.0)],
)
def test_a_smaller_inertia_is_believed_where_noise_explains_what_the_model_leaves(identified, squared, inertia):
    """The error of the identification is squared, over what the noise makes of the gain; both times their inertia."""
    noise = initial_observer(FEEDBACK).noise
    assert misfit(noise, FEEDBACK, 0.0) == 1.0, "noise is not known"
    known = observed(np.zeros(300), 0.002 * np.random.default_rng(4).standard_normal(301), np.full(301, 0.1))[-1].noise
    unfit = misfit(known, FEEDBACK, squared * FEEDBACK.proportional**2 * known.variance)
    assert observed_inertia(OBSERVER, identified * INERTIA, unfit) == pytest.approx(inertia * INERTIA)


def test_joint_at_rest_and_repeated_values_tell_nothing_of_noise():
    rng = np.random.default_rng(2)
    rested = observed(np.zeros(300), 0.01 * rng.standard_normal(301), np.zeros(301))[-1]
    repeated = observed(np.zeros(300), np.full(301, 0.1), np.linspace(0.1, 0.3, 301))[-1]
    assert rested.noise.measured == repeated.noise.measured == 0.0
    assert observer_gain(OBSERVER, rested, FEEDBACK, INERTIA, 0.0) == 1.0, "while noise is not known all gates are open"


def gain_at_an_error(error, correction=0.0):
    """Gain where a load is observed, and the plan is missed by an error that the residual does not explain."""
    noise = 0.002 * np.random.default_rng(3).standard_normal(401)
    state, gains = start_observer(initial_observer(FEEDBACK), 0.1, 0.1), []
    for sample in range(400):
        velocity = 0.1 + correction - error + noise[sample]
        torque = 60.0 + INERTIA * (velocity - state.velocity) / PERIOD if sample else 60.0
        # a residual that the loop has long made up for: what it would make of it is no error any more
        state = after(OBSERVER, state, torque, 0.1, correction, velocity, False, 1.0, math.inf)
        gains.append(observer_gain(OBSERVER, state, FEEDBACK, INERTIA, 0.0))
    return gains[-1]


def test_error_that_no_residual_explains_opens_the_gate():
    assert gain_at_an_error(0.0) == 0.0
    assert gain_at_an_error(0.01) == 1.0


def test_what_an_outer_loop_asks_for_is_no_error():
    assert gain_at_an_error(0.0, correction=0.05) == 0.0
    assert gain_at_an_error(0.01, correction=0.05) == 1.0


def test_noise_out_of_a_filter_opens_no_gate_where_the_model_fits():
    """Second differences tell too little of it; where the model does not fit, what is left may be an error."""
    observer, feedback = (
        ObserverParameters(65.0, 65.0, INERTIA, 0.0, 0.001),
        check_gains(314.0 * INERTIA, 4000.0 * INERTIA, 0.01),
    )
    white, noise = 0.002 * np.random.default_rng(5).standard_normal(20000), 0.0
    state, gains = start_observer(initial_observer(feedback), 0.1, 0.1), []
    known = Circumstances(False, 1.0, False, False, True, False, 0.0, 0.0, True)
    for value in white:
        noise += 0.8 * (value - noise)
        state = observe(observer, state, feedback, 60.0, INERTIA, 0.1, 0.0, 0.1 + noise, 0.001, known)
        gains.append([observer_gain(observer, state, feedback, INERTIA, unfit) for unfit in (0.0, 1.0)])
    fit, unfit = np.mean(gains[10000:], axis=0)
    assert unfit > 0.1
    assert fit == 0.0


def run_frozen(reference, load, *, controller, position=None):
    """Let a controller that does not learn move a frictionless joint; observer after each sample, and the end."""
    free = SCENARIO.joint.model_copy(update={"coulomb": 0.0, "stiction": 0.0, "viscous": 0.0, "offset": load})
    course = course_along(reference, joint=free, substeps=10, noise=0.002, seed=int(load))
    record = empty_record(course, len(controller.estimate_names))
    position = begin(course) if position is None else position._replace(sample=0, acting=-1)
    state, observers = controller.state, []
    for sample in range(1, course.noise.size + 1):
        state, position = run_compiled(controller.parameters, state, course, position, sample, record)
        observers.append(state.observer)
    controller.state = state
    return observers, position


@pytest.fixture(scope="module")
def loaded():
    """Observers before and after a load step on a joint that is the inertia which the controller assumes."""
    controller = make("adaptive")
    controller.enabled = False
    reference = SCENARIO.modified(seed=101, duration=20.0).reference_velocity()
    before, position = run_frozen(reference[:10_001], 0.0, controller=controller)
    after, _ = run_frozen(reference[10_000:], 30.0, controller=controller, position=position)
    return before, after


def test_on_a_joint_that_the_model_explains_nothing_is_fed_back(loaded):
    gains = np.array([state.gain for state in loaded[0]])
    assert np.all(gains[200:] == 0.0)


def test_a_load_step_opens_them_within_three_samples(loaded):
    """A short mean alone needs five."""
    turned = 30  # the plan has moved one way for that many samples and more when the load comes
    assert loaded[1][0].one_way > turned * PERIOD
    assert loaded[1][0].gain == 0.0
    assert loaded[1][3].gain == 1.0


def known_friction(friction, held=False):
    return Circumstances(held, 1.0, False, False, True, False, friction, 0.0, True)


def test_what_is_large_beside_the_friction_tells_of_a_sudden_change():
    assert tells_at_once(20.0, 1.0, False, known_friction(60.0))
    assert tells_at_once(-20.0, 1.0, False, known_friction(60.0))
    assert not tells_at_once(8.0, 1.0, False, known_friction(60.0))


@pytest.mark.parametrize(
    ("one_way", "coloured", "held"),
    [(0.1, False, False), (1.0, True, False), (1.0, False, True)],
    ids=["shortly after a reversal", "coloured noise", "held"],
)
def test_it_does_not_where_something_else_may_be_observed(one_way, coloured, held):
    assert not tells_at_once(20.0, one_way, coloured, known_friction(60.0, held))


def test_of_a_sudden_change_a_share_counts_at_once():
    assert short_mean(1.0, 100.0, 0.03, 0.0) == pytest.approx(3.97)
    assert short_mean(1.0, 100.0, 0.03, 0.25) == 25.0
    assert short_mean(50.0, 0.0, 0.03, 0.25) == pytest.approx(48.5)


def test_a_load_step_opens_the_gates_until_the_integral_carries_it(loaded):
    gains = np.array([state.gain for state in loaded[1]])
    assert np.all(gains[10:30] == 1.0)
    assert np.all(gains[100:] == 0.0)
    disturbances = np.array([state.disturbance for state in loaded[1]])
    assert np.mean(disturbances[30:]) == pytest.approx(30.0, rel=0.02)


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
