import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.linalg import expm
from scipy.signal import lsim

from adaptive_ff.learning.filters import advance_filter_in_place, filter_decay, second_derivative

POLES = st.floats(1.0, 300.0)
DURATIONS = st.floats(1e-4, 0.5)
VALUES = st.floats(-10.0, 10.0)


def advance(state, pole, start, end, duration):
    after = np.array(state)
    advance_filter_in_place(after, pole, filter_decay(pole, duration), start, end, duration)
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


def test_jittered_samples_of_a_piecewise_linear_input_are_filtered_exactly():
    rng = np.random.default_rng(5)
    pole, times = 40.0, np.cumsum(rng.uniform(0.002, 0.03, 200))
    signal = np.cumsum(rng.standard_normal(200))
    step, stretch = 1e-5, round(times[-1] / 1e-5)  # breakpoints on a dense grid
    grid = np.arange(stretch + 1) * step
    nodes = np.round(times / step).astype(int)
    dense = np.interp(grid, nodes * step, signal, left=0.0)
    dense[: nodes[0] + 1] = np.linspace(0.0, signal[0], nodes[0] + 1)
    _, expected, _ = lsim(([pole**2], [1.0, 2.0 * pole, pole**2]), dense, grid)
    state, last, previous = np.zeros(2), 0, 0.0
    for node, value in zip(nodes, signal, strict=True):
        state = advance(state, pole, previous, value, (node - last) * step)
        assert state[0] == pytest.approx(expected[node], rel=1e-7, abs=1e-7)
        last, previous = node, value


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


@given(VALUES, VALUES, POLES, VALUES, VALUES, DURATIONS, st.floats(0.01, 0.99))
def test_two_parts_of_a_step_are_the_whole_step(value, slope, pole, start, end, duration, share):
    middle = start + share * (end - start)
    half = advance((value, slope), pole, start, middle, share * duration)
    parts = advance(half, pole, middle, end, (1.0 - share) * duration)
    whole = advance((value, slope), pole, start, end, duration)
    assert parts[0] == pytest.approx(whole[0], rel=1e-9, abs=1e-9)
    assert parts[1] == pytest.approx(whole[1], rel=1e-9, abs=1e-9 * pole)


def test_held_input_follows_the_step_response_in_closed_form():
    pole, state = 50.0, np.zeros(2)
    for k in range(1, 101):
        state = advance(state, pole, 3.0, 3.0, 0.004)
        run = 0.2 * k
        assert state[0] == pytest.approx(3.0 * (1.0 - (1.0 + run) * math.exp(-run)), rel=1e-12)
        assert state[1] == pytest.approx(3.0 * pole * run * math.exp(-run), rel=1e-11)
        expected = 3.0 * pole**2 * (1.0 - run) * math.exp(-run)
        assert second_derivative(state, pole, 3.0) == pytest.approx(expected, abs=1e-9)


def test_long_ramp_is_followed_two_time_constants_behind():
    pole, state = 50.0, np.zeros(2)
    for k in range(100):
        state = advance(state, pole, 0.2 * k, 0.2 * (k + 1), 0.01)
    assert state == pytest.approx([20.0 * (1.0 - 2.0 / pole), 20.0], rel=1e-12)
    assert second_derivative(state, pole, 20.0) == pytest.approx(0.0, abs=1e-9)
