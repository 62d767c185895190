"""The feed-forward friction observer: its friction along a plan, and its observer."""

import math

import numpy as np
import pytest
from scipy.integrate import solve_ivp

from adaptive_ff.baselines import FrictionObserver
from adaptive_ff.baselines.friction_observer import PreslidingState, mobilised_fraction, step_presliding
from adaptive_ff.friction.model import TorqueModel

PERIOD = 0.01
GAINS = (1256.0, 15_000.0)
MODEL = TorqueModel(20.0, 60.0, 90.0, 80.0, 0.02, 0.05, 1.0)
OBSERVER = {"velocity_gain": 0.3, "disturbance_gain": 100.0}


def plan(k):
    return 0.2 * math.sin(math.pi * PERIOD * k) + 0.1 * math.sin(3.0 * math.pi * PERIOD * k)


def along(presliding, samples, model=MODEL, period=PERIOD):
    """Mean friction in each period of the plan."""
    block = FrictionObserver(*GAINS, period, model, presliding=presliding, **OBSERVER).parameters
    state, found = PreslidingState(0.0, 0.0, 0.0), []
    for k in range(samples):
        friction, state = step_presliding(block, state, plan(k * period / PERIOD), plan((k + 1) * period / PERIOD))
        found.append(friction)
    return np.array(found)


def test_mobilised_fraction_runs_along_the_curve_from_reversal_to_reversal():
    part = np.array([0.1, 0.5, 0.9])
    for z in part.tolist():
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

    times = np.arange(13_001) * period
    end = float(times[-1])
    options = {"rtol": 1e-9, "atol": 1e-9, "max_step": 1e-3, "t_eval": times}
    exact = solve_ivp(lambda t, f: (target(t) - f) / model.friction_lag, (0.0, end), [0.0], **options).y[0]
    found = along(0.02, 13_000, model, period)
    assert np.ptp(exact) > 110.0
    assert found == pytest.approx(0.5 * (exact[:-1] + exact[1:]), abs=2e-2)
