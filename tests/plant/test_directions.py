"""Friction per direction, and a constant offset."""

import math

import pytest
from drawn_joints import FRICTION
from pydantic import ValidationError

from plant import Joint, JointModel

FIELDS = {"inertia": 20.0, **FRICTION}


def run(model, torque, duration, velocity=0.0):
    joint = Joint(model, velocity)
    joint.step(torque, duration)
    return joint.state


def test_braking_distance_of_each_direction_in_closed_form():
    fields = {**FIELDS, "stiction": 60.0, "viscous": 0.0, "coulomb_backward": 30.0, "stiction_backward": 30.0}
    model = JointModel(**fields, offset=6.0, solver_period=1e-4)
    for velocity, deceleration in ((0.3, 66.0 / 20.0), (-0.3, 24.0 / 20.0)):
        end = run(model, 0.0, 1.0, velocity)
        assert end.velocity == 0.0
        assert end.position == pytest.approx(math.copysign(0.045 / deceleration, velocity), abs=0.51 * 1e-4 * 0.3)


@pytest.mark.parametrize(
    ("fields", "message"),
    [
        ({"stiction_backward": 59.0}, "stiction_backward = 59 N m is less than coulomb_backward = 60 N m"),
        ({"coulomb_backward": 91.0}, "stiction_backward = 90 N m is less than coulomb_backward = 91 N m"),
    ],
)
def test_stiction_below_coulomb_is_refused_in_either_direction(fields, message):
    with pytest.raises(ValidationError, match=message):
        JointModel(**{**FIELDS, **fields})


def test_longest_solver_period_is_that_of_the_steeper_direction():
    # h < J/((Fs - Fc)/Vs - sigma), backward 20/(30/0.05 - 40)
    fields = {**FIELDS, "viscous_backward": 40.0}
    assert JointModel(**fields, solver_period=0.999 * 20.0 / 560.0).friction_lag == 0.0
    with pytest.raises(ValidationError, match="is too long"):
        JointModel(**fields, solver_period=1.001 * 20.0 / 560.0)
