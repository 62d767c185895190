"""Single precision learns what double precision does, also where samples come fast and teach little each."""

import math

import numpy as np
import pytest
from exports import needs_gcc

from adaptive_ff import AdaptiveController, run_in_c
from controllers import PI

PERIOD = 5e-5


def learnt(controller, seconds=1.0, seed=1):
    """Estimates after a run with a joint of 20 kg m^2 that slides."""
    draws = 0.002 * np.random.default_rng(seed).standard_normal(round(seconds / PERIOD))
    time = PERIOD * np.arange(draws.size + 1)
    plan = (0.15 * np.sin(2.0 * time) + 0.09 * np.sin(4.6 * time + 1.0) + 0.06 * np.sin(0.74 * time + 2.0)).tolist()
    velocity, torque = 0.0, 0.0
    for k, draw in enumerate(draws.tolist()):
        torque = controller.step(plan[k], velocity + draw, next_reference=plan[k + 1], realised_torque=torque)
        direction = math.copysign(1.0, velocity if velocity != 0.0 else torque)
        friction = 60.0 + 20.0 * math.exp(-abs(velocity) / 0.05) + 100.0 * abs(velocity)
        if velocity != 0.0 or abs(torque) > friction:
            velocity += PERIOD / 20.0 * (torque - direction * friction)
            velocity = 0.0 if velocity * direction < 0.0 else velocity
    return controller.estimates


@needs_gcc
def test_what_is_learnt_at_20_khz_is_what_double_precision_learns():
    pytest.importorskip("cffi", reason="cffi is not installed")
    gains = PI.design(inertia=20.0, period=PERIOD, bandwidth=50.0)
    controller = AdaptiveController(gains.proportional, gains.integral, PERIOD, inertia=20.0, stribeck_velocity=0.05)
    single, double = learnt(run_in_c(controller, single=True)), learnt(run_in_c(controller))
    assert single["stribeck_velocity"] == pytest.approx(double["stribeck_velocity"], rel=0.05)
    assert single["coulomb"] == pytest.approx(double["coulomb"], rel=0.05)
    assert single["friction_lag"] == pytest.approx(double["friction_lag"], abs=1e-3)
