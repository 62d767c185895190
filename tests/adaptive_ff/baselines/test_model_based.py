"""Loops with an assumed model: what they refuse, a disturbance observer around them, friction along a plan."""

import itertools
import math

import numpy as np
import pytest
from closed_loops import SCENARIO
from scipy.integrate import solve_ivp

from adaptive_ff import TorqueModel, simulate
from adaptive_ff.baselines import FrictionObserver
from adaptive_ff.baselines.friction_observer import PreslidingState, mobilised_fraction, step_presliding
from adaptive_ff.baselines.model_based import ModelBased
from adaptive_ff.baselines.observed_model import ObservedModel
from controllers import DisturbanceObserver

PERIOD = SCENARIO.sampling.period
MODEL = TorqueModel(20.0, 60.0, 90.0, 80.0, 0.02, 0.05, 1.0)
NOTHING = TorqueModel(20.0, 0.0, 0.0, 0.0, 0.0, 0.05, 1.0)
NO_JOINT = {"inertia": -1.0, "coulomb": -1.0, "friction_lag": math.nan, "stribeck_velocity": 0.0, "offset": math.inf}


@pytest.mark.parametrize(("field", "value"), NO_JOINT.items())
def test_model_that_no_joint_has_is_refused_by_name(field, value):
    bad = MODEL._replace(**{field: value})
    with pytest.raises(ValueError, match=rf"^model\.{field} = "):
        ModelBased(100.0, 1000.0, 0.01, bad)
    with pytest.raises(ValueError, match=rf"^changes\[0\]\.{field} = "):
        ModelBased(100.0, 1000.0, 0.01, MODEL, [(1.0, bad)])
    with pytest.raises(TypeError, match=r"^model = None is not allowed: it must be a TorqueModel"):
        ModelBased(100.0, 1000.0, 0.01, None)


@pytest.mark.parametrize("delay", [0.0, 0.01])
def test_without_friction_in_the_model_it_is_the_disturbance_observer(delay):
    scenario = SCENARIO.modified(duration=12.0, actuator={"delay": delay}, feedback={"bandwidth": 5.0})
    gains = scenario.feedback.gains
    plain = DisturbanceObserver(*gains, PERIOD, inertia=20.0, bandwidth=4.0, delay=scenario.delay)
    own = ObservedModel(*gains, PERIOD, NOTHING, bandwidth=4.0, delay=scenario.delay)
    expected = simulate(scenario, plain)
    assert np.array_equal(simulate(scenario, own).velocity, expected.velocity)


def test_mobilised_fraction_runs_along_the_curve_from_reversal_to_reversal():
    for z in (0.1, 0.5, 0.9):
        assert mobilised_fraction(2e-3, 1.0, -2e-3 * z) == pytest.approx(1.0 - 2.0 * z * (1.0 - math.log(z)), rel=1e-12)
        assert mobilised_fraction(2e-3, 0.0, 2e-3 * z) == pytest.approx(z * (1.0 - math.log(z)), rel=1e-12)
    assert mobilised_fraction(2e-3, -0.4, 0.0) == -0.4
    assert mobilised_fraction(2e-3, -0.4, 5e-3) == pytest.approx(1.0, rel=1e-15)


def way(time):
    """Planned position; the plan reverses after a second."""
    slow, fast = 1.0 - math.cos(math.pi * time), 1.0 - math.cos(3.0 * math.pi * time)
    return 0.2 / math.pi * slow + 0.1 / (3.0 * math.pi) * fast


def rise(displacement):
    part = min(max(displacement / 0.02, 1e-300), 1.0)
    return part * (1.0 - math.log(part))


def test_friction_solves_the_differential_equation_of_its_lag():
    """On the virgin curve and the branch after a reversal, in periods short enough to take the plan as linear."""
    period, model = 1e-4, MODEL._replace(stiction=60.0, viscous=0.0)

    def target(time):
        if time < 1.0:
            return 60.0 * rise(way(time))
        return 60.0 * (1.0 - 2.0 * rise(way(1.0) - way(time)))

    gains = {"proportional": 1256.0, "integral": 15_000.0, "velocity_gain": 0.3, "disturbance_gain": 100.0}
    block = FrictionObserver(**gains, period=period, model=model, presliding=0.02).parameters
    times, state, found = np.arange(13_001) * period, PreslidingState(0.0, 0.0, 0.0), []
    plan = 0.2 * np.sin(math.pi * times) + 0.1 * np.sin(3.0 * math.pi * times)
    for now, following in itertools.pairwise(plan.tolist()):  # the mean in each period
        friction, state = step_presliding(block, state, now, following)
        found.append(friction)
    end = float(times[-1])
    options = {"rtol": 1e-9, "atol": 1e-9, "max_step": 1e-3, "t_eval": times}
    exact = solve_ivp(lambda t, f: (target(t) - f) / model.friction_lag, (0.0, end), [0.0], **options).y[0]
    assert np.ptp(exact) > 110.0
    assert found == pytest.approx(0.5 * (exact[:-1] + exact[1:]), abs=2e-2)
