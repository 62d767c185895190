"""A plan that is not known ahead: it is continued as far as it has gone on before."""

import itertools
import math

import numpy as np
import pytest
from closed_loops import SCENARIO

from adaptive_ff import AdaptiveController
from adaptive_ff.adaptive.faults.foresight import advance_foresight, continued_share, initial_foresight
from controllers import PI
from plant import Joint

PERIOD = 0.01


def shares(plan):
    """Share of the slope that is continued after each sample."""
    state, found = initial_foresight(), []
    for reference, slope in zip(plan[1:], np.diff(plan), strict=True):
        state = advance_foresight(state, reference, math.nan, slope, PERIOD)
        found.append(continued_share(state.product, state.square))
    return np.array(found)


def held(plan, samples):
    return plan[np.arange(plan.size) // samples * samples]


SMOOTH = 0.3 * np.sin(2.0 * np.pi * 0.5 * PERIOD * np.arange(1000))
TRAPEZOIDS = np.clip(0.8 * np.abs((PERIOD * np.arange(1000) + 1.0) % 4.0 - 2.0) - 0.4, -0.35, 0.35)


@pytest.mark.parametrize("plan", [SMOOTH, TRAPEZOIDS], ids=["sine", "trapezoids"])
def test_a_plan_that_is_computed_at_every_sample_is_continued(plan):
    assert np.all(shares(plan)[20:] == 1.0)


@pytest.mark.parametrize("samples", [2, 3, 10])
def test_a_plan_that_is_held_is_not_continued(samples):
    assert np.all(shares(held(SMOOTH, samples)) == 0.0)


def test_a_plan_that_stands_is_continued_as_it_stands():
    assert np.all(shares(np.full(100, 0.3)) == 0.0)
    assert continued_share(initial_foresight().product, initial_foresight().square) == 0.0


def test_what_comes_is_what_is_told_or_the_plan_as_far_as_it_goes_on():
    state = initial_foresight()
    for k in range(200):
        state = advance_foresight(state, 0.01 * k, math.nan, 0.01, PERIOD)
        if k > 10:
            assert state.coming == pytest.approx(0.01 * (k + 1))
    assert advance_foresight(state, 2.0, 5.0, 0.01, PERIOD).coming == 5.0
    leapt = advance_foresight(state, 0.0, math.nan, -2.0, PERIOD)
    assert leapt.coming == 0.0  # one that has leapt stands


def errors(controller, plan, seed):
    """Errors of the built-in joint along a plan that is not told ahead."""
    joint, generator, found = Joint(SCENARIO.joint, 0.0), np.random.default_rng(seed), []
    for now, following in itertools.pairwise(plan):
        torque = controller.step(now, joint.state.velocity + 0.002 * generator.standard_normal())
        joint.step(min(max(torque, -400.0), 400.0), PERIOD)
        found.append(following - joint.state.velocity)
    return np.array(found)


@pytest.mark.parametrize("samples", [1, 3, 5])
@pytest.mark.parametrize("plan", [SMOOTH, TRAPEZOIDS], ids=["sine", "trapezoids"])
def test_a_held_plan_is_tracked_no_worse_than_by_the_loop_alone(plan, samples):
    design = PI.design(inertia=SCENARIO.joint.inertia, period=PERIOD, bandwidth=10.0)
    gains = (design.proportional, design.integral, PERIOD)
    along = held(np.tile(plan, 4), samples)
    own = errors(AdaptiveController(*gains, inertia=20.0, stribeck_velocity=0.05, torque_limit=400.0), along, 101)
    base = errors(PI(*gains), along, 101)
    for window in np.array_split(np.arange(own.size), 8):
        assert np.mean(own[window] ** 2) < 1.2**2 * np.mean(base[window] ** 2)
    assert np.mean(own[2000:] ** 2) < np.mean(base[2000:] ** 2)
