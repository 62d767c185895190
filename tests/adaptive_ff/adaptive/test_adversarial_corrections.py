"""Corrections of an outer loop that mean harm: the adaptive part stays bounded, the joint near what PI makes of it.

``benchmarks.hostile_corrections`` prints the same for other plans and more seeds.
"""

import math

import numpy as np
import pytest

from adaptive_ff import WITH_GRAVITY, AdaptiveController
from controllers import PI, pi_gains
from tests.helpers.driven_joint import PERIOD, drive, reference_joint, rms

GAINS = pi_gains(20.0, 10.0)
DRAWS = np.random.default_rng(101).uniform(-0.2, 0.2, 4000)

ADVERSARIES = {
    "square wave": lambda time, position: 0.2 * math.copysign(1.0, math.sin(9.0 * time)),
    "every sample": lambda time, position: 0.2 * (-1.0) ** round(time / PERIOD),
    "random": lambda time, position: float(DRAWS[round(time / PERIOD)]),
    "runs away from where it is": lambda time, position: 0.2 * math.copysign(1.0, math.sin(5.0 * position)),
}


@pytest.mark.parametrize("name", ADVERSARIES)
def test_adversarial_corrections_leave_the_adaptive_part_bounded(name):
    adaptive = AdaptiveController(
        *GAINS, period=PERIOD, inertia=20.0, stribeck_velocity=0.05, parameters=WITH_GRAVITY, torque_limit=400.0
    )
    pi = PI(*GAINS, PERIOD)
    runs = {}
    for label, controller in (("pi", pi), ("adaptive", adaptive)):
        joint = reference_joint()
        drive(controller, joint, 0.0, 12.0, position=lambda time, position: position, limit=400.0)
        second = drive(
            controller,
            joint,
            12.0,
            24.0,
            position=lambda time, position: position,
            correction=ADVERSARIES[name],
            limit=400.0,
        )
        follows = np.array(
            [ADVERSARIES[name](time, angle) for time, angle in zip(second.time, second.position, strict=True)]
        )
        runs[label] = rms(second.error + follows)
    assert runs["adaptive"] < 1.1 * runs["pi"]
    largest = 800.0
    assert largest <= 800.0
    for parameter in ("coulomb", "stiction", "offset", "gravity_sin", "gravity_cos"):
        assert abs(adaptive.estimates[parameter]) <= largest
