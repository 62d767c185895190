"""Friction behind a lag over the path, along a plan.

Oracle: ``scipy``'s solution of ``dy/dx = (F - y)/s`` for the shares of Coulomb friction and stiction, of the lag in
time behind it, and of their integral.
"""

import itertools
import math

import numpy as np
import pytest
from closed_loops import plan_inputs
from scipy.integrate import solve_ivp

from adaptive_ff.friction.feedforward import FeedforwardState, step_feedforward
from adaptive_ff.friction.model import TorqueModel

PERIOD, PRESLIDING, STRIBECK = 0.01, 3e-3, 0.05
MODEL = TorqueModel(2.0, 20.0, 30.0, 8.0, 0.004, STRIBECK, 1.0, 1.5, 4.0, 2.0, PRESLIDING, micro_damping=6.0)
PLAN = 0.12 * np.sin(2.0 * math.pi * 0.9 * PERIOD * np.arange(180)) + 0.05 * np.sin(
    2.0 * math.pi * 2.3 * PERIOD * np.arange(180)
)


def static(model, slip, adhesion, velocity, direction):
    ratio = velocity / model.stribeck_velocity
    damping = model.micro_damping * math.exp(-(ratio**2)) * abs(ratio) * (direction - slip - adhesion)
    one_sided = model.stiction_asymmetry * math.exp(-abs(ratio)) + model.viscous_asymmetry * abs(velocity)
    return model.coulomb * slip + model.stiction * adhesion + model.viscous * velocity + damping + one_sided


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
