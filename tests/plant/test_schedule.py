import math

import pytest
from pydantic import ValidationError

from plant import (
    FrictionChange,
    JointModel,
    JointParameters,
    Stribeck,
    joint_in_phase,
    schedule,
    sliding_friction,
)

FORWARD, BACKWARD = Stribeck(60.0, 90.0, 80.0, 0.05, 1.0), Stribeck(40.0, 50.0, 90.0, 0.05, 1.0)
JOINT = JointParameters(20.0, FORWARD, BACKWARD, 7.0, 0.02)


def changes(*pairs):
    return [FrictionChange(time=time, friction_scale=scale) for time, scale in pairs]


def test_joint_without_changes_has_one_phase_and_keeps_its_friction():
    plan = schedule(JOINT, [], 0.001)
    assert plan.starts.tolist() == [0]
    assert joint_in_phase(plan, 0) == JOINT


def test_each_phase_scales_the_original_friction_and_nothing_else():
    plan = schedule(JOINT, changes((1.0, 0.6), (2.0, 1.5)), 0.001)
    assert plan.starts.tolist() == [0, 1000, 2000]
    for phase, scale in enumerate((1.0, 0.6, 1.5)):
        joint = joint_in_phase(plan, phase)
        assert (joint.inertia, joint.offset, joint.friction_lag) == (20.0, 7.0, 0.02)
        assert joint.friction[3:] == (0.05, 1.0)
        for speed in (0.0, 0.02, 0.3):
            for curve, original in ((joint.friction, FORWARD), (joint.backward, BACKWARD)):
                expected = scale * sliding_friction(original, speed)  # not of the phase before
                assert sliding_friction(curve, speed) == pytest.approx(expected, rel=1e-14)


@pytest.mark.parametrize(
    ("time", "period", "start"),
    [
        (0.0, 0.001, 0),
        (0.3, 0.1, 3),  # 0.3/0.1 is 2.9999999999999996
        (0.07, 0.01, 7),  # 0.07/0.01 is 7.000000000000001
        (0.0011, 0.001, 2),  # between two solver steps: the later of them
        (0.0019, 0.001, 2),
        (30.0, 0.001, 30_000),
        (3600.0, 0.0001, 36_000_000),
    ],
)
def test_change_takes_effect_at_the_first_solver_step_not_before_its_time(time, period, start):
    heavy = JOINT._replace(inertia=1000.0)  # its implicit step is unique with all of these periods
    assert schedule(heavy, changes((time, 0.5)), period).starts.tolist() == [0, start]


@pytest.mark.parametrize("times", [(2.0, 1.0), (1.0, 1.0), (1.0, 3.0, 2.0)])
def test_times_that_do_not_ascend_are_refused(times):
    with pytest.raises(ValueError, match=r"time = .* s follows .* s; .* must ascend"):
        schedule(JOINT, changes(*((time, 0.5) for time in times)), 0.001)


def test_change_that_makes_the_implicit_step_ambiguous_is_refused():
    accepted = JointModel(
        inertia=20.0,
        coulomb=60.0,
        stiction=90.0,
        viscous=80.0,
        stribeck_velocity=0.05,
        solver_period=0.03,
    )
    assert schedule(accepted.parameters, changes((3.0, 1.2)), 0.03).starts.tolist() == [0, 100]
    with pytest.raises(ValueError, match="too long for this joint"):
        schedule(accepted.parameters, changes((3.0, 1.5)), 0.03)


@pytest.mark.parametrize("field", ["time", "friction_scale"])
@pytest.mark.parametrize("value", [-1.0, math.nan, math.inf, "1", True, None])
def test_change_refuses_a_wrong_value_and_names_the_field(field, value):
    with pytest.raises(ValidationError) as caught:
        FrictionChange(**{"time": 1.0, "friction_scale": 0.6, field: value})
    assert [error["loc"] for error in caught.value.errors()] == [(field,)]


def test_change_refuses_a_vanishing_scale_and_an_unknown_field():
    with pytest.raises(ValidationError, match="friction_scale"):
        FrictionChange(time=1.0, friction_scale=0.0)
    with pytest.raises(ValidationError, match="duration"):
        FrictionChange(time=1.0, friction_scale=0.5, duration=1.0)
