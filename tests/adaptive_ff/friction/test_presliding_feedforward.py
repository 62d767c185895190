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
    friction_along,
    lagged_ramp,
    step_feedforward,
)
from adaptive_ff.friction.model import TorqueModel

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
        torque, state = step_feedforward(model, state, plan_inputs(start, end), PERIOD)
        friction = torque - model.offset - model.inertia * (end - start) / PERIOD
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
    torque, state = step_feedforward(MODEL, state, plan_inputs(0.02, 0.3), PERIOD)
    integral, known = by_scipy(MODEL, known, 0.02, 0.3)
    assert torque == pytest.approx((MODEL.inertia * 0.28 + integral) / PERIOD + MODEL.offset, rel=2e-3)
    assert (state.friction, state.slip, state.adhesion) == pytest.approx(tuple(known), rel=5e-3, abs=2e-3)


def test_a_plan_at_rest_leaves_the_bristles_as_they_are():
    state = FeedforwardState(5.0, 0.0, True, 0.3, -0.1)
    torque, after = step_feedforward(MODEL, state, plan_inputs(0.0, 0.0), PERIOD)
    assert (after.slip, after.adhesion) == (0.3, -0.1)
    assert 0.0 < after.friction < torque - MODEL.offset < 5.0
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
