"""Kernels of the estimator one at a time: the guess before there is anything to learn, limits, and what is kept."""

import math

import numpy as np
import pytest

from adaptive_ff import AdaptiveController
from adaptive_ff.adaptive.learning import estimator as kernels
from adaptive_ff.adaptive.learning.change_detection import JUMP_WINDOW, NOTHING, UNDECIDED, Surprise
from adaptive_ff.adaptive.learning.estimator_state import PRIOR, Levels, initial_estimator_state, with_levels
from adaptive_ff.adaptive.learning.friction_guess import guess_friction_in_place, time_stuck
from adaptive_ff.adaptive.learning.friction_map import POSITION
from adaptive_ff.friction.bounds import COULOMB, OFFSET
from adaptive_ff.friction.model import ESTIMATED, PER_DIRECTION, PER_DIRECTION_WITH_GRAVITY, WITH_GRAVITY, WITH_OFFSET
from adaptive_ff.learning.torque_form import Signals
from adaptive_ff.regression.known_loads import INPUT
from controllers import pi_gains

PERIOD = 0.01


def parameters(names, **options):
    controller = AdaptiveController(
        *pi_gains(20.0, 10.0), PERIOD, inertia=20.0, stribeck_velocity=0.05, parameters=names, **options
    )
    return controller.parameters.estimator


def signals(torque=0.0, speed=0.0, slope=0.0, velocity=0.0):
    filters = np.zeros((4, 2))
    filters[0, 0], filters[1] = torque, (speed, slope)
    return Signals(filters, velocity, np.zeros((2, 2)))


def guessed(measured, model, *, times=1, ratio=1.0, levels=None, names=ESTIMATED, loads=None, estimate=None):
    state = initial_estimator_state(parameters(names))
    if loads is not None:
        state.loads[:], state.recursion.estimate[-2:] = loads, (10.0, 20.0)
    if estimate is not None:
        state.recursion.estimate[1:3] = estimate
    if levels is not None:
        state = with_levels(state, levels, state.surprise, state.alarm)
    for _ in range(times):
        state = guess_friction_in_place(state, measured, model, PERIOD, ratio)
    return state.recursion.estimate, state.levels


MODEL = signals(speed=0.3, velocity=0.3)


def test_friction_is_guessed_from_the_torque_that_does_not_accelerate():
    estimate, levels = guessed(signals(100.0, 0.2, 1.5), MODEL, ratio=2.0)
    assert estimate[1:3] == pytest.approx([0.9 * (100.0 - 20.0 * 2.0 * 1.5)] * 2)
    assert tuple(levels) == (0.0, 100.0, 0.3, 0.0, 0.0)


def test_guess_counts_against_the_motion_as_negative():
    estimate, _ = guessed(signals(-100.0, 0.2), MODEL)
    assert estimate[1] == 0.0
    backward = signals(speed=-0.3, velocity=-0.3)
    assert guessed(signals(-100.0, -0.2), backward)[0][1] == pytest.approx(90.0)


def test_guess_is_at_most_twice_the_largest_torque_and_never_falls():
    estimate, levels = guessed(signals(10.0, 0.2, -50.0), MODEL)
    assert estimate[1:3] == pytest.approx([20.0, 20.0])
    assert levels.torque == 10.0
    estimate, levels = guessed(signals(-10.0, 0.2, -50.0), MODEL, levels=Levels(0.0, 4.0, 0.1, 0.0, 0.0))
    assert estimate[1] == pytest.approx(20.0)
    assert (levels.torque, levels.speed) == (10.0, 0.3)
    assert guessed(signals(10.0, 0.2), MODEL, estimate=(30.0, 40.0))[0][1:3].tolist() == [30.0, 40.0]


def test_nothing_of_a_fast_motion_before_is_forgotten_by_a_guess():
    _, levels = guessed(signals(10.0, 0.2), MODEL, levels=Levels(0.0, 4.0, 0.7, 0.0, 0.0))
    assert levels.speed == 0.7
    assert guessed(signals(100.0, 1.5), MODEL, levels=levels)[0][1] == pytest.approx(90.0)


def test_guess_leaves_out_the_known_loads():
    loads = np.array([[0.5, 1.0, 0.0], [1.0, 2.0, 0.0]])
    estimate, _ = guessed(signals(100.0, 0.2), MODEL, names=WITH_GRAVITY, loads=loads)
    lag = estimate[4]
    assert estimate[1] == pytest.approx(0.9 * (100.0 - 10.0 * (0.5 + lag) - 20.0 * (1.0 + 2.0 * lag)))


@pytest.mark.parametrize("sign", [1.0, -1.0])
def test_nothing_is_guessed_from_a_speed_that_no_reference_had(sign):
    kept = Levels(0.5, 7.0, 0.2, 0.0, 0.3)
    for speed in (kernels.SPEED_FACTOR * 0.3, 1.0):
        estimate, levels = guessed(signals(100.0, sign * speed), MODEL, levels=kept)
        assert estimate[1] == 0.0
        assert levels == kept._replace(speed=0.3)
    assert guessed(signals(100.0, sign * 0.89), MODEL, levels=kept)[0][1] == pytest.approx(90.0)


@pytest.mark.parametrize(("times", "rises"), [(99, True), (102, False)])
def test_a_joint_that_is_stuck_for_a_second_is_clamped(times, rises):
    """The torque goes on rising; what is guessed of it after a second does not."""
    state = initial_estimator_state(parameters(ESTIMATED))
    for k in range(1, times + 1):
        state = guess_friction_in_place(state, signals(float(k), 0.0), MODEL, PERIOD)
    assert state.levels.stuck == pytest.approx(times * PERIOD)
    assert state.recursion.estimate[1] == pytest.approx(0.9 * times if rises else 0.9 * 100.0, rel=0.011)
    assert (state.recursion.estimate[1] < 0.9 * times) is not rises


def test_a_joint_is_not_yet_clamped_after_exactly_a_second():
    state = initial_estimator_state(parameters(ESTIMATED))
    for k in range(1, 6):  # quarters of a second add up without rounding
        state = guess_friction_in_place(state, signals(float(k), 0.0), MODEL, 0.25)
    assert state.recursion.estimate[1:3].tolist() == [0.9 * 4.0] * 2


@pytest.mark.parametrize(
    ("measured", "planned", "expected"),
    [(0.099, 0.5, 0.71), (0.1, 0.5, 0.0), (-0.1, 0.5, 0.0), (0.05, 0.1, 0.71), (0.05, -0.2, 0.71), (0.05, 0.099, 0.7)],
)
def test_time_stuck_goes_on_while_the_reference_moves_and_the_joint_does_not(measured, planned, expected):
    levels = Levels(0.0, 0.0, 0.0, 0.0, 0.7)
    found = time_stuck(levels, 1.0, signals(speed=measured), signals(speed=planned), 0.01)
    assert found == pytest.approx(expected)


def test_peaks_fade_after_ten_memories():
    levels = Levels(0.3, 50.0, 0.4, 20.0, 0.1)
    assert kernels.faded(levels, 0.9, 2.0) is levels
    assert kernels.faded(levels, 0.9, 1.9) == pytest.approx((0.3, 0.99 * 50.0, 0.99 * 0.4, 20.0, 0.1))


def test_a_gain_that_is_not_finite_costs_the_information_and_no_estimate():
    estimator = parameters(WITH_OFFSET)
    estimator = estimator._replace(deviation=estimator.scale / np.linspace(0.5, 3.0, 6))
    state = initial_estimator_state(estimator)
    state.recursion.estimate[:], state.agreement[:], state.recursion.information[:] = 3.0, 5.0, 7.0
    state.recursion.gain[:] = 1.0
    assert kernels.recover_in_place(estimator, state) is False
    assert np.all(state.recursion.information == 7.0)
    state.recursion.gain[2] = math.nan
    assert kernels.recover_in_place(estimator, state) is True
    assert np.all(state.recursion.gain == 0.0)
    assert np.all(state.agreement == 0.0)
    expected = PRIOR * np.diag((estimator.scale / estimator.deviation) ** 2)
    assert state.recursion.information == pytest.approx(expected)
    assert np.all(state.recursion.estimate == 3.0)


def test_a_guess_that_is_no_larger_than_the_estimate_leaves_stiction_alone():
    assert guessed(signals(100.0, 0.2), MODEL, estimate=(90.0, 95.0))[0][1:3].tolist() == [90.0, 95.0]
    assert guessed(signals(100.0, 0.2), MODEL, estimate=(89.0, 95.0))[0][1:3].tolist() == [90.0, 90.0]


def test_a_guess_while_the_plan_rests_is_one_of_what_there_can_be():
    estimate, levels = guessed(signals(100.0, 0.0), signals(speed=0.1))
    assert 0.0 <= estimate[1] <= 100.0
    assert levels.torque == 100.0


def learnt(state, measured, model=None, names=WITH_OFFSET, *, duration=0.25, memory=0.75):
    estimator = parameters(names)._replace(memory=memory)
    return kernels.learn_in_place(estimator, state, measured, measured if model is None else model, duration)


def at_levels(levels, surprise=None, names=WITH_OFFSET):
    state = initial_estimator_state(parameters(names))
    return with_levels(state, levels, state.surprise if surprise is None else surprise, state.alarm)


SURPRISED = Surprise(1.0, 1.0, 1.0)


def test_a_change_is_noticed_when_more_than_a_memory_has_been_learnt():
    """Until then errors are learnt whole: the usual one is not known yet."""
    measured, found = signals(80.0, 0.3, 1.5, 0.3), []
    for before in (0.0, 0.5, 0.75):
        state = at_levels(Levels(0.0, 0.0, 0.3, before, 0.0), SURPRISED)
        state = learnt(state, measured)
        found.append(state.recursion.estimate.copy())
        assert state.alarm.cause == (UNDECIDED if before == 0.75 else NOTHING)
        assert state.levels.learnt == before + 0.25
    assert np.array_equal(found[0], found[1])
    assert not np.array_equal(found[0], parameters(WITH_OFFSET).first)


@pytest.mark.parametrize(("speed", "learns"), [(0.75, False), (-0.75, False), (0.7499, True), (-0.7499, True)])
def test_nothing_is_learnt_from_three_times_the_speed_that_any_plan_had(speed, learns):
    state = at_levels(Levels(0.01, 7.0, 0.125, 0.5, 0.25), SURPRISED)
    model = signals(80.0, -0.25, 1.5, -0.25)
    after = learnt(state, signals(80.0, speed, 1.5, speed), model)
    assert after.levels.learnt == (0.75 if learns else 0.5)
    assert after.levels.torque == (80.0 if learns else 7.0)
    assert after.levels[2:] == (0.25, after.levels.learnt, 0.25)
    assert (after.surprise == SURPRISED) is not learns
    assert np.array_equal(after.recursion.estimate, parameters(WITH_OFFSET).first) is not learns


@pytest.mark.parametrize("sign", [1.0, -1.0])
def test_an_error_is_at_most_twice_the_largest_torque(sign):
    """A false acceleration asks for a thousand times what there was; behind the lag its sign is the other one."""
    estimator = parameters(WITH_OFFSET)
    measured = signals(10.0, 0.3, sign * 5e3, 0.3)
    found = learnt(at_levels(Levels(0.0, 40.0, 0.3, 0.0, 0.0)), measured)
    share = 0.25 / (JUMP_WINDOW / estimator.form.pole + 0.25)
    largest = sign * kernels.PEAK_FACTOR * 40.0 / estimator.torque_scale
    assert found.surprise.error == pytest.approx(share * largest)
    kept = math.exp(-0.25 / 0.75)
    assert found.levels == pytest.approx(((1.0 - kept) * largest**2, 40.0, 0.3, 0.25, 0.0))


def test_information_that_is_lost_costs_one_correction_and_nothing_of_the_levels():
    measured, levels = signals(80.0, 0.3, 1.5, 0.3), Levels(0.01, 7.0, 0.3, 0.25, 0.0)
    healthy, spoilt = learnt(at_levels(levels), measured), at_levels(levels)
    spoilt.recursion.information[2, 2] = math.nan
    first = spoilt.recursion.estimate.copy()
    spoilt = learnt(spoilt, measured)
    assert spoilt.levels == healthy.levels
    assert spoilt.surprise == healthy.surprise
    assert np.array_equal(spoilt.recursion.estimate, first)
    assert np.all(np.isfinite(spoilt.recursion.information))
    again = learnt(spoilt, measured)
    assert not np.array_equal(again.recursion.estimate, first)


@pytest.mark.parametrize("ratio", [1.0, -4.0])
def test_gravity_and_the_map_turn_behind_the_gear(ratio):
    estimator = parameters(WITH_GRAVITY, gear_ratio=ratio, position_periods=[0.3])
    state = initial_estimator_state(estimator)
    kernels.follow_loads_in_place(estimator, state, 2.0, PERIOD, True)
    angle = 2.0 / ratio
    assert state.loads[:, INPUT] == pytest.approx([math.sin(angle), math.cos(angle)])
    state.recursion.estimate[-2:] = 30.0, 40.0
    turned = (2.0 + 1.0) / ratio
    expected = 30.0 * math.sin(turned) + 40.0 * math.cos(turned)
    assert kernels.estimated_load(estimator, state, 1.0) == pytest.approx(expected)
    followed = kernels.follow_friction_map(estimator, state, 2.0, 5.0, PERIOD, True)
    assert followed.friction_map.signals[POSITION, INPUT] == angle


@pytest.mark.parametrize(
    ("names", "loads"), [(ESTIMATED, 0), (WITH_OFFSET, 0), (PER_DIRECTION, 0), (PER_DIRECTION_WITH_GRAVITY, 2)]
)
def test_factors_are_on_inertia_and_on_friction_alone(names, loads):
    size = len(names) + 1 + loads
    row = np.random.default_rng(1).uniform(0.5, 2.0, size)
    heavy, rough = row.copy(), row.copy()
    kernels.scale_inertia_in_place(heavy, 1.7)
    kernels.scale_friction_in_place(rough, 1.7, loads)
    assert heavy == pytest.approx(row * np.where(np.arange(size) < 2, 1.7, 1.0))
    friction = [1 + i for i in range(len(names) - loads) if COULOMB <= i < 4 or i > OFFSET]
    assert rough == pytest.approx(row * np.where(np.isin(np.arange(size), friction), 1.7, 1.0))
