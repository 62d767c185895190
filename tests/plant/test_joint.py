import math
import re

import pytest
from pydantic import ValidationError
from stepped_joint import FRICTION

from plant import Joint, JointModel, JointState, step_joint, whole_multiple

REFERENCE = {"inertia": 20.0, **FRICTION, "stribeck_shape": 1.0, "friction_lag": 0.02, "solver_period": 0.001}


@pytest.mark.parametrize("viscous_backward", [None, 40.0])
def test_longest_solver_period_is_that_of_the_uniqueness_condition_in_the_steeper_direction(viscous_backward):
    # kappa max(-F') < 1 with tau = 0: h < J/((Fs - Fc)/Vs - sigma)
    longest = 20.0 / (30.0 / 0.05 - (viscous_backward or 80.0))
    accepted = {**REFERENCE, "friction_lag": 0.0, "viscous_backward": viscous_backward}
    assert JointModel(**{**accepted, "solver_period": 0.9999 * longest}).friction_lag == 0.0
    with pytest.raises(ValidationError, match="is too long"):
        JointModel(**{**accepted, "solver_period": 1.0001 * longest})


def test_braking_distance_of_each_direction_in_closed_form():
    fields = {"stiction": 60.0, "viscous": 0.0, "coulomb_backward": 30.0, "stiction_backward": 30.0, "offset": 6.0}
    model = JointModel(**{**REFERENCE, **fields, "friction_lag": 0.0, "solver_period": 1e-4})
    for velocity, deceleration in ((0.3, 66.0 / 20.0), (-0.3, 24.0 / 20.0)):
        joint = Joint(model, velocity)
        assert joint.step(0.0, 1.0) == 0.0
        expected = math.copysign(0.045 / deceleration, velocity)
        assert joint.state.position == pytest.approx(expected, abs=0.51 * 1e-4 * 0.3)


@pytest.mark.parametrize("lag", [0.0, 0.02])
def test_longest_solver_period_for_a_shape_below_one_is_where_breakaway_jumps_by_a_hundredth_of_vs(lag):
    fields = {**REFERENCE, "stribeck_shape": 0.7, "friction_lag": lag}
    with pytest.raises(ValidationError, match="is too long") as caught:
        JointModel(**{**fields, "solver_period": 1.0})
    period = 0.99 * float(re.search(r"beyond (\S+) s", str(caught.value))[1])
    joint = JointModel(**{**fields, "solver_period": period}).parameters
    jump = step_joint(joint, JointState(0.0, 90.0, 0.0), 90.0 * (1.0 + 1e-12), period).velocity
    assert jump == pytest.approx(0.01 * 0.05, rel=0.1)


def test_model_without_a_falling_curve_takes_any_solver_period():
    assert JointModel(**{**REFERENCE, "stiction": 60.0, "solver_period": 1e3}).solver_period == 1e3


def test_joint_rests_at_the_start_and_below_breakaway():
    joint = Joint(JointModel(**{**REFERENCE, "friction_lag": 0.0}))
    assert joint.state == (0.0, 0.0, 0.0)
    assert joint.step(89.0, 1.0) == 0.0
    assert joint.step(-89.0, 1.0) == 0.0
    assert joint.step(95.0, 1.0) > 0.0


def test_one_long_step_is_many_short_ones():
    once, often = Joint(JointModel(**REFERENCE), 0.2), Joint(JointModel(**REFERENCE), 0.2)
    velocity = once.step(-40.0, 0.1)
    for _ in range(100):
        last = often.step(-40.0, 0.001)
    assert last == velocity
    assert often.state == once.state


@pytest.mark.parametrize("duration", [0.0, -0.01, 0.0005, 0.0015, 1.00025, math.nan, math.inf])
def test_step_refuses_a_duration_that_is_no_whole_number_of_periods(duration):
    joint = Joint(JointModel(**REFERENCE), 0.2)
    before = joint.state
    with pytest.raises(ValueError, match=r"duration = .* whole number of solver periods of 0\.001 s"):
        joint.step(0.0, duration)
    assert joint.state == before


@pytest.mark.parametrize(
    ("duration", "period", "expected"),
    [
        (0.001, 0.001, 1),
        (0.3, 0.1, 3),  # 0.3/0.1 is 2.9999999999999996
        (0.022, 0.001, 22),
        (3600.0, 1e-4, 36_000_000),
        (0.0005, 0.001, None),
        (0.0014, 0.001, None),
        (0.0, 0.001, None),
        (-0.001, 0.001, None),
        (1000.0004, 0.001, None),
        (math.nan, 0.001, None),
        (math.inf, 0.001, None),
    ],
)
def test_whole_multiple(duration, period, expected):
    assert whole_multiple(duration, period) == expected
