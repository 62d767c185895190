"""The static friction map, and the joint as a user meets it."""

import math
import re

import numpy as np
import pytest
from hypothesis import assume, given
from hypothesis import strategies as st
from pydantic import ValidationError
from stepped_joint import FRICTION

from plant import Joint, JointModel, JointState, Stribeck, sliding_friction, step_joint, stribeck_decay, whole_multiple
from plant.friction import scaled, sliding_friction_and_slope, steepest_fall, yield_torque

SHAPES = (0.7, 1.0, 1.5, 2.0, 3.0)
ANY_SHAPE = st.sampled_from(SHAPES) | st.floats(0.3, 4.0)
STEEP_SHAPE = st.sampled_from((1.0, 1.5, 2.0, 3.0)) | st.floats(1.0, 4.0)


def none_or(most):
    return st.just(0.0) | st.floats(1e-3, most)


@st.composite
def frictions(draw, shapes=ANY_SHAPE, least_excess=0.0):
    coulomb = draw(none_or(200.0))
    stiction = coulomb + draw(st.floats(least_excess, 100.0) if least_excess else none_or(100.0))
    return Stribeck(coulomb, stiction, draw(none_or(200.0)), draw(st.floats(1e-3, 1.0)), draw(shapes))


@pytest.mark.parametrize(
    ("shape", "speed", "expected"),
    [
        (1.0, 0.05, 60.0 + 30.0 * 0.36787944117144233 + 4.0),  # exp(-1)
        (2.0, 0.10, 60.0 + 30.0 * 0.01831563888873418 + 8.0),  # exp(-4)
        (0.5, 0.20, 60.0 + 30.0 * 0.1353352832366127 + 16.0),  # exp(-2)
        (3.0, 0.10, 60.0 + 30.0 * 0.00033546262790251185 + 8.0),  # exp(-8)
    ],
)
def test_map_agrees_with_equation_3_worked_out_by_hand(shape, speed, expected):
    assert sliding_friction(Stribeck(60.0, 90.0, 80.0, 0.05, shape), speed) == pytest.approx(expected, rel=1e-14)


@given(frictions(), st.floats(0.0, 10.0))
def test_sliding_friction_is_dissipative_and_lies_between_its_two_envelopes(friction, speed):
    torque = sliding_friction(friction, speed)
    viscous = friction.viscous * speed
    rounding = 1e-12 * (friction.stiction + viscous)
    assert torque >= 0.0
    assert friction.coulomb + viscous - rounding <= torque <= friction.stiction + viscous + rounding


@given(frictions())
def test_map_starts_at_stiction_and_ends_on_the_coulomb_viscous_line(friction):
    assert sliding_friction(friction, 0.0) == pytest.approx(friction.stiction, rel=1e-14, abs=1e-300)
    beginning = friction.stribeck_velocity * 1e-12 ** (1.0 / friction.stribeck_shape)
    start = friction.stiction + friction.viscous * beginning
    assert sliding_friction(friction, beginning) == pytest.approx(start, rel=1e-9, abs=1e-9)
    far = friction.stribeck_velocity * 50.0 ** (1.0 / friction.stribeck_shape)
    line = friction.coulomb + friction.viscous * far
    assert sliding_friction(friction, far) == pytest.approx(line, rel=1e-13, abs=1e-12)


@pytest.mark.parametrize("shape", [1.0, 2.0])
@pytest.mark.parametrize("speed", [1e-6, 0.01, 0.05, 0.3])
def test_shortcut_for_a_common_shape_is_the_general_formula(shape, speed):
    neighbour = shape * (1.0 + 1e-13)
    assert stribeck_decay(speed, 0.05, shape) == pytest.approx(stribeck_decay(speed, 0.05, neighbour), rel=1e-10)
    curve = Stribeck(60.0, 90.0, 80.0, 0.05, shape)
    slope = sliding_friction_and_slope(curve._replace(stribeck_shape=neighbour), speed)[1]
    assert sliding_friction_and_slope(curve, speed)[1] == pytest.approx(slope, rel=1e-10)


def test_edge_of_an_almost_rectangular_peak_does_not_overflow():
    curve = Stribeck(60.0, 90.0, 80.0, 0.05, 400.0)
    assert sliding_friction(curve, 0.04) == pytest.approx(93.2, rel=1e-14)
    assert sliding_friction(curve, 0.35) == pytest.approx(88.0, rel=1e-14)
    assert sliding_friction_and_slope(curve, 0.35)[1] == 80.0


@given(frictions(), st.floats(0.02, 6.0))
def test_slope_equals_a_central_difference(friction, ratio):
    speed = ratio * friction.stribeck_velocity
    step = 1e-5 * speed
    rise = sliding_friction(friction, speed + step) - sliding_friction(friction, speed - step)
    # the error of a central difference of values of the size of F is about eps F/step
    rounding = 1e-15 * (friction.stiction + friction.viscous * speed) / step
    scale = (friction.stiction - friction.coulomb) / friction.stribeck_velocity
    assert sliding_friction_and_slope(friction, speed)[1] == pytest.approx(
        rise / (2.0 * step), rel=1e-7, abs=2.0 * rounding + 1e-7 * scale
    )


@given(frictions(STEEP_SHAPE, least_excess=1.0))
def test_steepest_fall_equals_the_brute_force_maximum(friction):
    speeds = friction.stribeck_velocity * np.geomspace(1e-4, 10.0, 1001)
    torques = np.array([sliding_friction(friction, speed) for speed in speeds])
    brute_force = max(0.0, float(np.max(-np.diff(torques) / np.diff(speeds))))
    scale = (friction.stiction - friction.coulomb) / friction.stribeck_velocity + friction.viscous
    assert steepest_fall(friction) == pytest.approx(brute_force, abs=2e-3 * scale)


@given(frictions(st.floats(0.05, 0.99), least_excess=1e-3))
def test_steepest_fall_is_infinite_for_a_shape_below_one(friction):
    assert steepest_fall(friction) == math.inf


def test_steepest_fall_is_zero_where_viscous_friction_outweighs_the_peak():
    assert steepest_fall(Stribeck(60.0, 90.0, 599.0, 0.05, 1.0)) == pytest.approx(1.0)
    assert steepest_fall(Stribeck(60.0, 90.0, 601.0, 0.05, 1.0)) == 0.0


@given(frictions(), st.floats(0.1, 10.0), st.floats(0.0, 10.0))
def test_scaled_friction_is_a_multiple_at_every_speed(friction, factor, speed):
    assume(friction.stiction > 0.0)
    result = scaled(friction, factor)
    assert sliding_friction(result, speed) == pytest.approx(factor * sliding_friction(friction, speed), rel=1e-12)
    assert result[3:] == friction[3:]


@given(frictions(), st.floats(0.0, 6.0))
def test_yield_torque_is_the_map_without_its_viscous_part_and_its_rise_that_of_the_slope(friction, ratio):
    speed = ratio * friction.stribeck_velocity
    level, rise = yield_torque(friction, speed)
    assert level == pytest.approx(sliding_friction(friction, speed) - friction.viscous * speed, rel=1e-12, abs=1e-10)
    slope = sliding_friction_and_slope(friction, speed)[1] - friction.viscous if speed > 1e-30 else 0.0
    assert rise == pytest.approx(speed * slope, rel=1e-9, abs=1e-9)


def test_yield_torque_beyond_an_almost_rectangular_peak_does_not_overflow():
    curve = Stribeck(60.0, 90.0, 80.0, 0.05, 400.0)
    assert yield_torque(curve, 0.35) == (60.0, 0.0)
    assert yield_torque(curve, 0.0) == (90.0, 0.0)


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


MULTIPLES = [(0.001, 0.001, 1), (0.022, 0.001, 22), (3600.0, 1e-4, 36_000_000)]
MULTIPLES += [(0.3, 0.1, 3)]  # 0.3/0.1 is 2.9999999999999996
OTHERS = (0.0005, 0.0014, 0.0, -0.001, 1000.0004, math.nan, math.inf)


@pytest.mark.parametrize(("duration", "period", "expected"), [*MULTIPLES, *((one, 0.001, None) for one in OTHERS)])
def test_whole_multiple(duration, period, expected):
    assert whole_multiple(duration, period) == expected
