"""What the integral of the feedback is worth while the measurement is lost."""

import math

import numpy as np
import pytest
from closed_loops import SCENARIO, make

from adaptive_ff.adaptive.faults.held_integral import (
    MEAN,
    MEMORY,
    NONE,
    SINGLE,
    WHOLE,
    hold_integral,
    initial_held_integral,
)

PERIOD = 0.01


def after(integrals, leaves=0.0):
    """State after integrals (N m), one at each sample."""
    held = initial_held_integral()
    for integral in integrals:
        held, left = hold_integral(held, integral, leaves, 0.0, PERIOD)
        assert left == leaves
    return held


def test_means_follow_the_integral_and_its_magnitude():
    """Against first-order filters written down once more."""
    integrals = 20.0 + 30.0 * np.random.default_rng(1).standard_normal(400)
    mean, slow, magnitude = integrals[0], 0.0, 0.0
    for place, integral in enumerate(integrals):
        if place > 0:
            mean = (MEAN * mean + PERIOD * integral) / (MEAN + PERIOD)
        slow = (MEMORY * slow + PERIOD * abs(mean)) / (MEMORY + PERIOD)
        magnitude = (MEMORY * magnitude + PERIOD * abs(integral)) / (MEMORY + PERIOD)
    assert after(integrals) == pytest.approx((mean, slow, magnitude), rel=1e-12)


def test_what_the_feedforward_takes_over_leaves_the_mean_too():
    held = after([10.0])
    held, left = hold_integral(held, 10.0, 4.0, 0.0, PERIOD)
    assert left == 4.0
    assert held.mean == pytest.approx(6.0)


@pytest.mark.parametrize("leaves", [0.0, 3.0])
def test_noise_in_the_integral_is_dropped_where_the_measurement_is_lost(leaves):
    """With its mean left, however long the loss lasts."""
    noise = 5.0 * np.random.default_rng(2).standard_normal(2000)
    held = after(noise)
    assert held.slow / held.magnitude < NONE
    integral, expected = 12.0, held.mean - leaves
    for lost in range(2, 20):
        held, left = hold_integral(held, integral, leaves, float(lost), PERIOD)
        integral, leaves = integral - left, 0.0
        assert integral == pytest.approx(expected)


def test_a_weight_in_the_integral_is_held():
    weight = 40.0 * np.sin(2.0 * math.pi * 0.1 * PERIOD * np.arange(2000))
    held = after(weight)
    assert held.slow / held.magnitude > WHOLE
    _, left = hold_integral(held, 30.0, 0.0, 2.0, PERIOD)
    assert left == 0.0


def test_between_them_a_share_is_held():
    held = initial_held_integral()._replace(mean=2.0, slow=(NONE + WHOLE) / 2.0, magnitude=1.0)
    _, left = hold_integral(held, 10.0, 0.0, 2.0, PERIOD)
    assert left == pytest.approx(0.5 * (10.0 - 2.0))


def test_before_anything_is_known_of_it_the_integral_is_held():
    _, left = hold_integral(initial_held_integral(), 10.0, 0.0, 2.0, PERIOD)
    assert left == 0.0


def test_a_single_loss_changes_nothing():
    held = after(5.0 * np.random.default_rng(3).standard_normal(500))
    kept, left = hold_integral(held, 12.0, 1.0, SINGLE, PERIOD)
    assert left == 1.0
    assert kept == (held.mean - 1.0, held.slow, held.magnitude)


def test_the_controller_goes_on_from_the_mean():
    """Where it has learnt, the integral is its mean from the second lost sample on, and stays so."""
    controller = make("adaptive")
    rng, reference = np.random.default_rng(4), SCENARIO.modified(seed=101, duration=10.0).reference_velocity()[::10]
    for plan in reference[:-4]:
        controller.step(plan, plan + 0.002 * rng.standard_normal())
    controller.state = controller.state._replace(
        held=controller.state.held._replace(slow=1.0, magnitude=100.0),
        feedback=controller.state.feedback._replace(integral=25.0),
    )
    integrals = []
    for plan in reference[-4:]:
        controller.step(plan, math.nan)
        integrals.append(controller.state.feedback.integral)
    assert abs(integrals[0]) > 10.0
    assert integrals[1] == pytest.approx(controller.state.held.mean)
    assert integrals[1] == integrals[2] == integrals[3]
    assert abs(integrals[1]) < 10.0


@pytest.mark.parametrize(("name", "value"), [("mean", 1e12), ("mean", -1e12), ("slow", -1.0), ("magnitude", 1e12)])
def test_a_state_with_an_impossible_mean_is_refused(name, value):
    controller = make("adaptive")
    controller.state = controller.state._replace(held=controller.state.held._replace(**{name: value}))
    with pytest.raises(ValueError, match=f"state.held.{name}"):
        make("adaptive").state_from_json(controller.state_to_json())
