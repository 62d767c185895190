"""Fixed feedforward with a disturbance observer around it."""

import numpy as np
import pytest

from adaptive_ff import load_scenario, simulate
from adaptive_ff.baselines.observed_model import ObservedModel
from adaptive_ff.friction.model import TorqueModel
from controllers import DisturbanceObserver

SCENARIO = load_scenario().modified(duration=12.0)
PERIOD = SCENARIO.sampling.period
NOTHING = TorqueModel(20.0, 0.0, 0.0, 0.0, 0.0, 0.05, 1.0)


@pytest.mark.parametrize("delay", [0.0, 0.01])
def test_without_friction_in_the_model_it_is_the_disturbance_observer(delay):
    scenario = SCENARIO.modified(actuator={"delay": delay}, feedback={"bandwidth": 5.0})
    gains = scenario.feedback.gains
    plain = DisturbanceObserver(*gains, PERIOD, inertia=20.0, bandwidth=4.0, delay=scenario.delay)
    own = ObservedModel(*gains, PERIOD, NOTHING, bandwidth=4.0, delay=scenario.delay)
    expected = simulate(scenario, plain)
    assert np.array_equal(simulate(scenario, own).velocity, expected.velocity)
