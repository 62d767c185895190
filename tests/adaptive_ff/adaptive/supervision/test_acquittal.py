"""A joint that oscillates without the observer as well gets it back, where it helps; a drive that is late does not."""

import math

import numpy as np
import pytest

from adaptive_ff import load_scenario, simulate
from adaptive_ff.adaptive.supervision.acquittal import (
    ACQUITTED,
    ENOUGH,
    GUILTY,
    LASTS,
    TRIED,
    UNUSED,
    WAITS,
    advance_acquittal,
    initial_acquittal,
)
from adaptive_ff.adaptive.supervision.observer_effect import (
    advance_effect,
    follow_half_cycles,
    initial_effect,
    restrain_ringing,
)
from adaptive_ff.adaptive.supervision.swift_ringing import Background
from adaptive_ff.comparison.registry import make_controller
from tests.helpers.changed_effect import with_effect

PERIOD, PEAK = 0.01, 0.35
LEFT = 0.01  # squared error, rad^2/s^2


def after(seconds, *, begin=None, error=LEFT, expected=LEFT, oscillates=True, let_go=True, blamed=True, gain=0.0):
    state = initial_acquittal() if begin is None else begin
    for _ in range(round(seconds / PERIOD)):
        state = advance_acquittal(state, error, expected, oscillates, let_go, blamed, gain, PERIOD)
    return state


def test_a_trial_begins_once_the_error_has_oscillated_for_long_enough_without_the_observer():
    assert after(ENOUGH - 2.0 * PERIOD).stage == WAITS
    tried = after(ENOUGH + PERIOD, expected=2.0 * LEFT)
    assert tried.stage == TRIED
    assert tried.without == pytest.approx(0.5)
    # and no evidence is lost while it does not oscillate for a while
    assert after(ENOUGH, begin=after(5.0, begin=after(1.0), oscillates=False)).stage == TRIED


@pytest.mark.parametrize("other", [{"oscillates": False}, {"let_go": False}, {"gain": 2.0 * UNUSED}])
def test_no_trial_begins_without_an_oscillation_or_with_the_observer_in_use(other):
    assert after(20.0, **other).stage == WAITS


@pytest.mark.parametrize(("left", "stage"), [(0.3, ACQUITTED), (0.95, ACQUITTED), (1.05, GUILTY)])
def test_at_the_end_of_the_trial_the_observer_is_acquitted_if_it_leaves_less(left, stage):
    tried = after(ENOUGH + PERIOD)
    meanwhile = after(LASTS - 2.0 * PERIOD, begin=tried, error=left * LEFT, gain=1.0)
    assert meanwhile.stage == TRIED
    assert after(4.0 * PERIOD, begin=meanwhile, error=left * LEFT, gain=1.0).stage == stage


def test_the_trial_ends_as_soon_as_the_observer_leaves_a_tenth_more():
    tried = after(ENOUGH + PERIOD)
    assert after(1.0, begin=tried, error=2.0 * LEFT, gain=1.0).stage == GUILTY


def test_a_motion_that_makes_more_error_itself_does_not_count_against_the_observer():
    tried = after(ENOUGH + PERIOD)
    assert after(LASTS + PERIOD, begin=tried, error=3.0 * LEFT, expected=6.0 * LEFT, gain=1.0).stage == ACQUITTED


def oscillating(seconds, effect, *, amplitude=0.1, share=0.5, believed=True, variance=0.0):
    """Go on with an error that oscillates at 4 Hz, of which the observer takes a share where it is used."""
    for wave in amplitude * np.sin(2.0 * np.pi * 4.0 * PERIOD * np.arange(round(seconds / PERIOD))):
        used, gain = effect.share > 0.5, effect.share
        error = (1.0 - share) * wave if used else wave
        effect = advance_effect(effect, error, wave, 0.0, variance, PEAK, gain, believed, PERIOD)
        beside = Background(variance, False, 0.0)
        effect = follow_half_cycles(effect, error, variance, beside, math.inf, False, 0.05, PERIOD)
        effect = restrain_ringing(effect, variance, beside, PEAK, gain, False)
    return effect


@pytest.fixture(scope="module")
def let_go():
    """An observer that was let go of for an oscillation that it makes no better at first."""
    effect = oscillating(2.0, initial_effect(), share=0.0)
    assert effect.ceiling == 0.0
    return effect


def test_an_observer_that_helps_is_used_for_good(let_go):
    effect = oscillating(ENOUGH + LASTS + 30.0, let_go)
    assert effect.acquittal.stage == ACQUITTED
    assert (effect.share, effect.ceiling, effect.ringing.blamed) == (1.0, 1.0, False)


def test_an_observer_that_does_not_help_is_off_for_good_again_after_its_trial(let_go):
    assert let_go.ringing.blamed
    effect = oscillating(ENOUGH + LASTS + 30.0, let_go, share=-0.2)
    assert effect.acquittal.stage == GUILTY
    assert (effect.share, effect.ceiling, effect.ringing.blamed) == (0.0, 0.0, True)


def test_an_observer_that_was_off_for_a_while_is_so_again_after_its_trial():
    tried = after(ENOUGH + PERIOD, blamed=False)
    effect = initial_effect()._replace(acquittal=tried)
    for _ in range(500):
        effect = advance_effect(effect, 0.2, 0.1, 0.0, 0.0, PEAK, 1.0, True, PERIOD)
    assert effect.acquittal.stage == GUILTY
    assert not effect.ringing.blamed
    assert effect.ceiling < 0.1


@pytest.mark.parametrize("other", [{"believed": False}, {"variance": 0.02**2}, {"amplitude": 0.0}])
def test_no_trial_begins_at_a_limit_for_noise_or_where_the_oscillation_has_died_out(let_go, other):
    assert oscillating(20.0, let_go, **other).acquittal.stage == WAITS


def run(**actuator):
    scenario = load_scenario().modified(seed=101, actuator={"reports_torque": False, **actuator})
    controller = make_controller(scenario, "adaptive")
    errors = [simulate(scenario, one).metrics.rms_error_settled for one in (controller, "pi")]
    return controller, errors[1] / errors[0]


def test_a_joint_with_cogging_keeps_its_observer():
    """Without the rule it is let go of, and the joint tracks as with PI alone: 1.01 times better."""
    controller, improvement = run(ripple_amplitude=30.0, ripple_period=0.02)
    assert improvement > 1.4
    assert controller.state.observer.effect.acquittal.stage == ACQUITTED
    assert "give it as ripple_periods" in " ".join(str(controller.diagnose()).split())


def test_a_late_drive_gets_no_trial():
    controller, _ = run(lag=0.02)
    assert controller.state.observer.effect.ringing.blamed
    assert controller.state.observer.effect.acquittal.stage == WAITS


def test_diagnosis_says_that_a_guilty_observer_does_not_lessen_the_oscillation():
    said = " ".join(str(with_effect("acquittal.stage", GUILTY).diagnose()).split())
    assert "takes nothing of an oscillation that is there without it as well, as with cogging" in said


@pytest.mark.parametrize(("name", "value"), [("stage", 4), ("stage", -1), ("time", -1.0), ("squared", -1e-9)])
def test_an_impossible_state_of_a_trial_is_refused(name, value):
    controller = with_effect(f"acquittal.{name}", value)
    with pytest.raises(ValueError, match=rf"^state\.observer\.effect\.acquittal\.{name} = {value} is not allowed"):
        controller.state_from_json(controller.state_to_json())
