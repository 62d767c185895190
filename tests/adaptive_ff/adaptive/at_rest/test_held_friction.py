"""Friction that is held at rest: what a joint shows of it, and what that brings on a joint that creeps."""

import math
from itertools import pairwise

import numpy as np
import pytest

from adaptive_ff import AdaptiveController
from adaptive_ff.adaptive.at_rest.held_friction import (
    LARGEST_CHANGE,
    LEAST_CHANGE,
    LEAST_SHARE,
    SPARE,
    HeldFriction,
    advance_held_friction,
    initial_held_friction,
)
from adaptive_ff.friction.feedforward import HELD, FeedforwardState, released
from adaptive_ff.friction.model import TorqueModel
from controllers import PI, PositionLoop

PERIOD = 0.01
MODEL = TorqueModel(1.0, 6.0, 6.0, 4.0, 0.0, 0.05, 1.0)


def share_after(frictions, asked, share=1.0):
    state = HeldFriction(share, 0.0, 0.0, 0.0)
    for friction, change in zip(frictions, asked, strict=True):
        state = advance_held_friction(state, friction, change, True, PERIOD)
    return advance_held_friction(state, 0.0, 0.0, False, PERIOD)


def test_what_the_integral_takes_back_is_not_held_the_next_time():
    held = 5.0 * np.exp(-np.arange(50) / 20.0)
    taken = -0.2 * held[0] * np.ones(50) / 50.0
    shown = held + np.cumsum(taken)
    expected = 0.9 * (np.sum(shown * held) / np.sum(held**2) + SPARE)
    state = share_after(held, taken, 0.9)
    assert state.share == pytest.approx(expected, rel=1e-12)
    assert state[1:] == (0.0, 0.0, 0.0)
    assert share_after(-held, -taken, 0.9).share == pytest.approx(expected, rel=1e-12)


def test_share_changes_by_a_part_and_stays_within_its_bounds():
    held = np.full(20, 5.0)
    assert share_after(held, np.full(20, -5.0), 0.9).share == pytest.approx(LEAST_CHANGE * 0.9)
    assert share_after(held, np.full(20, 5.0), 0.5).share == pytest.approx(LARGEST_CHANGE * 0.5)
    assert share_after(held, np.full(20, 5.0), 0.9).share == 1.0
    assert share_after(held, np.full(20, -5.0), LEAST_SHARE).share == LEAST_SHARE


def test_a_joint_that_stands_still_and_a_rest_without_friction_tell_nothing():
    assert share_after(np.full(20, 5.0), np.zeros(20)).share == 1.0
    assert share_after(np.zeros(20), np.full(20, 1.0), 0.4).share == 0.4
    assert initial_held_friction().share == 1.0


@pytest.mark.parametrize("sign", [1.0, -1.0])
@pytest.mark.parametrize("lag", [0.0, 0.02])
def test_more_than_the_share_fades_with_the_lag(sign, lag):
    model, state = MODEL._replace(friction_lag=lag), FeedforwardState(sign * 5.0, 0.0, True, 0.2, 0.1)
    least = 0.3 * HELD * 6.0
    left = (5.0 - least) * (math.exp(-PERIOD / lag) if lag > 0.0 else 0.0)
    found = released(model, state, 0.3, PERIOD)
    assert found == pytest.approx(state._replace(friction=sign * (least + left)), rel=1e-12)
    assert released(model, state, 1.0, PERIOD) == state
    bent, least = model._replace(presliding=1e-3, stiction=9.0), 0.3 * 9.0
    left = (5.0 - least) * (math.exp(-PERIOD / lag) if lag > 0.0 else 0.0)
    assert released(bent, state, 0.3, PERIOD).friction == pytest.approx(sign * (least + left), rel=1e-12)
    assert released(model, state._replace(friction=sign * 0.5 * least), 0.3, PERIOD).friction == sign * 0.5 * least


def moves(count):
    """Return a plan of moves to and fro with rests of 0.5 s between, rad/s."""
    rise = np.minimum(np.arange(1, 21) / 20.0, 1.0)
    move = 0.4 * np.concatenate([rise, np.ones(30), rise[::-1], np.zeros(50)])
    return np.concatenate([move if k % 4 < 2 else -move for k in range(count)])


def run(controller, corner, plan):
    """Drive a joint whose Coulomb friction is reached at a speed of ``corner`` (rad/s); return its position error."""
    outer, velocity, angle, planned = PositionLoop(5.0), 0.0, 0.0, 0.0
    errors, steps = [], 20
    for reference, following in pairwise(plan):
        correction = outer.step(planned, angle)
        torque = controller.step(reference, velocity, correction=correction, next_reference=following, position=angle)
        for _ in range(steps):
            h = PERIOD / steps
            # implicit in the friction, which is stiff
            slope = MODEL.coulomb / corner
            stuck = (MODEL.inertia * velocity + h * torque) / (MODEL.inertia + h * (slope + MODEL.viscous))
            if abs(stuck) > corner:
                drag = math.copysign(MODEL.coulomb, stuck)
                stuck = (MODEL.inertia * velocity + h * (torque - drag)) / (MODEL.inertia + h * MODEL.viscous)
            velocity = stuck
            angle += h * velocity
        planned += 0.5 * PERIOD * (reference + following)
        errors.append(planned - angle)
    return np.array(errors)


@pytest.mark.parametrize(("corner", "largest", "left"), [(0.02, 0.2, 0.05), (0.065, 0.7, 0.15)])
def test_a_joint_that_creeps_is_given_less_and_tracks_better_than_behind_pi(corner, largest, left):
    plan, design = moves(40), PI.design(inertia=1.0, period=PERIOD, bandwidth=8.0)
    gains = design.proportional, design.integral
    controller = AdaptiveController(*gains, PERIOD, inertia=1.0, stribeck_velocity=0.05)
    own, alone = run(controller, corner, plan), run(PI(*gains, PERIOD), corner, plan)
    assert controller.state.held_friction.share < largest
    half = own.size // 2
    assert np.std(own[half:]) < left * np.std(alone[half:])


@pytest.mark.parametrize(
    ("name", "value"), [("share", 0.0), ("share", 1.5), ("held", -1.0), ("asked", math.nan), ("shown", math.inf)]
)
def test_impossible_states_are_refused(name, value):
    controller = AdaptiveController(100.0, 1000.0, PERIOD, inertia=1.0, stribeck_velocity=0.05)
    state = controller.state
    controller.state = state._replace(held_friction=state.held_friction._replace(**{name: value}))
    with pytest.raises(ValueError, match=r"state\.held_friction"):
        controller.state_from_json(controller.state_to_json())
