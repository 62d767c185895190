import math

import numpy as np
import pytest
from inertia_loops import GAINS, INERTIA, PERIOD, make_observing, response, run_inertia, z_transform

BANDWIDTH = 6.0
KEPT = math.exp(-2.0 * math.pi * BANDWIDTH * PERIOD)


def blocks():
    """``Q``, PI and inertia as sampled systems, each written down from its own definition."""
    z = z_transform()
    q_filter = (1.0 - KEPT) * z / (z - KEPT)
    feedback = GAINS[0] + GAINS[1] * PERIOD * z / (z - 1)
    return z, q_filter, feedback, PERIOD / INERTIA / (z - 1)


def test_loads_reach_the_velocity_through_one_minus_q_as_umeno_and_hori_have_it():
    """``w/d = -P (1 - Q/z)/(1 + P C)``: the loop of the PI alone, times what the observer leaves."""
    z, q_filter, feedback, inertia = blocks()
    load = 40.0 * np.random.default_rng(3).standard_normal(500)
    velocity, _ = run_inertia(make_observing("DisturbanceObserver", BANDWIDTH), np.zeros(500), load=load)
    expected = response(-inertia * (1 - q_filter / z) / (1 + inertia * feedback), load)
    assert np.max(np.abs(velocity)) > 0.05
    assert velocity == pytest.approx(expected, abs=1e-9)


def test_estimate_is_the_load_behind_the_q_filter_and_a_period():
    z, q_filter, _, _ = blocks()
    load = 40.0 * np.random.default_rng(4).standard_normal(500)
    reference = np.random.default_rng(5).standard_normal(500)
    _, disturbance = run_inertia(make_observing("DisturbanceObserver", BANDWIDTH), reference, load=load)
    assert disturbance == pytest.approx(response(q_filter / z, load), abs=1e-7)


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
