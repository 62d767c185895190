"""Friction behind a lag over the path, along a plan.

Oracle: ``scipy``'s solution of ``dy/dx = (F - y)/s`` for the shares of Coulomb friction and stiction, of the lag in
time behind it, and of their integral.
"""

import itertools
import math

import numpy as np
import pytest
from plan_inputs import plan_inputs
from scipy.integrate import solve_ivp

from adaptive_ff.friction.feedforward import (
    BENT_FADING,
    FeedforwardState,
    bent_friction,
    feedforward_parts,
    friction_along,
    lagged_ramp,
)
from adaptive_ff.friction.model import TorqueModel
from adaptive_ff.learning.torque_form import (
    BENT,
    DAMPING,
    Bending,
    TorqueForm,
    advance_bent_in_place,
    advance_friction_in_place,
    bending_of,
    initial_signals,
    settle_signals_in_place,
)

PERIOD, PRESLIDING, STRIBECK = 0.01, 3e-3, 0.05
MODEL = TorqueModel(2.0, 20.0, 30.0, 8.0, 0.004, STRIBECK, 1.0, 1.5, presliding=PRESLIDING, micro_damping=6.0)
PLAN = 0.12 * np.sin(2.0 * math.pi * 0.9 * PERIOD * np.arange(180)) + 0.05 * np.sin(
    2.0 * math.pi * 2.3 * PERIOD * np.arange(180)
)


def static(model, slip, adhesion, velocity, direction):
    ratio = velocity / model.stribeck_velocity
    damping = model.micro_damping * math.exp(-(ratio**2)) * abs(ratio) * (direction - slip - adhesion)
    return model.coulomb * slip + model.stiction * adhesion + model.viscous * velocity + damping


def by_scipy(model, state, start, end):
    """Integral of the friction over a period from a velocity to another, and the state at its end."""
    turns = [0.0, start / (start - end), 1.0] if start * end < 0.0 else [0.0, 1.0]
    values = [0.0, *state]
    for first, last in itertools.pairwise(turns):
        way = math.copysign(1.0, start + (end - start) * 0.5 * (first + last))

        def slope(t, y, direction=way):
            velocity = start + (end - start) * t / PERIOD
            share = math.exp(-abs(velocity) / model.stribeck_velocity)
            friction = static(model, y[2], y[3], velocity, direction)
            rate = abs(velocity) / model.presliding
            slips = rate * (direction * (1.0 - share) - y[2])
            return [y[1], (friction - y[1]) / model.friction_lag, slips, rate * (direction * share - y[3])]

        part = (first * PERIOD, last * PERIOD)
        values = solve_ivp(slope, part, values, rtol=1e-10, atol=1e-13).y[:, -1]
    return values[0], values[1:]


def along(model, plan):
    """Torques and states of the feedforward along a plan, and those of the oracle."""
    state, known = FeedforwardState(0.0, plan[0], True), np.zeros(3)
    rows = []
    for start, end in itertools.pairwise(plan):
        torque, friction, state = feedforward_parts(model, state, plan_inputs(start, end), PERIOD)
        integral, known = by_scipy(model, known, start, end)
        expected = (model.inertia * (end - start) + integral) / PERIOD + model.offset
        rows.append((torque, friction, *state[:1], state.slip, state.adhesion, expected, integral / PERIOD, *known))
    return np.array(rows).T


@pytest.mark.parametrize("sign", [1.0, -1.0])
@pytest.mark.parametrize("micro_damping", [0.0, 6.0])
def test_friction_along_a_plan_solves_the_equations_of_the_bristles(sign, micro_damping):
    found = along(MODEL._replace(micro_damping=micro_damping), sign * PLAN)
    for own, oracle in zip(found[:5], found[5:], strict=True):
        assert np.max(np.abs(own - oracle)) <= 4e-3 * np.max(np.abs(oracle))


def test_pieces_are_as_fine_as_one_step_allows():
    """A period that takes the bristles most of the way: a rule of other places or weights would be further off."""
    state, known = FeedforwardState(0.0, 0.0, True), np.zeros(3)
    torque, _, state = feedforward_parts(MODEL, state, plan_inputs(0.02, 0.3), PERIOD)
    integral, known = by_scipy(MODEL, known, 0.02, 0.3)
    assert torque == pytest.approx((MODEL.inertia * 0.28 + integral) / PERIOD + MODEL.offset, rel=2e-3)
    assert (state.friction, state.slip, state.adhesion) == pytest.approx(tuple(known), rel=5e-3, abs=2e-3)


def test_a_plan_at_rest_leaves_the_bristles_as_they_are():
    state = FeedforwardState(5.0, 0.0, True, 0.3, -0.1)
    _, friction, after = feedforward_parts(MODEL, state, plan_inputs(0.0, 0.0), PERIOD)
    assert (after.slip, after.adhesion) == (0.3, -0.1)
    assert 0.0 < after.friction < friction < 5.0
    assert after.friction == pytest.approx(5.0 * math.exp(-PERIOD / BENT_FADING), rel=1e-12)


def test_a_ramp_without_lag_or_duration_is_followed_at_once():
    assert lagged_ramp(5.0, 1.0, 3.0, 0.0, 0.5) == (1.0, 3.0)
    assert lagged_ramp(5.0, 1.0, 3.0, 0.02, 0.0) == (0.0, 3.0)
    integral, friction = lagged_ramp(5.0, 1.0, 3.0, 1e-9, 0.5)
    assert (integral, friction) == pytest.approx((1.0, 3.0), rel=1e-7)


def test_no_time_bends_no_bristles():
    assert friction_along(MODEL, 4.0, 0.3, 0.1, 0.05, 0.0, 0.0) == (0.0, 4.0, 0.3, 0.1)


def test_bent_friction_is_the_sum_of_its_parts():
    assert bent_friction(MODEL, 0.4, 0.2, 0.03, 1.0) == pytest.approx(static(MODEL, 0.4, 0.2, 0.03, 1.0), rel=1e-14)
    assert bent_friction(MODEL, 0.4, 0.2, -0.03, -1.0) == pytest.approx(static(MODEL, 0.4, 0.2, -0.03, -1.0), rel=1e-14)
    one_sided = MODEL._replace(stiction_asymmetry=2.0, viscous_asymmetry=3.0)
    added = 2.0 * math.exp(-0.03 / STRIBECK) + 3.0 * 0.03
    assert bent_friction(one_sided, 0.4, 0.2, -0.03, -1.0) == pytest.approx(
        static(MODEL, 0.4, 0.2, -0.03, -1.0) + added, rel=1e-14
    )


FORM = TorqueForm(pole=60.0, stribeck_velocity=STRIBECK, stribeck_shape=1.0, presliding=PRESLIDING)


@pytest.mark.parametrize(("start", "end"), [(0.02, 0.05), (-0.05, -0.02), (0.0, 0.04)])
def test_bristles_of_the_regression_go_as_far_as_their_path(start, end):
    signals = initial_signals()
    signals.bent[BENT], signals.bent[DAMPING] = (0.2, -0.3), (0.05, 0.4)
    before, direction, decay = signals.bent.copy(), math.copysign(1.0, start + end), math.exp(-0.6)
    bending = bending_of(FORM, start, end, PERIOD)
    share = math.exp(-abs(0.5 * (start + end)) / STRIBECK)
    weights = [math.exp(-((v / STRIBECK) ** 2)) * abs(v) / STRIBECK for v in (start, end)]
    path = 0.5 * abs(start + end) * PERIOD
    assert bending == pytest.approx(Bending(direction, share, path, *weights), rel=1e-13)
    advance_bent_in_place(signals.bent, PRESLIDING, bending, 60.0, decay, PERIOD)
    target = direction * np.array([1.0 - share, share])
    assert signals.bent[BENT] == pytest.approx(
        target + (before[BENT] - target) * math.exp(-path / PRESLIDING), rel=1e-13
    )
    first, last = (w * (direction - sum(b)) for w, b in zip(weights, (before[BENT], signals.bent[BENT]), strict=True))

    def slope(t, y):
        return [y[1], 3600.0 * (first + (last - first) * t / PERIOD - y[0]) - 120.0 * y[1]]

    damped = solve_ivp(slope, (0.0, PERIOD), before[DAMPING], rtol=1e-11, atol=1e-13).y[:, -1]
    assert signals.bent[DAMPING] == pytest.approx(damped, rel=1e-7)


@pytest.mark.parametrize("velocity", [0.06, -0.06])
def test_settled_signals_are_those_of_a_long_motion_at_one_velocity(velocity):
    settled = settle_signals_in_place(FORM, initial_signals(9), velocity)
    moved = initial_signals(9)
    for _ in range(300):
        advance_friction_in_place(FORM, moved, velocity, velocity, PERIOD)
    assert settled.velocity == velocity
    assert settled.bent == pytest.approx(moved.bent, abs=1e-9)
    assert settled.filters[2:] == pytest.approx(moved.filters[2:], abs=1e-9)


def test_filters_stay_as_they_are_over_no_time():
    signals = settle_signals_in_place(FORM, initial_signals(9), 0.06)
    filters, bent = signals.filters.copy(), signals.bent.copy()
    advance_friction_in_place(FORM, signals, 0.06, 0.0, 0.0)
    assert np.array_equal(signals.filters, filters)
    assert np.array_equal(signals.bent, bent)


def test_a_motion_at_rest_has_no_direction():
    assert bending_of(FORM, 0.0, 0.0, PERIOD) == Bending(0.0, 1.0, 0.0, 0.0, 0.0)
