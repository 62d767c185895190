"""No more friction is fed than the torque along the plan tells of."""

import math

import numpy as np
import pytest

from adaptive_ff.adaptive.supervision.balance import MEMORY, NEEDED, advance_balance, balanced_share, initial_balance

PERIOD = 0.01
PLAN = np.sin(np.arange(3000) * 0.02)


def after(needed, modelled, plan=PLAN):
    state = initial_balance()
    for reference, torque, friction in zip(plan, needed, modelled, strict=True):
        state = advance_balance(state, reference, torque, friction, PERIOD)
    return state


@pytest.mark.parametrize("modelled", [20.0, 100.0, 800.0])
def test_of_a_model_with_too_much_friction_no_more_is_fed_than_is_needed(modelled):
    noise = 100.0 * np.random.default_rng(101).standard_normal(PLAN.size)
    state = after(20.0 * np.sign(PLAN) + noise, modelled * np.sign(PLAN))
    assert balanced_share(state, 0.0, 0.0) == pytest.approx(min(1.0, 20.0 / modelled / NEEDED), rel=0.3)


@pytest.mark.parametrize("needed", [1.01 * NEEDED, 1.0, 3.0])
def test_a_model_that_fits_or_has_too_little_is_fed_in_full(needed):
    assert balanced_share(after(needed * 50.0 * np.sign(PLAN), 50.0 * np.sign(PLAN)), 50.0, 0.0) == 1.0


def test_a_joint_that_drives_itself_is_fed_none_and_one_of_which_nothing_is_known_all():
    assert balanced_share(after(-80.0 * np.sign(PLAN), 50.0 * np.sign(PLAN)), 0.0, 0.0) == 0.0
    assert balanced_share(initial_balance(), 50.0, 0.0) == balanced_share(initial_balance(), 0.0, 0.0) == 1.0


def test_loads_and_rest_are_none_of_it_and_the_past_fades():
    state = after(50.0 * np.sign(PLAN) + 200.0, 50.0 * np.sign(PLAN))
    whole = PLAN[: round(9.0 * 2.0 * math.pi / 0.02)]
    assert balanced_share(after(30.0 * np.sign(whole) + 20.0, 30.0 * np.sign(whole), whole), 30.0, 0.0) == 1.0
    assert advance_balance(state, 0.0, 1e3, 1e3, PERIOD) is state
    later = state
    for _ in range(round(MEMORY / PERIOD)):
        later = advance_balance(later, 0.1, 0.0, 0.0, PERIOD)
    assert tuple(later) == pytest.approx(tuple(np.exp(-1.0) * np.array(state)), rel=1e-6)


def test_where_the_sensor_kicks_nothing_is_fed_on_trust_and_no_more_than_is_needed():
    state = after(20.0 * np.sign(PLAN), 50.0 * np.sign(PLAN))
    assert balanced_share(state, 50.0, 1.0) == pytest.approx(0.4, rel=0.1)
    assert balanced_share(state, 50.0, 0.0) == pytest.approx(0.4 / NEEDED, rel=0.1)
    assert balanced_share(initial_balance(), 50.0, 1.0) == 0.0
    assert balanced_share(initial_balance(), 50.0, 0.5) == pytest.approx(0.5 / (0.5 * (1.0 + NEEDED)))
