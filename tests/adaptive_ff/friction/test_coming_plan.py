"""A late drive: the feedforward is for when the torque acts, and the plan of then may be known."""

import itertools
import math

import numpy as np
import pytest
from plan_inputs import plan_inputs

from adaptive_ff.friction.feedforward import coming_plan, initial_feedforward_state, step_feedforward
from adaptive_ff.friction.model import TorqueModel

PERIOD, DELAY = 0.01, 2
MODEL = TorqueModel(20.0, 60.0, 60.0, 40.0, 0.0, 0.05, 1.0)
STOPS = np.concatenate([np.linspace(0.1, 0.0, 11), np.zeros(10), np.linspace(0.0, 0.1, 11)])
"""A plan that comes to rest and goes on the same way, rad/s."""


def torques_along(plan, delay, previewed):
    """Torques of each sample, and friction in them, as far as the plan of when they act goes."""
    state, found = initial_feedforward_state(), []
    for k in range(plan.size - delay - 1):
        acting = plan[k + delay : k + delay + 2] if previewed else (math.nan, math.nan)
        torque, state = step_feedforward(MODEL, state, plan_inputs(plan[k], plan[k + 1], *acting), PERIOD, float(delay))
        found.append((torque, state.friction))
    return np.array(found)


def test_what_a_late_drive_is_asked_for_is_what_a_prompt_one_is_asked_for_later():
    prompt, late = torques_along(STOPS, 0, False), torques_along(STOPS, DELAY, True)
    assert late == pytest.approx(prompt[DELAY:], rel=1e-12)


def test_friction_is_not_turned_where_the_plan_only_stops():
    known, extrapolated = (torques_along(STOPS, DELAY, previewed)[:, 1] for previewed in (True, False))
    assert np.min(known) >= 0.0
    assert np.min(extrapolated) < -0.5 * MODEL.coulomb  # which one cannot tell from a reversal without the plan


@pytest.mark.parametrize("acting", [(math.nan, 0.2), (0.2, math.nan), (math.inf, 0.2), (math.nan, math.nan)])
def test_half_a_plan_is_none(acting):
    state = initial_feedforward_state()._replace(reference=0.05, started=True)
    found = coming_plan(state, plan_inputs(0.1, 0.12, *acting), 1.5)
    assert found == pytest.approx((0.13, 0.15))


def test_the_known_plan_counts_without_any_delay_too():
    state = initial_feedforward_state()
    for start, end in itertools.pairwise((0.3, -0.2, 0.1)):
        assert coming_plan(state, plan_inputs(0.1, 0.12, start, end), 0.0) == (start, end)
