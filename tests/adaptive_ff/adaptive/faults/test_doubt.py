"""A plan that leaps beyond all that has been seen: the controller is its PI loop until the plan is believed."""

import itertools
import math

import numpy as np
import pytest

from adaptive_ff import AdaptiveController
from adaptive_ff.adaptive.faults.doubt import CONSISTENT
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


def along_a_sine(controller, wrong):
    """Torques along a plan that is told for when the torque acts; at some samples it is told wrong."""
    plan, torques = 0.5 * np.sin(0.02 * np.arange(303)), []
    for k in range(300):
        start, end = wrong.get(k, (plan[k + 1], plan[k + 2]))
        acting = {"acting_reference": start, "next_acting_reference": end}
        torques.append(controller.step(plan[k], plan[k], next_reference=plan[k + 1], dt=PERIOD, **acting))
    return np.array(torques)


def test_a_coming_plan_that_does_not_go_on_where_it_said_is_not_used_until_it_has_done_so_for_some_samples():
    controller, unknown = make(0.02), (None, None)
    found = along_a_sine(controller, {200: (0.2, 0.2), 201: (-0.2, -0.2)})
    assert controller.state.doubt.aside == 0
    expected = along_a_sine(make(0.02), dict.fromkeys(range(200, 202 + CONSISTENT), unknown))
    assert found[:203].tolist() == expected[:203].tolist()
    assert found[206] == pytest.approx(expected[206], rel=1e-6)
    assert found[250] == pytest.approx(expected[250], rel=1e-3)


def test_a_coming_plan_that_goes_on_is_used_at_once():
    controller = make(0.02)
    along_a_sine(controller, {})
    assert controller.state.doubt.aside == 0
    told = along_a_sine(make(0.02), {})
    untold = along_a_sine(make(0.02), dict.fromkeys(range(300), (None, None)))
    assert told[1] != untold[1]
