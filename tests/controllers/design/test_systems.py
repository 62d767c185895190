"""The sampled loop: its margins and those of its observers, and as python-control systems."""

import math

import control
import numpy as np
import pytest
from inertia_loops import GAINS, INERTIA, OBSERVING, PERIOD, make_observing, run_inertia
from scipy.signal import lfilter

import controllers
from adaptive_ff import load_scenario
from adaptive_ff.comparison.registry import observer_bandwidth
from controllers import PI, DisturbanceObserver, ExtendedState, KalmanDisturbance, loop_margins_of, loop_systems
from controllers.design.kalman_gains import kalman_velocity_gains
from controllers.design.margins import loop_margins
from controllers.design.observer_design import SLOWEST, disturbance_observer_compensation
from controllers.design.pi_design import pi_gains
from controllers.design.sampled_loop import SampledLoop, open_loop
from controllers.design.velocity_filter import NO_FILTER, filter_of, noise_of_positions
from controllers.velocity import VELOCITY_ESTIMATORS, direct_velocity, initial_velocity_state, low_pass_velocity
from plant import Joint, JointModel


@pytest.mark.parametrize("delay", [0, 2])
def test_margins_of_given_gains_are_those_of_the_design(delay):
    design = PI.design(inertia=20.0, period=0.01, bandwidth=3.0, delay=delay)
    found = loop_margins_of(design.systems())
    assert found.stable
    assert found.maximum_sensitivity == pytest.approx(design.maximum_sensitivity, rel=2e-3)
    assert found.crossover == pytest.approx(design.crossover, rel=5e-3)
    assert found.phase_margin == pytest.approx(design.phase_margin, abs=0.5)
    assert found.gain_margin == pytest.approx(design.gain_margin, rel=2e-2)


def test_step_response_is_that_of_the_simulated_joint():
    design = PI.design(inertia=20.0, period=0.01, bandwidth=5.0)
    joint = Joint(
        JointModel(inertia=20.0, coulomb=0.0, stiction=0.0, viscous=0.0, stribeck_velocity=1.0, solver_period=0.01)
    )
    controller, velocity, expected = PI(design.proportional, design.integral, 0.01), 0.0, []
    for _ in range(60):
        expected.append(velocity)
        velocity = joint.step(controller.step(1.0, velocity), 0.01)
    response = control.step_response(design.systems().closed_loop, 0.01 * np.arange(60)).outputs
    assert response == pytest.approx(expected, abs=1e-9)


def test_falling_friction_beyond_the_gain_is_unstable_and_viscous_friction_is_not():
    gains = (100.0, 0.0, 20.0, 0.001)
    assert loop_margins_of(loop_systems(*gains, friction_slope=-90.0)).stable
    unstable = loop_margins_of(loop_systems(*gains, friction_slope=-110.0))
    assert (unstable.stable, unstable.maximum_sensitivity) == (False, math.inf)
    systems = loop_systems(*gains, friction_slope=50.0)
    assert systems.plant.dcgain() == pytest.approx(1.0 / 50.0)
    assert (systems.sensitivity + systems.closed_loop).dcgain() == pytest.approx(1.0)


@pytest.mark.parametrize("proportional", [1e-4, 1e-2, 0.4, 1.2])
def test_margins_are_those_at_the_crossover_of_loops_of_any_speed(proportional):
    loop = SampledLoop(proportional, 0.2 * proportional**2, 0)
    found = loop_margins(*open_loop(loop), 1e-2 * min(proportional, 1.0))
    numerator, denominator = (np.polyval(one, np.exp(2j * math.pi * found.crossover)) for one in open_loop(loop))
    assert abs(numerator / denominator) == pytest.approx(1.0, rel=0.01)
    assert found.phase_margin == pytest.approx(math.degrees(np.angle(-numerator / denominator)), abs=1e-6)


NOTCH = 0.35 * np.array([1.0, -1.96 * math.cos(0.5), 0.98**2])


@pytest.mark.parametrize(
    ("loop", "rest"), [(NOTCH, [1.0, -1.0, 0.0, 0.0]), ([-0.05], [1.0, -0.9])], ids=["notch", "negative when slow"]
)
def test_loop_is_stable_up_to_its_gain_margin(loop, rest):
    loop = np.array(loop)
    margin = loop_margins(loop, np.array(rest), 1e-3).gain_margin
    largest_poles = [np.max(np.abs(np.roots(np.polyadd(gain * margin * loop, rest)))) for gain in (0.99, 1.01)]
    assert largest_poles[0] < 1.0 < largest_poles[1]


ESTIMATORS = {
    "difference": controllers.difference_velocity(PERIOD),
    "low-pass": low_pass_velocity(30.0, PERIOD),
    "kalman": controllers.kalman_velocity(*kalman_velocity_gains(4.4e-4, 20.0, PERIOD), PERIOD),
}


def estimated(estimator, positions):
    state, found = initial_velocity_state(estimator, 0.0, 0.0), []
    for reading in positions:
        value, state = VELOCITY_ESTIMATORS[type(estimator)](estimator, state, reading, PERIOD)
        found.append(value)
    return found


COARSE = {"velocity_noise": 0.0, "encoder_resolution": 2.0 * math.pi / 4096}


@pytest.mark.parametrize("name", ESTIMATORS)
def test_filter_is_what_the_estimator_makes_of_a_joint_that_accelerates_evenly_in_each_period(name):
    estimator, velocity = ESTIMATORS[name], np.random.default_rng(1).standard_normal(200)
    velocity[0] = 0.0
    position = np.concatenate([[0.0], np.cumsum(0.5 * PERIOD * (velocity[1:] + velocity[:-1]))])
    made = filter_of(estimator)
    assert estimated(estimator, position) == pytest.approx(
        lfilter(made.numerator[::-1], made.denominator[::-1], velocity), abs=1e-12
    )
    assert sum(made.numerator) == pytest.approx(sum(made.denominator), rel=1e-9)


@pytest.mark.parametrize("name", ESTIMATORS)
def test_noise_of_a_velocity_is_the_root_of_the_squares_that_one_wrong_reading_leaves(name):
    left = estimated(ESTIMATORS[name], np.eye(1, 600, 1)[0])
    assert noise_of_positions(ESTIMATORS[name], PERIOD) == pytest.approx(np.linalg.norm(left), rel=1e-9)


def test_a_measured_velocity_passes_and_what_is_no_estimator_is_refused():
    assert filter_of(direct_velocity(PERIOD)) == NO_FILTER
    with pytest.raises(TypeError, match=r"velocity = 3\.0"):
        filter_of(3.0)


@pytest.mark.parametrize("name", ESTIMATORS)
def test_open_loop_has_the_filter_as_a_factor(name):
    made, point = filter_of(ESTIMATORS[name]), np.exp(0.3j)
    loop = SampledLoop(0.3, 0.01, 1)
    filtered = open_loop(loop._replace(velocity=made), disturbance_observer_compensation(loop, 0.2))
    plain = open_loop(loop, disturbance_observer_compensation(loop, 0.2))
    factor = np.polyval(made.numerator, 1.0 / point) / np.polyval(made.denominator, 1.0 / point)
    value = np.polyval(plain[0], point) / np.polyval(plain[1], point)
    assert np.polyval(filtered[0], point) / np.polyval(filtered[1], point) == pytest.approx(factor * value, rel=1e-9)


@pytest.mark.parametrize(("own", "gains"), [(DisturbanceObserver, (800.0, 3000.0)), (ExtendedState, (800.0,))])
def test_the_fastest_observer_is_slower_behind_a_filter(own, gains):
    plain = own.design(20.0, PERIOD, *gains).bandwidth
    filtered = own.design(20.0, PERIOD, *gains, velocity=low_pass_velocity(30.0, PERIOD))
    assert filtered.bandwidth < 0.7 * plain
    assert filtered.maximum_sensitivity == pytest.approx(2.0, rel=1e-3)


def test_an_observer_is_slow_where_an_encoder_leaves_the_loop_no_margin():
    coarse = load_scenario().modified(sensor=COARSE, velocity={"method": "kalman"}, feedback={"bandwidth": 6.0})
    found = observer_bandwidth(coarse, 1.7, DisturbanceObserver.design, *coarse.feedback.gains)
    assert found == pytest.approx(SLOWEST * 6.0, rel=1e-3)
    assert (
        observer_bandwidth(coarse, 1.7, DisturbanceObserver.design, *coarse.feedback.gains, bounded=False) > 5.0 * found
    )
    fine = coarse.modified(sensor={**COARSE, "encoder_resolution": 6e-6}, feedback={"bandwidth": 10.0})
    free = observer_bandwidth(fine, 1.7, DisturbanceObserver.design, *fine.feedback.gains, bounded=False)
    assert observer_bandwidth(fine, 1.7, DisturbanceObserver.design, *fine.feedback.gains) == free


CLASSES = {each.__name__: each for each in (DisturbanceObserver, ExtendedState, KalmanDisturbance)}

observing = pytest.mark.parametrize("name", OBSERVING)


def design(name, bandwidth=None, *, period=PERIOD, gains=GAINS, inertia=INERTIA, **others):
    used = gains[:1] if name == "ExtendedState" else gains
    return CLASSES[name].design(inertia, period, *used, bandwidth, **others)


def sensitivity_of_the_running_loop(name, bandwidth, delay=0, period=PERIOD, gains=GAINS, count=1 << 11):
    """``1/(1 + L)`` from a run: the measured velocity after an impulse on the measurement, transformed.

    The impulse comes late, because the first measurement starts the observer.
    """
    impulse = np.zeros(count)
    impulse[1] = 1.0
    controller = make_observing(name, bandwidth, period=period, gains=gains)
    measured, _ = run_inertia(controller, np.zeros(count), disturbance=impulse, delay=delay, dt=period, preview=False)
    assert np.max(np.abs(measured[-100:])) < 1e-6
    return np.fft.rfft(measured[1:])


LOOPS = [(0.01, 0, 2.0, 10.0, 1.0), (0.01, 0, 15.0, 10.0, 1.0), (0.01, 0, 15.0, 10.0, 0.0), (0.001, 0, 80.0, 10.0, 1.0)]
LOOPS += [(0.01, 1, 6.0, 4.0, 0.0), (0.01, 2, 4.0, 3.0, 0.0), (0.001, 3, 40.0, 20.0, 0.0)]
"""Those with a delay are without an integral, whose anti-windup takes a delay for saturation."""


@observing
@pytest.mark.parametrize(("period", "delay", "bandwidth", "crossover", "integral"), LOOPS)
def test_maximum_sensitivity_is_that_of_the_running_loop(name, period, delay, bandwidth, crossover, integral):
    proportional, with_integral = pi_gains(INERTIA, crossover)
    gains = (proportional, with_integral * integral)
    found = design(name, bandwidth, period=period, gains=gains, delay=delay)
    expected = sensitivity_of_the_running_loop(name, bandwidth, delay, period, gains)
    assert found.maximum_sensitivity == pytest.approx(np.max(np.abs(expected)), rel=2e-3)
    assert found.bandwidth == bandwidth


def stays_bounded(name, bandwidth, gain, delay, gains):
    """Whether the loop calms down with a joint that is lighter than assumed, which raises the gain."""
    kick = np.zeros(4000)
    kick[1] = 1.0
    with np.errstate(over="ignore", invalid="ignore"):
        controller = make_observing(name, bandwidth, gains=gains)
        velocity, _ = run_inertia(controller, np.zeros(4000), disturbance=kick, delay=delay, inertia=INERTIA / gain)
    tail = np.max(np.abs(velocity[-500:]))
    return bool(np.isfinite(tail) and tail < 1e-3)


@observing
@pytest.mark.parametrize(("bandwidth", "delay", "gains"), [(8.0, 0, GAINS), (3.0, 1, (GAINS[0], 0.0))])
def test_loop_is_stable_up_to_the_stated_gain_margin(name, bandwidth, delay, gains):
    margin = design(name, bandwidth, delay=delay, gains=gains).gain_margin
    assert 1.3 < margin < 20.0
    assert stays_bounded(name, bandwidth, 0.97 * margin, delay, gains)
    assert not stays_bounded(name, bandwidth, 1.03 * margin, delay, gains)


@observing
def test_phase_margin_and_crossover_are_those_of_the_sensitivity_and_its_complement(name):
    """Where ``|L| = 1``, ``|S| = |1 - S|`` and the phase margin is ``2 asin(1/(2 |S|))``."""
    sensitivity = sensitivity_of_the_running_loop(name, 8.0, count=1 << 14)
    crossing = int(np.nonzero(np.abs(1.0 - sensitivity) >= np.abs(sensitivity))[0][-1])
    found = design(name, 8.0)
    assert found.crossover == pytest.approx(crossing / (((1 << 14) - 1) * PERIOD), rel=0.01)
    margin = math.degrees(2.0 * math.asin(0.5 / abs(sensitivity[crossing])))
    assert found.phase_margin == pytest.approx(margin, abs=1.0)


@observing
@pytest.mark.parametrize(("delay", "gains"), [(0, pi_gains(INERTIA, 9.0)), (1, (pi_gains(INERTIA, 4.0)[0], 0.0))])
@pytest.mark.parametrize("bound", [1.7, 1.9])
def test_largest_bandwidth_meets_the_bound_and_no_larger_one_does(name, delay, gains, bound):
    found = design(name, gains=gains, delay=delay, maximum_sensitivity=bound)
    assert found.maximum_sensitivity == pytest.approx(bound, rel=1e-4)
    expected = sensitivity_of_the_running_loop(name, found.bandwidth, delay, gains=gains)
    assert np.max(np.abs(expected)) == pytest.approx(bound, rel=2e-3)
    faster = design(name, 1.1 * found.bandwidth, gains=gains, delay=delay)
    assert faster.maximum_sensitivity > bound * 1.01


@observing
def test_design_scales_with_inertia_and_period(name):
    slow = design(name, gains=pi_gains(INERTIA, 8.0))
    fast = design(name, gains=pi_gains(0.1 * INERTIA, 80.0), inertia=0.1 * INERTIA, period=0.1 * PERIOD)
    assert fast.bandwidth == pytest.approx(10.0 * slow.bandwidth, rel=1e-6)
    assert fast.crossover == pytest.approx(10.0 * slow.crossover, rel=1e-6)
