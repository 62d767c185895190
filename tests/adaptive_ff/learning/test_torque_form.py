import itertools
import math
from functools import partial

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.integrate import quad
from scipy.linalg import expm
from scipy.signal import lsim

from adaptive_ff.learning import torque_form

FORM = torque_form.TorqueForm(50.0, 0.05, 1.0)


def impulse_response_integral(signal, until, breaks):
    """Output of ``(p/(s+p))^2`` at a time, by adaptive quadrature of its impulse response with a signal."""
    pole, edges = FORM.pole, [0.0, *breaks, until]

    def share(t):
        return pole * pole * (until - t) * math.exp(-pole * (until - t)) * signal(t)

    pieces = [quad(share, a, b, epsabs=1e-13, epsrel=1e-12)[0] for a, b in itertools.pairwise(edges)]
    return math.fsum(pieces)


def adhesion(velocity):
    return math.copysign(math.exp(-abs(velocity) / FORM.stribeck_velocity), velocity)


def velocities_and_times(velocities, durations):
    """Breakpoints of a piecewise linear velocity, moments of reversal included."""
    times, nodes = [0.0], [velocities[0]]
    for end, duration in zip(velocities[1:], durations, strict=True):
        start, begin = nodes[-1], times[-1]
        if start * end < 0.0:
            times.append(begin + duration * abs(start) / (abs(start) + abs(end)))
            nodes.append(0.0)
        times.append(begin + duration)
        nodes.append(end)
    return np.array(times), np.array(nodes)


def filters_after(velocities, durations):
    signals = torque_form.initial_signals(FORM, 8)._replace(velocity=velocities[0])
    for velocity, duration in zip(velocities[1:], durations, strict=True):
        signals = torque_form.advance_signals_in_place(FORM, signals, 0.0, velocity, duration)
    return signals.filters


speeds = st.floats(0.01, 0.3)


@settings(max_examples=30, deadline=None)
@given(st.lists(st.tuples(speeds, st.sampled_from([-1.0, 1.0]), st.floats(1e-3, 0.03)), min_size=2, max_size=6))
def test_g_and_h_are_filtered_exactly_with_the_jump_at_the_moment_of_reversal(steps):
    velocities = [size * sign for size, sign, _ in steps]
    durations = [duration for _, _, duration in steps[1:]]
    times, nodes = velocities_and_times(velocities, durations)
    shares = np.exp(-np.abs(nodes) / FORM.stribeck_velocity)

    def signal(t, sizes, turns):
        return np.interp(t, times, sizes) * (math.copysign(1.0, np.interp(t, times, nodes)) if turns else 1.0)

    found = filters_after(velocities, durations)
    for index, sizes, turns in (
        (torque_form.FILTER_COULOMB, 1.0 - shares, True),
        (torque_form.FILTER_ADHESION, shares, True),
        (torque_form.FILTER_FRACTION, shares, False),
        (torque_form.FILTER_SPEED, np.abs(nodes), False),
    ):
        expected = impulse_response_integral(partial(signal, sizes=sizes, turns=turns), times[-1], list(times[1:-1]))
        assert found[index, 0] == pytest.approx(expected, abs=1e-9)


@pytest.mark.parametrize("place", [0.1, 0.4, 0.9])
def test_reversal_within_a_step_is_seen_where_it_happens(place):
    duration, swing = 0.004, 0.01  # slow against Vs: g and h are as good as linear
    start = swing * place
    found = filters_after([start, start - swing], [duration])[torque_form.FILTER_ADHESION, 0]
    turn = place * duration
    exact = impulse_response_integral(lambda t: adhesion(start - swing * t / duration), duration, [turn])
    ends = adhesion(start), adhesion(start - swing)
    unsplit = impulse_response_integral(lambda t: np.interp(t, [0.0, duration], ends), duration, [])
    assert found == pytest.approx(exact, abs=1e-4)
    assert abs(unsplit - exact) > 1e-3


def test_torque_is_held_over_the_period_that_ends_and_its_slope_is_regressed_with_a_minus():
    signals, row = torque_form.initial_signals(FORM, 5), np.empty(6)
    signals = torque_form.advance_signals_in_place(FORM, signals, 7.0, 0.0, 0.02)  # p t = 1
    torque = torque_form.write_regressors(FORM, signals, row)
    assert torque == pytest.approx(7.0 * (1.0 - 2.0 * math.exp(-1.0)), rel=1e-12)
    assert row == pytest.approx([0.0, 0.0, 0.0, 0.0, 0.0, -7.0 * 50.0 * math.exp(-1.0)], rel=1e-12)
    assert signals.filters[torque_form.FILTER_TORQUE, 0] == torque
    torque_form.write_regressors(FORM, signals, longer := np.zeros(7))
    assert longer.tolist() == [*row, 1.0]
    every = torque_form.Signals(np.arange(12.0).reshape(6, 2), 3.0)
    assert torque_form.write_regressors(FORM, every, longest := np.zeros(9)) == 0.0
    assert longest[1:].tolist() == [3.0, 4.0, 6.0, 2.0, -1.0, 1.0, 8.0, 10.0]


POLES = st.floats(1.0, 300.0)
DURATIONS = st.floats(1e-4, 0.5)
VALUES = st.floats(-10.0, 10.0)


def advance(state, pole, start, end, duration):
    after = np.array(state)
    torque_form.advance_filter_in_place(after, pole, math.exp(-pole * duration), start, end, duration)
    return after


@given(VALUES, VALUES, POLES, VALUES, VALUES, DURATIONS)
def test_step_is_the_matrix_exponential_with_the_ramp_as_state(value, slope, pole, start, end, duration):
    """The ramp is two further states: input and its rate."""
    system = np.zeros((4, 4))
    system[0, 1] = 1.0
    system[1] = -(pole**2), -2.0 * pole, pole**2, 0.0  # y'' = p^2 (u - y) - 2 p y'
    system[2, 3] = 1.0
    expected = expm(system * duration) @ [value, slope, start, (end - start) / duration]
    after = advance((value, slope), pole, start, end, duration)
    assert after[0] == pytest.approx(expected[0], rel=1e-9, abs=1e-9)
    assert after[1] == pytest.approx(expected[1], rel=1e-9, abs=1e-9 * pole)


def test_value_and_both_derivatives_are_those_of_scipy_signal():
    pole, period = 35.0, 0.01
    time = period * np.arange(500)
    series = np.sin(3.0 * time) + 0.2 * np.random.default_rng(6).standard_normal(500)
    series[0] = 0.0
    denominator = [1.0, 2.0 * pole, pole**2]
    numerators = ([pole**2], [pole**2, 0.0], [pole**2, 0.0, 0.0])
    expected = np.column_stack([lsim((numerator, denominator), series, time)[1] for numerator in numerators])
    state, found = np.zeros(2), np.zeros((500, 3))
    for k in range(1, 500):
        state = advance(state, pole, series[k - 1], series[k], period)
        found[k] = *state, torque_form.second_derivative(state, pole, series[k])
    size = np.max(np.abs(expected), axis=0)
    assert np.all(size > 0.5)
    assert found / size == pytest.approx(expected / size, abs=1e-11)
