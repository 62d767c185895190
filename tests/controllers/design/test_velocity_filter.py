"""The filter that a velocity made of positions is, for the design of loops."""

import math

import numpy as np
import pytest
from scipy.signal import lfilter

from adaptive_ff import load_scenario
from adaptive_ff.comparison.registry import observer_bandwidth
from controllers import DisturbanceObserver, ExtendedState, difference_velocity, kalman_velocity, kalman_velocity_gains
from controllers.design.observer_design import SLOWEST, disturbance_observer_compensation
from controllers.design.sampled_loop import SampledLoop, open_loop
from controllers.design.velocity_filter import NO_FILTER, filter_of
from controllers.velocity import VELOCITY_ESTIMATORS, direct_velocity, initial_velocity_state, low_pass_velocity

PERIOD = 0.01
ESTIMATORS = {
    "difference": difference_velocity(PERIOD),
    "low-pass": low_pass_velocity(30.0, PERIOD),
    "kalman": kalman_velocity(*kalman_velocity_gains(4.4e-4, 20.0, PERIOD), PERIOD),
}
COARSE = {"velocity_noise": 0.0, "encoder_resolution": 2.0 * math.pi / 4096}


@pytest.mark.parametrize("name", ESTIMATORS)
def test_filter_is_what_the_estimator_makes_of_a_joint_that_accelerates_evenly_in_each_period(name):
    estimator, velocity = ESTIMATORS[name], np.random.default_rng(1).standard_normal(200)
    velocity[0] = 0.0
    position = np.concatenate([[0.0], np.cumsum(0.5 * PERIOD * (velocity[1:] + velocity[:-1]))])
    state, found = initial_velocity_state(estimator, 0.0, 0.0), []
    for reading in position:
        value, state = VELOCITY_ESTIMATORS[type(estimator)](estimator, state, reading, PERIOD)
        found.append(value)
    made = filter_of(estimator)
    assert found == pytest.approx(lfilter(made.numerator[::-1], made.denominator[::-1], velocity), abs=1e-12)
    assert sum(made.numerator) == pytest.approx(sum(made.denominator), rel=1e-9)


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
