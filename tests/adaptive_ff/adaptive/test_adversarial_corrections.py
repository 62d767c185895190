"""Corrections of an outer loop that mean harm: the adaptive part stays bounded, the joint near what PI makes of it.

``python -m benchmarks run corrections`` computes the same for other plans and more seeds.
"""

import math

import numpy as np
import pytest

from adaptive_ff import WITH_GRAVITY
from controllers import PI
from tests.helpers.driven_joint import GAINS, PERIOD, drive, known_position, make, reference_joint, rms

DRAWS = np.random.default_rng(101).uniform(-0.2, 0.2, 4000)

ADVERSARIES = {
    "square wave": lambda time, position: 0.2 * math.copysign(1.0, math.sin(9.0 * time)),
    "every sample": lambda time, position: 0.2 * (-1.0) ** round(time / PERIOD),
    "random": lambda time, position: float(DRAWS[round(time / PERIOD)]),
    "runs away from where it is": lambda time, position: 0.2 * math.copysign(1.0, math.sin(5.0 * position)),
}


@pytest.mark.parametrize("name", ADVERSARIES)
def test_adversarial_corrections_leave_the_adaptive_part_bounded(name):
    adaptive, runs, given = make(WITH_GRAVITY, torque_limit=400.0), {}, {"position": known_position, "limit": 400.0}
    for label, controller in (("pi", PI(*GAINS, PERIOD)), ("adaptive", adaptive)):
        joint = reference_joint()
        drive(controller, joint, 0.0, 12.0, **given)
        second = drive(controller, joint, 12.0, 24.0, correction=ADVERSARIES[name], **given)
        follows = np.array(
            [ADVERSARIES[name](time, angle) for time, angle in zip(second.time, second.position, strict=True)]
        )
        runs[label] = rms(second.error + follows)
    assert runs["adaptive"] < 1.1 * runs["pi"]
    for parameter in ("coulomb", "stiction", "offset", "gravity_sin", "gravity_cos"):
        assert abs(adaptive.estimates[parameter]) <= 800.0
