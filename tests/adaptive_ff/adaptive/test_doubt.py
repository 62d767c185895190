"""A plan that leaps beyond all that has been seen: the controller is its PI loop until the plan is believed."""

import itertools
import math

import numpy as np
import pytest

from adaptive_ff import AdaptiveController
from controllers import PI

PERIOD, INERTIA = 0.004, 1.0
DESIGN = PI.design(inertia=INERTIA, period=PERIOD, bandwidth=8.0)


def make(stribeck_velocity):
    return AdaptiveController(
        DESIGN.proportional, DESIGN.integral, PERIOD, inertia=INERTIA, stribeck_velocity=stribeck_velocity
    )


def tracked(controller, plan, *, preview):
    """Return errors and torques of a joint with Coulomb friction along a plan."""
    generator, velocity, errors, torques = np.random.default_rng(101), 0.0, [], []
    for now, following in itertools.pairwise(plan):
        measured = velocity + 0.002 * generator.standard_normal()
        torque = controller.step(now, measured, **({"next_reference": following} if preview else {}))
        free = velocity + PERIOD * torque / INERTIA
        velocity = math.copysign(max(0.0, abs(free) - PERIOD * 3.0 / INERTIA), free)
        errors.append(following - velocity)
        torques.append(torque)
    return np.array(errors), np.array(torques)


def rms(values):
    return float(np.sqrt(np.mean(np.square(values))))


def test_the_feedback_follows_a_plan_that_leaps_at_once():
    controller, alone = make(0.02), PI(DESIGN.proportional, DESIGN.integral, PERIOD)
    for velocity in (0.0, 0.0, 0.1, 0.3):
        torque = controller.step(0.8, velocity, next_reference=0.8)
        assert torque == pytest.approx(alone.step(0.8, velocity, next_reference=0.8), rel=1e-9)
    assert controller.state.doubt.leapt


@pytest.mark.parametrize("stribeck_velocity", [0.02, 0.1])
@pytest.mark.parametrize("preview", [True, False])
@pytest.mark.parametrize("late", [0.0, 4.0])
def test_a_step_of_the_plan_is_tracked_no_worse_than_by_the_loop_alone(stribeck_velocity, preview, late):
    plan = np.where(PERIOD * np.arange(2500) < late, 0.0, 1.2)
    own, torques = tracked(make(stribeck_velocity), plan, preview=preview)
    base, asked = tracked(PI(DESIGN.proportional, DESIGN.integral, PERIOD), plan, preview=preview)
    begin = round(late / PERIOD)
    assert rms(own[begin : begin + 1250]) <= 1.05 * rms(base[begin : begin + 1250])
    assert np.max(np.abs(torques)) <= 1.1 * np.max(np.abs(asked))
