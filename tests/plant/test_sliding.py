"""The speed of a sliding joint at the end of an implicit step: what it solves, and with how much work."""

import itertools
from unittest.mock import patch

import numpy as np
import pytest

import plant
from plant import elasto_plastic, lugre, maxwell, sliding
from plant.friction import Stribeck, sliding_friction, steepest_fall
from plant.kinds import ElastoPlasticJoint, LuGreJoint, MaxwellJoint

SHAPES, TIMES = (0.7, 1.0, 2.0, 3.5), (1.0 + 1e-12, 1.0 + 1e-6, 1.01, 1.3, 2.0, 10.0, 1e3)
"""Shapes of the curve, and free speeds over that at which a joint breaks away."""


WORK = [(0.7, 1624, 1602), (1.0, 1367, 301), (2.0, 2491, 1322), (3.5, 2109, 1319)]
"""How often friction is asked for by shape: with speeds guessed, and with those that friction before tells."""


def steps(shape):
    """Yield friction, free speed and ``kappa`` of steps of all sizes that have one solution."""
    for stiction, viscous in itertools.product((60.0, 90.0), (0.0, 80.0, 900.0)):
        curve = Stribeck(60.0, stiction, viscous, 0.05, shape)
        for kappa, times in itertools.product((1e-6, 1e-4, 0.7 / max(min(steepest_fall(curve), 600.0), 1.0)), TIMES):
            yield curve, times * kappa * stiction, kappa


def work(calls):
    """Return how often friction is asked for by Newton's method in some calls; each solves its step."""
    with patch.object(sliding, "sliding_friction_and_slope", wraps=sliding.sliding_friction_and_slope) as asked:
        for curve, free, kappa, function, *arguments in calls:
            speed = function(*arguments)
            assert speed + kappa * sliding_friction(curve, speed) == pytest.approx(free, rel=1e-14)
            assert (free - kappa * curve.stiction) <= speed * (1.0 + kappa * curve.viscous) * (1.0 + 1e-15)
    return asked.call_count


def from_guesses(shape):
    for curve, free, kappa in steps(shape):
        high = (free - kappa * curve.coulomb) / (1.0 + kappa * curve.viscous)
        for guess in (0.0, 0.5 * high, high, 3.0 * free):
            yield curve, free, kappa, sliding.sliding_speed, curve, free, kappa, guess


def from_friction_before(shape):
    for curve, free, kappa in steps(shape):
        direction, speed = sliding.direction_of(curve, kappa), sliding.sliding_speed(curve, free, kappa, 0.0)
        for near in (0.0, 0.9, 0.999, 1.0, 1.001, 1.5):
            before = sliding_friction(curve, near * speed)
            yield curve, free, kappa, sliding.speed_in_direction, direction, free, before


@pytest.mark.parametrize(("shape", "guessed", "followed"), WORK)
def test_speed_is_found_with_as_much_work_as_it_takes(shape, guessed, followed):
    found = work(list(from_guesses(shape))), work(list(from_friction_before(shape)))
    assert found == pytest.approx((guessed, followed), rel=0.02)


CURVE = {"inertia": 20.0, "coulomb": 60.0, "stiction": 90.0, "viscous": 80.0, "stribeck_velocity": 0.05}
JOINTS = [
    (lugre, LuGreJoint(**CURVE, stiffness=2e4, damping=100.0), 1217),
    (lugre, LuGreJoint(**CURVE, stiffness=2e5, damping=10.0, coulomb_backward=50.0, stiction_backward=55.0), 1208),
    (maxwell, MaxwellJoint(**CURVE, displacements=[3e-4, 1e-3, 2e-3, 4e-3], attraction=5e3), 1171),
    (elasto_plastic, ElastoPlasticJoint(**CURVE, presliding=1e-3, friction_lag=0.01), 1069),
    (elasto_plastic, ElastoPlasticJoint(**CURVE, presliding=5e-3, viscous_backward=20.0), 1196),
]
"""Joints whose step is solved by Newton's method, and how many steps of it that takes."""


@pytest.mark.parametrize(("module", "model", "expected"), JOINTS)
def test_joint_is_stepped_with_as_much_work_as_it_takes(module, model, expected):
    joint = plant.Joint(model, velocity=0.02)
    time = 1e-3 * np.arange(400)
    torques = 140.0 * np.sin(20.0 * time) + 60.0 * np.sin(71.0 * time) + 500.0 * (time % 0.1 < 0.005)
    with patch.object(module, "next_speed", wraps=sliding.next_speed) as taken:
        for torque in torques:
            joint.step(torque, 1e-3)
    assert taken.call_count == pytest.approx(expected, rel=0.02)
