"""Fixed feedforward with a disturbance observer around it."""

import math

import numpy as np
import pytest

from adaptive_ff import load_scenario, simulate
from adaptive_ff.baselines.model_based import ModelBased
from adaptive_ff.baselines.observed_model import ObservedModel
from adaptive_ff.comparison.registry import make_controller
from adaptive_ff.friction.model import TorqueModel
from adaptive_ff.scenario.truth import true_model
from controllers import DisturbanceObserver

SCENARIO = load_scenario().modified(duration=12.0)
GAINS, PERIOD = SCENARIO.feedback.gains, SCENARIO.sampling.period
NOTHING = TorqueModel(20.0, 0.0, 0.0, 0.0, 0.0, 0.05, 1.0)


def observed(scenario, model, bandwidth=4.0):
    return ObservedModel(*GAINS, PERIOD, model, bandwidth=bandwidth, delay=scenario.delay)


@pytest.mark.parametrize("delay", [0.0, 0.01])
def test_without_friction_in_the_model_it_is_the_disturbance_observer(delay):
    scenario = SCENARIO.modified(actuator={"delay": delay}, feedback={"bandwidth": 5.0})
    gains = scenario.feedback.gains
    plain = DisturbanceObserver(*gains, PERIOD, inertia=20.0, bandwidth=4.0, delay=scenario.delay)
    own = ObservedModel(*gains, PERIOD, NOTHING, bandwidth=4.0, delay=scenario.delay)
    expected = simulate(scenario, plain)
    assert np.array_equal(simulate(scenario, own).velocity, expected.velocity)


def test_with_a_hardly_moving_observer_it_is_the_fixed_feedforward():
    truth = true_model(SCENARIO)
    expected = simulate(SCENARIO, ModelBased(*GAINS, PERIOD, truth))
    found = simulate(SCENARIO, observed(SCENARIO, truth, 1e-9))
    assert found.velocity == pytest.approx(expected.velocity, abs=1e-7)


@pytest.mark.parametrize("delay", [0.0, 0.01, 0.015])
def test_right_model_of_viscous_friction_leaves_nothing_to_observe(delay):
    """Noise-free, friction viscous and followed: what acted less what is known accelerates the inertia alone."""
    friction = {"coulomb": 0.0, "stiction": 0.0, "viscous": 80.0, "friction_lag": 0.0}
    scenario = load_scenario().modified(
        duration=12.0,
        joint=friction,
        sensor={"velocity_noise": 0.0},
        actuator={"delay": delay},
        feedback={"bandwidth": 3.0},
    )
    gains = scenario.feedback.gains
    controller = ObservedModel(*gains, PERIOD, true_model(scenario), bandwidth=2.0, delay=scenario.delay)
    simulate(scenario, controller)
    blind = DisturbanceObserver(*gains, PERIOD, inertia=20.0, bandwidth=2.0, delay=scenario.delay)
    simulate(scenario, blind)
    assert abs(blind.disturbance) > 3.0
    assert abs(controller.disturbance) < 0.25


def error_after_load(run):
    """Root of the mean squared error of the two seconds after the load, rad/s."""
    after = (run.solver_time >= 12.0) & (run.solver_time < 14.0)
    return math.sqrt(float(np.mean((run.velocity - run.reference)[after] ** 2)))


def test_it_takes_up_a_load_that_the_fixed_feedforward_does_not_know():
    scenario = load_scenario().modified(duration=30.0, change=[{"time": 12.0, "load": 60.0}])
    controller = make_controller(scenario, "observed_nominal")
    found = error_after_load(simulate(scenario, controller))
    assert controller.disturbance == pytest.approx(60.0, abs=25.0)
    assert found < 0.7 * error_after_load(simulate(scenario, "lagged_nominal"))


def test_an_inertia_must_be_given():
    with pytest.raises(ValueError, match="inertia = 0"):
        observed(SCENARIO, NOTHING._replace(inertia=0.0))
