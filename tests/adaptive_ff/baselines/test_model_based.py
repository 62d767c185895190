"""A loop with an assumed model: what it refuses, and a disturbance observer around it."""

import math

import numpy as np
import pytest

from adaptive_ff import TorqueModel, load_scenario, simulate
from adaptive_ff.baselines.model_based import ModelBased
from adaptive_ff.baselines.observed_model import ObservedModel
from controllers import DisturbanceObserver

SCENARIO = load_scenario().modified(duration=12.0)
PERIOD = SCENARIO.sampling.period
NOTHING = TorqueModel(20.0, 0.0, 0.0, 0.0, 0.0, 0.05, 1.0)
NO_JOINT = {"inertia": -1.0, "coulomb": -1.0, "friction_lag": math.nan, "stribeck_velocity": 0.0, "offset": math.inf}


@pytest.mark.parametrize(("field", "value"), NO_JOINT.items())
def test_model_that_no_joint_has_is_refused_by_name(field, value):
    good = TorqueModel(20.0, 60.0, 90.0, 80.0, 0.02, 0.05, 1.0)
    bad = good._replace(**{field: value})
    with pytest.raises(ValueError, match=rf"^model\.{field} = "):
        ModelBased(100.0, 1000.0, 0.01, bad)
    with pytest.raises(ValueError, match=rf"^changes\[0\]\.{field} = "):
        ModelBased(100.0, 1000.0, 0.01, good, [(1.0, bad)])
    with pytest.raises(TypeError, match=r"^model = None is not allowed: it must be a TorqueModel"):
        ModelBased(100.0, 1000.0, 0.01, None)


@pytest.mark.parametrize("delay", [0.0, 0.01])
def test_without_friction_in_the_model_it_is_the_disturbance_observer(delay):
    scenario = SCENARIO.modified(actuator={"delay": delay}, feedback={"bandwidth": 5.0})
    gains = scenario.feedback.gains
    plain = DisturbanceObserver(*gains, PERIOD, inertia=20.0, bandwidth=4.0, delay=scenario.delay)
    own = ObservedModel(*gains, PERIOD, NOTHING, bandwidth=4.0, delay=scenario.delay)
    expected = simulate(scenario, plain)
    assert np.array_equal(simulate(scenario, own).velocity, expected.velocity)
