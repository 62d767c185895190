"""The sampled loop: its margins, and as python-control systems against the design and the simulated joint.

The filter that a velocity made of positions is, is part of it.
"""

import math

import control
import numpy as np
import pytest
from scipy.signal import lfilter

from adaptive_ff import load_scenario
from adaptive_ff.comparison.registry import observer_bandwidth
from controllers import (
    PI,
    DisturbanceObserver,
    ExtendedState,
    difference_velocity,
    kalman_velocity,
    kalman_velocity_gains,
    loop_margins_of,
    loop_systems,
)
from controllers.design.margins import loop_margins
from controllers.design.observer_design import SLOWEST, disturbance_observer_compensation
from controllers.design.sampled_loop import SampledLoop, open_loop
from controllers.design.velocity_filter import NO_FILTER, filter_of
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
