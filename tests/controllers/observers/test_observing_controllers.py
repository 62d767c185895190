"""What the controllers with an observer have in common."""

import numpy as np
import pytest
from inertia_loops import GAINS, INERTIA, OBSERVING, PERIOD, make_observing, run_inertia

observing = pytest.mark.parametrize("name", OBSERVING)
REST = np.zeros(600)


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
