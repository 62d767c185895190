import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.linalg import expm
from scipy.signal import lsim

from adaptive_ff.learning.torque_form import advance_filter_in_place, second_derivative

POLES = st.floats(1.0, 300.0)
DURATIONS = st.floats(1e-4, 0.5)
VALUES = st.floats(-10.0, 10.0)


def advance(state, pole, start, end, duration):
    after = np.array(state)
    advance_filter_in_place(after, pole, math.exp(-pole * duration), start, end, duration)
    return after


def exponential_of_the_filter_with_its_ramp(state, pole, start, end, duration):
    """Value and derivative by ``scipy.linalg.expm``, the ramp being two further states: input and its rate."""
    system = np.zeros((4, 4))
    system[0, 1] = 1.0
    system[1] = -(pole**2), -2.0 * pole, pole**2, 0.0  # y'' = p^2 (u - y) - 2 p y'
    system[2, 3] = 1.0
    rate = (end - start) / duration
    return (expm(system * duration) @ [*state, start, rate])[:2]


@given(VALUES, VALUES, POLES, VALUES, VALUES, DURATIONS)
def test_step_is_the_matrix_exponential_with_the_ramp_as_state(value, slope, pole, start, end, duration):
    expected = exponential_of_the_filter_with_its_ramp((value, slope), pole, start, end, duration)
    after = advance((value, slope), pole, start, end, duration)
    assert after[0] == pytest.approx(expected[0], rel=1e-9, abs=1e-9)
    assert after[1] == pytest.approx(expected[1], rel=1e-9, abs=1e-9 * pole)


def test_value_and_both_derivatives_are_those_of_scipy_signal():
    pole, period = 35.0, 0.01
    time = period * np.arange(500)
    signal = np.sin(3.0 * time) + 0.2 * np.random.default_rng(6).standard_normal(500)
    signal[0] = 0.0
    denominator = [1.0, 2.0 * pole, pole**2]
    numerators = ([pole**2], [pole**2, 0.0], [pole**2, 0.0, 0.0])
    expected = np.column_stack([lsim((numerator, denominator), signal, time)[1] for numerator in numerators])
    state, found = np.zeros(2), np.zeros((500, 3))
    for k in range(1, 500):
        state = advance(state, pole, signal[k - 1], signal[k], period)
        found[k] = *state, second_derivative(state, pole, signal[k])
    size = np.max(np.abs(expected), axis=0)
    assert np.all(size > 0.5)
    assert found / size == pytest.approx(expected / size, abs=1e-11)
