import itertools
import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.integrate import quad

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

    def direction(t):
        return math.copysign(1.0, np.interp(t, times, nodes))

    found = filters_after(velocities, durations)
    for index, sizes in ((torque_form.FILTER_COULOMB, 1.0 - shares), (torque_form.FILTER_ADHESION, shares)):
        expected = impulse_response_integral(
            lambda t, sizes=sizes: direction(t) * np.interp(t, times, sizes), times[-1], list(times[1:-1])
        )
        assert found[index, 0] == pytest.approx(expected, abs=1e-9)
    for index, sizes in (
        (torque_form.FILTER_FRACTION, shares),
        (torque_form.FILTER_SPEED, np.abs(nodes)),
    ):  # these do not jump
        expected = impulse_response_integral(
            lambda t, sizes=sizes: np.interp(t, times, sizes), times[-1], list(times[1:-1])
        )
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
