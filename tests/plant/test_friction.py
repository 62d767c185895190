import math

import numpy as np
import pytest
from hypothesis import assume, given
from hypothesis import strategies as st

from plant import Stribeck, sliding_friction, stribeck_decay
from plant.friction import scaled, sliding_friction_and_slope, steepest_fall, yield_torque

SHAPES = (0.7, 1.0, 1.5, 2.0, 3.0)
ANY_SHAPE = st.sampled_from(SHAPES) | st.floats(0.3, 4.0)
STEEP_SHAPE = st.sampled_from((1.0, 1.5, 2.0, 3.0)) | st.floats(1.0, 4.0)


def none_or(most):
    return st.just(0.0) | st.floats(1e-3, most)


@st.composite
def frictions(draw, shapes=ANY_SHAPE, least_excess=0.0):
    coulomb = draw(none_or(200.0))
    return Stribeck(
        coulomb,
        coulomb + draw(st.floats(least_excess, 100.0) if least_excess else none_or(100.0)),
        draw(none_or(200.0)),
        draw(st.floats(1e-3, 1.0)),
        draw(shapes),
    )


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
    speeds = friction.stribeck_velocity * np.geomspace(1e-4, 10.0, 4001)
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
