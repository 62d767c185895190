"""What the controllers with an observer have in common."""

import math

import numpy as np
import pytest
from inertia_loops import GAINS, INERTIA, OBSERVING, PERIOD, make_observing, response, run_inertia, z_transform

observing = pytest.mark.parametrize("name", OBSERVING)
REST = np.zeros(600)


def q_filter(controller, bandwidth):
    """From a load to its estimate of the next sample: one pole, two equal ones, or those of the settled gains."""
    z, kept, found = z_transform(), math.exp(-2.0 * math.pi * bandwidth * PERIOD), controller.parameters
    if type(controller).__name__ != "KalmanDisturbance":
        poles = 1 if type(controller).__name__ == "DisturbanceObserver" else 2
        return ((1.0 - kept) * z / (z - kept)) ** poles
    corrected = PERIOD / INERTIA * found.disturbance_gain
    return corrected * z**2 / ((z - 1) * (z - (1.0 - found.velocity_gain)) + corrected * z)


@observing
def test_estimate_is_the_load_behind_the_q_filter_and_a_period(name):
    controller = make_observing(name, 6.0)
    reference, load = np.array([[1.0], [40.0]]) * np.random.default_rng(4).standard_normal((2, 500))
    _, disturbance = run_inertia(controller, reference, load=load)
    assert disturbance == pytest.approx(response(q_filter(controller, 6.0) / z_transform(), load), abs=1e-7)


@pytest.mark.parametrize("name", ["DisturbanceObserver", "KalmanDisturbance"])
def test_loads_reach_the_velocity_through_one_minus_q_as_umeno_and_hori_have_it(name):
    """``w/d = -P (1 - Q/z)/(1 + P C)``: the loop of the PI alone, times what the observer leaves."""
    z, controller = z_transform(), make_observing(name, 6.0)
    feedback, inertia = GAINS[0] + GAINS[1] * PERIOD * z / (z - 1), PERIOD / INERTIA / (z - 1)
    load = 40.0 * np.random.default_rng(3).standard_normal(500)
    velocity, _ = run_inertia(controller, np.zeros(500), load=load)
    left = 1 - q_filter(controller, 6.0) / z
    assert np.max(np.abs(velocity)) > 0.05
    assert velocity == pytest.approx(response(-inertia * left / (1 + inertia * feedback), load), abs=1e-9)


@observing
@pytest.mark.parametrize("load", [37.0, -5.0])
def test_constant_load_is_removed_exactly_without_an_integral(name, load):
    controller = make_observing(name, 8.0, gains=(GAINS[0], 0.0))
    velocity, disturbance = run_inertia(controller, REST, load=load)
    assert np.max(np.abs(velocity)) > 0.01 * abs(load) / INERTIA
    assert velocity[-1] == pytest.approx(0.0, abs=1e-12)
    assert disturbance[-1] == pytest.approx(load, rel=1e-12)


@observing
def test_known_load_that_is_told_does_not_appear_in_the_estimate(name):
    load = 30.0 + 20.0 * np.sin(0.05 * np.arange(600))
    velocity, disturbance = run_inertia(make_observing(name, 8.0), REST, load=load, known=load)
    assert np.max(np.abs(disturbance)) < 1e-10
    assert np.max(np.abs(velocity)) < 1e-12
    _, untold = run_inertia(make_observing(name, 8.0), REST, load=load)
    assert np.max(np.abs(untold)) > 40.0


@observing
def test_nominal_inertia_follows_any_previewed_reference_without_the_feedback(name):
    reference = np.random.default_rng(1).standard_normal(200)
    controller = make_observing(name, 8.0)
    velocity, disturbance = run_inertia(controller, reference, velocity=reference[0])
    assert velocity == pytest.approx(reference, abs=1e-9)
    assert np.max(np.abs(disturbance)) < 1e-8 * np.max(np.abs(np.diff(reference))) * INERTIA / PERIOD
