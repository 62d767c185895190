import math

import numpy as np
import pytest
from inertia_loops import GAINS, INERTIA, OBSERVING, PERIOD, make_observing, run_inertia

from controllers import DisturbanceObserver, ExtendedState, KalmanDisturbance, pi_gains

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


@observing
@pytest.mark.parametrize(
    ("period", "delay", "bandwidth", "crossover", "integral"),
    [
        (0.01, 0, 2.0, 10.0, 1.0),
        (0.01, 0, 15.0, 10.0, 1.0),
        (0.01, 0, 15.0, 10.0, 0.0),
        (0.001, 0, 80.0, 10.0, 1.0),
        # without an integral, whose anti-windup takes a delay for saturation
        (0.01, 1, 6.0, 4.0, 0.0),
        (0.01, 2, 4.0, 3.0, 0.0),
        (0.001, 3, 40.0, 20.0, 0.0),
    ],
)
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
