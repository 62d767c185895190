"""Ringing: what of an error is taken for it, and what an observer that is let go brings."""

import math

import numpy as np
import pytest

from adaptive_ff import load_scenario
from adaptive_ff.adaptive.supervision.observer_effect import (
    advance_effect,
    follow_half_cycles,
    initial_effect,
    restrain_ringing,
)
from adaptive_ff.adaptive.supervision.ringing import (
    MOST,
    TOGETHER,
    advance_ringing,
    beside_correction,
    far_error,
    initial_ringing,
    loudest,
    rings,
)
from adaptive_ff.adaptive.supervision.swift_ringing import Background
from adaptive_ff.comparison.registry import make_controller
from adaptive_ff.comparison.run import simulate
from adaptive_ff.studies.drawn_joints import draw_scenario
from tests.helpers.changed_effect import with_effect
from tests.helpers.judged import judge

PERIOD = 0.01
TIME_CONSTANT = 1.0 / (2.0 * np.pi * 10.0)
PEAK = 0.1
TIME = PERIOD * np.arange(100)
NO_NOISE = Background(0.0, False, 0.0)
SINE = np.sin(2.0 * np.pi * 9.0 * TIME)


def first_rings(error, *, variance=0.0, peak=PEAK, far=math.inf):
    """Return when an error is taken for ringing, s, or None."""
    state = initial_ringing()
    for index, value in enumerate(error):
        state = advance_ringing(state, value, variance, far, TIME_CONSTANT, PERIOD)
        if rings(state, variance, peak):
            return index * PERIOD
    return None


def test_a_loop_that_rings_is_noticed_after_three_half_cycles():
    assert first_rings(0.5 * PEAK * SINE) == pytest.approx(1.5 / 9.0, abs=PERIOD)


def test_the_smaller_the_error_the_later_ringing_is_noticed():
    assert first_rings(1.3 * TOGETHER / MOST * PEAK * SINE) > 6.0 * 0.5 / 9.0


def test_a_loop_whose_ringing_grows_is_noticed():
    assert first_rings(0.05 * PEAK * SINE * np.exp(5.0 * TIME)) is not None


def test_ringing_with_half_cycles_of_two_lengths_is_noticed():
    assert first_rings(PEAK * np.repeat(np.tile([1.0, -1.0], 10), np.tile([3, 9], 10))) is not None


@pytest.mark.parametrize(
    "error",
    [
        0.95 * TOGETHER / MOST * SINE,  # small beside the plan
        SINE * np.exp(-9.0 * TIME),  # what dies out by a half in each half cycle
        np.sin(2.0 * np.pi * 3.5 * TIME),  # slower than a loop rings
        np.sin(2.0 * np.pi * 33.0 * TIME),  # faster
        np.repeat(np.tile([1.0, -1.0], 10), np.tile([3, 15], 10)),  # every other half cycle too long
        np.where(np.mod(TIME, 0.5) < 0.05, 1.0, np.where(np.mod(TIME, 0.5) < 0.3, -1.0, 0.0)),  # pulses
        np.full(TIME.size, 1.0),
    ],
)
def test_errors_of_other_shapes_are_no_ringing(error):
    assert first_rings(PEAK * error) is None


def test_longer_half_cycles_count_where_neither_friction_nor_a_load_makes_such_errors():
    """A torque that may rise only slowly: each half cycle lasts as long as it takes to turn the friction round."""
    slow = np.sin(2.0 * np.pi * 2.0 * TIME)
    assert first_rings(PEAK * slow) is None
    assert first_rings(PEAK * slow, far=0.9 * PEAK) == pytest.approx(0.75, abs=1.5 * PERIOD)
    assert first_rings(PEAK * slow, far=1.1 * PEAK) is None
    assert first_rings(PEAK * np.sin(2.0 * np.pi * 1.0 * TIME), far=0.9 * PEAK) is None  # longer than it takes


def test_the_far_error_is_torque_over_gain_and_infinite_behind_an_outer_loop():
    assert far_error(100.0, 1000.0, 0.0) == pytest.approx(0.1)
    assert far_error(100.0, 1000.0, 1e-9) == math.inf  # where an outer loop asks for it, it may be that


def test_where_a_drive_has_seemed_to_saturate_far_errors_are_not_small_beside_the_plan():
    far, error = 0.02 * PEAK, 0.022 * PEAK * SINE
    assert first_rings(error) is None
    assert first_rings(error, peak=loudest(PEAK, far)) == pytest.approx(1.5 / 9.0, abs=1.5 * PERIOD)
    assert first_rings(0.8 * error[:18], peak=loudest(PEAK, far)) is None
    assert loudest(PEAK, 10.0 * PEAK) == PEAK


def test_noise_and_errors_within_it_are_no_ringing():
    assert first_rings(0.5 * PEAK * SINE, variance=(0.1 * PEAK) ** 2) is None
    noise = np.random.default_rng(101).normal(0.0, PEAK, 100_000)
    assert first_rings(noise, variance=PEAK**2) is None


@pytest.mark.parametrize(("correction", "left"), [(0.0, -0.3), (0.1, -0.1), (-0.1, -0.1), (0.2, 0.0), (-0.3, 0.0)])
def test_twice_the_correction_of_an_outer_loop_is_left_out_of_the_error(correction, left):
    assert beside_correction(-0.3, correction) == pytest.approx(left)


def effect_after(error, *, gain=1.0, turns=False, falls=False, begin=None):
    effect = initial_effect() if begin is None else begin
    for index, value in enumerate(error):
        turned = turns and index % 10 == 0
        effect = follow_half_cycles(effect, value, 0.0, NO_NOISE, math.inf, turned, TIME_CONSTANT, PERIOD)
        effect = restrain_ringing(effect, 0.0, NO_NOISE, PEAK, gain * effect.share, falls)
    return effect


def test_ringing_switches_the_observer_off_until_friction_is_found_to_fall():
    blamed = effect_after(PEAK * SINE)
    assert (blamed.share, blamed.ceiling, blamed.ringing.blamed) == (0.0, 0.0, True)
    excused = effect_after(PEAK * SINE, falls=True, begin=blamed)
    assert (excused.share, excused.ceiling, excused.ringing.blamed) == (1.0, 1.0, False)


def test_an_observer_that_was_off_for_ringing_does_not_come_back_by_itself():
    effect = effect_after(PEAK * SINE)
    for _ in range(10_000):
        effect = advance_effect(effect, 0.0, 0.1, 0.0, 0.0, PEAK, 0.0, True, PERIOD)
    assert (effect.share, effect.ceiling) == (0.0, 0.0)


def test_an_observer_stays_on_if_unused_or_if_the_plan_reverses_between_half_cycles_or_friction_falls():
    assert effect_after(PEAK * SINE, gain=0.4).share == 1.0
    assert effect_after(PEAK * SINE, turns=True).share == 1.0
    assert effect_after(PEAK * SINE, falls=True).share == 1.0


@pytest.mark.parametrize(
    ("late", "seed"), [({"lag": 0.013}, 104), ({"lag": 0.02}, 104), ({"lag": 0.03}, 103), ({"rate_limit": 2000.0}, 103)]
)
def test_an_unspecified_lag_of_the_drive_makes_no_window_much_worse_than_pi(late, seed):
    """Without the rule the lags make windows 3.7, 16 and 6.9 times as bad, the limited rate 2.1 times."""
    late = load_scenario().modified(seed=seed, duration=20.0, actuator={**late, "reports_torque": False})
    judgement = judge(late, draws=1)
    assert judgement.worst_window < 1.2
    assert judgement.settled > 1.0
    controller = make_controller(late, "adaptive")
    simulate(late, controller)
    assert controller.state.observer.effect.ringing.blamed
    assert "not used until the controller is reset" in " ".join(str(controller.diagnose()).split())
    controller.reset()
    assert not controller.state.observer.effect.ringing.blamed


def test_a_joint_that_sticks_and_slips_by_itself_gets_its_observer_back():
    """It hunts from 0.5 s on; with the observer out of use for good, 5 to 10 s leave 1.5 times the error of PI."""
    steep = draw_scenario(load_scenario(), 201, 11)
    judgement = judge(steep, draws=1)
    assert judgement.worst_window < 1.0
    controller = make_controller(steep, "adaptive")
    simulate(steep, controller)
    assert not controller.state.observer.effect.ringing.blamed


@pytest.mark.parametrize(("name", "value"), [("sign", 0.5), ("length", -1.0), ("sustained", -1)])
def test_impossible_half_cycles_are_refused(name, value):
    controller = with_effect(f"ringing.{name}", value)
    with pytest.raises(ValueError, match=rf"state\.observer\.effect\.ringing\.{name} = {value} is not allowed"):
        controller.state_from_json(controller.state_to_json())
