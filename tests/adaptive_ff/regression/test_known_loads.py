"""Filters of known loads against the closed form of the filter, and the torque that they make."""

import math

import numpy as np
import pytest
from scipy.signal import lsim

from adaptive_ff.regression.known_loads import (
    COSINE,
    INPUT,
    SINE,
    SLOPE,
    VALUE,
    advance_loads_in_place,
    initial_loads,
    load_torque,
    write_loads,
)

POLE, PERIOD = 40.0, 0.01
NONE, GRAVITY = np.zeros(0), np.ones(1)


def test_filters_are_those_of_a_continuous_filter():
    """scipy integrates ``(p/(s + p))^2`` and ``s (p/(s + p))^2`` along the same broken line."""
    time = PERIOD * np.arange(60)
    signal = np.sin(9.0 * time) + time
    loads = initial_loads(1)
    found = []
    for k, value in enumerate(signal):
        advance_loads_in_place(loads, NONE, np.array([value]), POLE, math.nan, PERIOD, k == 0)
        found.append(loads[0].copy())
    found = np.array(found)
    value = lsim(([POLE**2], [1.0, 2.0 * POLE, POLE**2]), signal - signal[0], time)[1]
    slope = lsim(([POLE**2, 0.0], [1.0, 2.0 * POLE, POLE**2]), signal - signal[0], time)[1]
    np.testing.assert_allclose(found[:, VALUE], value + signal[0], atol=1e-10)
    np.testing.assert_allclose(found[:, SLOPE], slope, atol=1e-8)


def test_gravity_begins_settled_at_the_first_position_whenever_that_comes():
    loads = initial_loads(2)
    for k in range(3):
        advance_loads_in_place(loads, GRAVITY, NONE, POLE, math.nan, PERIOD, k == 0)
        assert load_torque(np.array([30.0, 40.0]), loads, GRAVITY, 0.3) == 0.0
    advance_loads_in_place(loads, GRAVITY, NONE, POLE, 0.7, PERIOD, False)
    np.testing.assert_array_equal(loads[:, VALUE], [math.sin(0.7), math.cos(0.7)])
    np.testing.assert_array_equal(loads[:, SLOPE], 0.0)


@pytest.mark.parametrize("angle", [0.0, math.pi / 2.0])
def test_gravity_is_filtered_from_there_on_where_the_sine_or_the_cosine_is_zero_too(angle):
    loads = initial_loads(2)
    advance_loads_in_place(loads, GRAVITY, NONE, POLE, angle, PERIOD, True)
    loads[COSINE if angle == 0.0 else SINE, INPUT] = 1.0
    loads[SINE if angle == 0.0 else COSINE, INPUT] = 0.0
    advance_loads_in_place(loads, GRAVITY, NONE, POLE, angle + 0.5, PERIOD, False)
    assert np.all(loads[:, SLOPE] != 0.0), "a filter, no fresh start"


def test_gravity_and_further_regressors_have_rows_of_their_own():
    together, gravity, further = initial_loads(5), initial_loads(2), initial_loads(3)
    for k in range(20):
        position, values = 0.1 * k, np.array([math.sin(0.3 * k), 0.2 * k, 1.0])
        advance_loads_in_place(together, GRAVITY, values, POLE, position, PERIOD, k == 0)
        advance_loads_in_place(gravity, GRAVITY, NONE, POLE, position, PERIOD, k == 0)
        advance_loads_in_place(further, NONE, values, POLE, math.nan, PERIOD, k == 0)
    np.testing.assert_array_equal(together, np.vstack([gravity, further]))


@pytest.mark.parametrize("lost", [math.nan, math.inf, -math.inf])
def test_what_is_not_finite_holds_the_last_value(lost):
    loads = initial_loads(3)
    advance_loads_in_place(loads, GRAVITY, np.array([0.5]), POLE, 0.7, PERIOD, True)
    held = loads[:, INPUT].copy()
    advance_loads_in_place(loads, GRAVITY, np.array([lost]), POLE, lost, PERIOD, False)
    np.testing.assert_array_equal(loads[:, INPUT], held)
    np.testing.assert_allclose(loads[:, VALUE], held, rtol=1e-12)


def test_torque_is_that_of_the_position_to_come():
    loads = initial_loads(3)
    advance_loads_in_place(loads, GRAVITY, np.array([0.25]), POLE, 0.7, PERIOD, True)
    estimate = np.array([1.0, 2.0, 30.0, -40.0, 8.0])  # the last three are those of the loads
    expected = 30.0 * math.sin(0.75) - 40.0 * math.cos(0.75) + 2.0
    assert load_torque(estimate, loads, GRAVITY, 0.05) == pytest.approx(expected, rel=1e-12)
    assert (SINE, COSINE) == (0, 1)


def test_each_wave_is_that_of_its_own_period():
    waves = np.array([1.0, 40.0])
    together, apart = initial_loads(4), [initial_loads(2), initial_loads(2)]
    for k in range(20):
        advance_loads_in_place(together, waves, NONE, POLE, 0.01 * k, PERIOD, k == 0)
        for loads, wave in zip(apart, waves, strict=True):
            advance_loads_in_place(loads, np.ones(1), NONE, POLE, wave * 0.01 * k, PERIOD, k == 0)
    np.testing.assert_allclose(together, np.vstack(apart), atol=1e-9)
    estimate = np.array([7.0, 30.0, -40.0, 8.0, 5.0])
    slow, fast = 0.19 + 0.05, 40.0 * (0.19 + 0.05)
    expected = 30.0 * math.sin(slow) - 40.0 * math.cos(slow) + 8.0 * math.sin(fast) + 5.0 * math.cos(fast)
    assert load_torque(estimate, together, waves, 0.05) == pytest.approx(expected, rel=1e-9)


def test_row_holds_values_then_derivatives_behind_the_other_columns():
    loads = np.array([[1.0, 2.0, 0.0], [3.0, 4.0, 0.0]])
    row = np.full(9, 7.0)
    write_loads(loads, row)
    assert row.tolist() == [7.0] * 5 + [1.0, 3.0, 2.0, 4.0]
