import itertools
import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.integrate import quad

from adaptive_ff.learning.sliding_gate import sliding_time
from adaptive_ff.learning.torque_form import (
    FILTER_ADHESION,
    FILTER_COULOMB,
    FILTER_FRACTION,
    FILTER_SPEED,
    FILTER_TORQUE,
    TorqueForm,
    advance_signals_in_place,
    initial_signals,
    regressor_names,
    settle_signals_in_place,
    write_regressors,
)

FORM = TorqueForm(50.0, 0.05, 1.0)


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
    signals = initial_signals(8)._replace(velocity=velocities[0])
    for velocity, duration in zip(velocities[1:], durations, strict=True):
        signals = advance_signals_in_place(FORM, signals, 0.0, velocity, duration)
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
    for index, sizes in ((FILTER_COULOMB, 1.0 - shares), (FILTER_ADHESION, shares)):
        expected = impulse_response_integral(
            lambda t, sizes=sizes: direction(t) * np.interp(t, times, sizes), times[-1], list(times[1:-1])
        )
        assert found[index, 0] == pytest.approx(expected, abs=1e-9)
    for index, sizes in ((FILTER_FRACTION, shares), (FILTER_SPEED, np.abs(nodes))):  # these do not jump
        expected = impulse_response_integral(
            lambda t, sizes=sizes: np.interp(t, times, sizes), times[-1], list(times[1:-1])
        )
        assert found[index, 0] == pytest.approx(expected, abs=1e-9)


@pytest.mark.parametrize("place", [0.1, 0.4, 0.9])
def test_reversal_within_a_step_is_seen_where_it_happens(place):
    duration, swing = 0.004, 0.01  # slow against Vs: g and h are as good as linear
    start = swing * place
    found = filters_after([start, start - swing], [duration])[FILTER_ADHESION, 0]
    turn = place * duration
    exact = impulse_response_integral(lambda t: adhesion(start - swing * t / duration), duration, [turn])
    ends = adhesion(start), adhesion(start - swing)
    unsplit = impulse_response_integral(lambda t: np.interp(t, [0.0, duration], ends), duration, [])
    assert found == pytest.approx(exact, abs=1e-4)
    assert abs(unsplit - exact) > 1e-3


def test_columns_of_an_offset_and_of_directions_are_there_where_they_are_asked_for():
    signals, row = settle_signals_in_place(FORM, initial_signals(8), -0.08), np.empty(9)
    before = signals.filters.copy()
    signals = advance_signals_in_place(FORM, signals, 0.0, -0.08, 0.01)
    assert signals.filters == pytest.approx(before, abs=1e-15)
    write_regressors(FORM, signals, row)
    share = math.exp(-1.6)
    assert row[2:5] == pytest.approx([share - 1.0, -share, -0.08], rel=1e-12)
    assert row[6:] == pytest.approx([1.0, share, 0.08], rel=1e-12)
    assert initial_signals(6).filters.shape == initial_signals().filters.shape == (4, 2)
    assert regressor_names(("inertia", "offset")) == ("inertia_lag", "inertia", "offset")


def test_torque_is_held_over_the_period_that_ends_and_its_slope_is_regressed_with_a_minus():
    signals, row = initial_signals(), np.empty(6)
    signals = advance_signals_in_place(FORM, signals, 7.0, 0.0, 0.02)  # p t = 1
    torque = write_regressors(FORM, signals, row)
    assert torque == pytest.approx(7.0 * (1.0 - 2.0 * math.exp(-1.0)), rel=1e-12)
    assert row == pytest.approx([0.0, 0.0, 0.0, 0.0, 0.0, -7.0 * 50.0 * math.exp(-1.0)], rel=1e-12)
    assert signals.filters[FILTER_TORQUE, 0] == torque


@pytest.mark.parametrize("count", [5, 8])
@pytest.mark.parametrize("velocity", [0.03, -0.2, 0.0])
def test_settled_filters_are_those_of_a_motion_that_has_lasted(velocity, count):
    moved = initial_signals(count)._replace(velocity=velocity)
    for _ in range(100):
        moved = advance_signals_in_place(FORM, moved, 0.0, velocity, 0.01)
    settled = settle_signals_in_place(FORM, initial_signals(count), velocity)
    assert settled.filters == pytest.approx(moved.filters, rel=1e-12, abs=1e-12)
    assert settled.velocity == velocity


@pytest.mark.parametrize(
    ("velocity", "reference", "valid", "expected"),
    [
        (0.2, 0.1, True, 0.31),
        (0.1, 0.1, True, 0.31),  # exactly the speed of the gate
        (-0.2, -0.1, True, 0.31),
        (0.099, 0.1, True, 0.0),
        (0.2, -0.1, True, 0.0),
        (0.2, 0.0, True, 0.0),
        (0.2, 0.1, False, 0.0),
    ],
)
def test_a_joint_slides_while_it_moves_fast_enough_along_its_reference(velocity, reference, valid, expected):
    assert sliding_time(0.3, velocity, reference, valid, 0.1, 0.01) == pytest.approx(expected)
