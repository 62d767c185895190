import math

import numpy as np
import pytest
from inertia_loops import INERTIA, PERIOD, make_observing, run_inertia

BANDWIDTH = 6.0


def test_estimate_of_a_constant_load_approaches_it_exponentially_whatever_the_periods():
    """Ohnishi's first-order filter: ``d (1 - exp(-g t))`` at any time, jittered or after gaps."""
    generator = np.random.default_rng(6)
    dt = PERIOD * generator.uniform(0.3, 1.7, 60)
    gaps = np.where(generator.uniform(size=60) < 0.2, math.nan, 0.0)
    gaps[0] = 0.0
    _, disturbance = run_inertia(
        make_observing("DisturbanceObserver", BANDWIDTH), np.zeros(60), load=25.0, dt=dt, disturbance=gaps
    )
    time = np.concatenate([[0.0], np.cumsum(dt)[:-1]])
    valid = np.isfinite(gaps)
    assert np.count_nonzero(~valid) > 5
    expected = 25.0 * -np.expm1(-2.0 * math.pi * BANDWIDTH * time)
    assert disturbance[valid] == pytest.approx(expected[valid], rel=1e-9)


def test_wrong_inertia_shows_as_a_disturbance_while_the_joint_accelerates():
    """20 % more inertia than assumed: the missing torque is ``0.2 Jn dw/dt``."""
    controller = make_observing("DisturbanceObserver", BANDWIDTH)
    ramp = 0.02 * np.arange(1500)
    velocity, disturbance = run_inertia(controller, ramp, inertia=1.2 * INERTIA)
    assert disturbance[-1] == pytest.approx(0.2 * INERTIA * 0.02 / PERIOD, rel=1e-6)
    assert velocity[-1] == pytest.approx(ramp[-1], abs=1e-6)
