"""Whether the observer helps, told from the error that there is and the one that is predicted without it."""

import numpy as np
import pytest

from adaptive_ff import load_scenario
from adaptive_ff.adaptive.supervision.observer_effect import (
    FAR_WORSE,
    FORGIVES,
    LITTLE,
    NOTHING,
    RETURN,
    WORSE,
    advance_effect,
    demand_help,
    initial_effect,
)
from adaptive_ff.adaptive.supervision.observer_gates import helping_share
from adaptive_ff.adaptive.supervision.observer_state import initial_observer
from adaptive_ff.comparison.registry import make_controller
from adaptive_ff.comparison.run import simulate
from benchmarks.cases.situations import named_scenario
from controllers import check_gains
from tests.helpers.changed_effect import with_effect
from tests.helpers.judged import judge

PERIOD = 0.01


def after(duration, error, *, predicted=0.1, correction=0.0, variance=0.0, peak=0.1, gain=1.0, begin=None):
    effect = initial_effect() if begin is None else begin
    for _ in range(round(duration / PERIOD)):
        effect = advance_effect(effect, error, predicted, correction, variance, peak, gain * effect.share, True, PERIOD)
    return effect


def test_an_observer_that_leaves_less_than_the_loop_would_is_used_in_full():
    assert after(3.0, 0.1 * np.sqrt(0.99 * WORSE)).share == 1.0


def test_an_observer_that_leaves_far_more_is_not_used():
    assert after(3.0, 0.1 * np.sqrt(1.01 * FAR_WORSE)).share <= PERIOD / RETURN  # a sample of its return


def test_an_observer_half_way_between_is_used_by_half():
    assert after(3.0, 0.1 * np.sqrt(0.5 * (WORSE + FAR_WORSE))).share == pytest.approx(0.5)


def test_noise_and_the_correction_of_an_outer_loop_do_not_count_against_the_observer():
    error = 0.1 * np.sqrt(1.5)
    assert after(3.0, error).share <= PERIOD / RETURN
    assert after(3.0, error, variance=0.006).share == 1.0
    assert after(3.0, error, correction=0.1).share == 1.0


def test_an_observer_out_of_use_is_not_held_back():
    assert after(3.0, 0.3, gain=0.4).share == 1.0


def test_an_error_that_is_small_beside_the_plan_does_not_count():
    assert after(3.0, 0.3, peak=3.0).share == 1.0


def test_the_share_comes_back_slowly():
    bad = after(3.0, 0.3)
    assert bad.share <= PERIOD / RETURN
    quiet = after(5.0, 0.01, gain=0.0, begin=bad)
    assert quiet.share == pytest.approx(5.0 / RETURN, rel=0.01)


def helped(ratio, *, correction=0.0, gain=1.0, coloured=True, variance=0.0):
    """Return the share after a squared error that is a share of what is predicted without the observer."""
    effect, error = initial_effect(), 0.1 * np.sqrt(ratio)
    for _ in range(round(3.0 / PERIOD)):
        effect = demand_help(effect, error, 0.1, correction, variance, gain * effect.help, coloured, PERIOD)
    return effect.help


def test_beside_coloured_noise_an_observer_must_help():
    assert helped(0.99 * LITTLE) == 1.0
    assert helped(1.01 * NOTHING) <= PERIOD / RETURN  # a sample of its return
    assert helped(0.5 * (LITTLE + NOTHING)) == pytest.approx(0.5, rel=1e-3)


def test_an_observer_need_not_help_beside_white_noise_out_of_use_or_behind_an_outer_loop():
    assert helped(1.0, coloured=False) == 1.0
    assert helped(1.0, gain=0.4) == 1.0
    assert helped(1.0, correction=0.05) == 1.0
    assert helped(1.0, variance=0.003) == 1.0


def shaken(error, *, variance=0.0, peak=0.35, gain=1.0, predicted=1.0):
    """Return the state after a series of errors, each of which would have been larger without the observer."""
    effect = initial_effect()
    for value in error:
        effect = advance_effect(effect, value, predicted, 0.0, variance, peak, gain * effect.share, True, PERIOD)
    return effect


TIME = PERIOD * np.arange(500)
OSCILLATION = 0.05 * np.sin(2.0 * np.pi * 4.0 * TIME)


def test_a_steady_oscillation_switches_the_observer_off_whatever_is_predicted():
    assert shaken(OSCILLATION[:200]).ceiling < 0.02
    assert shaken(OSCILLATION[:200]).share < 0.02


def test_the_ceiling_that_an_oscillation_leaves_rises_slowly():
    bad = shaken(OSCILLATION[:200])
    quiet = after(30.0, 0.001, gain=0.0, begin=bad)
    assert quiet.share == pytest.approx(bad.ceiling + 30.0 / FORGIVES, abs=0.01)


@pytest.mark.parametrize(
    "error",
    [
        np.where(np.mod(TIME, 1.0) < 0.2, 0.1, 0.0) * np.sign(np.sin(2.0 * np.pi * 0.5 * TIME)),  # reversals
        np.full(TIME.size, 0.05),  # a ramp with a wrong inertia
        np.random.default_rng(101).normal(0.0, 0.05, TIME.size),  # what is not steady
        0.2 * OSCILLATION,  # small beside the plan
    ],
)
def test_errors_of_other_shapes_are_no_steady_oscillation(error):
    assert shaken(error).ceiling == 1.0


def test_an_oscillation_without_the_observer_or_within_the_noise_does_not_count():
    assert shaken(OSCILLATION, gain=0.4).ceiling == 1.0
    assert shaken(OSCILLATION, variance=0.5 * 0.05**2).ceiling == 1.0


def test_beside_a_small_steady_oscillation_an_observer_must_help_whatever_it_observes():
    small = shaken(0.1 * OSCILLATION)
    assert (small.ceiling, small.share) == (1.0, 1.0)
    left = demand_help(small, 0.1, 0.1, 0.0, 0.0, 1.0, False, PERIOD)
    assert left.help <= PERIOD / RETURN
    assert demand_help(shaken(np.full(500, 0.005)), 0.1, 0.1, 0.0, 0.0, 1.0, False, PERIOD).help == 1.0
    within_noise = 0.1**2 * 0.05**2
    assert demand_help(small, 0.1, 0.1, 0.0, within_noise, 1.0, False, PERIOD).help == 1.0
    state = initial_observer(check_gains(1000.0, 0.0, PERIOD))
    much = state._replace(effect=left, squared=60.0**2, disturbance=60.0)
    assert helping_share(much, 60.0) == left.help
    assert helping_share(much._replace(effect=initial_effect()._replace(help=0.0)), 60.0) == 1.0


@pytest.mark.parametrize("name", ["sensor_ripple_60", "sensor_ripple_120"])
def test_a_sensor_that_ripples_as_the_joint_turns_is_not_followed(name):
    assert judge(named_scenario(name, 101), draws=1).settled > 1.0


def test_diagnosis_says_that_a_sensor_ripples():
    scenario = named_scenario("sensor_ripple_120", 101)
    controller = make_controller(scenario, "adaptive")
    simulate(scenario, controller)
    assert "ripples as the joint turns" in " ".join(controller.diagnose().supervision)


@pytest.mark.parametrize(("name", "value"), [("share", 1.5), ("ceiling", -0.1), ("help", 1.1)])
def test_a_state_with_an_impossible_share_is_refused(name, value):
    controller = with_effect(name, value)
    with pytest.raises(ValueError, match=rf"state\.observer\.effect\.{name} = {value} is not allowed"):
        controller.state_from_json(controller.state_to_json())


@pytest.mark.parametrize("lag", [0.013, 0.02])
def test_an_observer_is_switched_off_where_an_unspecified_lag_of_the_drive_makes_it_oscillate(lag):
    late = load_scenario().modified(seed=101, actuator={"lag": lag, "reports_torque": False})
    assert judge(late, draws=1).settled > 1.5  # 0.45 and 0.33 where it stays
    controller = make_controller(late, "adaptive")
    simulate(late, controller)
    assert any(
        "the loop oscillated with it" in line for line in str(controller.diagnose()).replace("\n", " ").split(". ")
    )


@pytest.mark.parametrize("seed", [101, 102])
def test_a_loop_behind_a_coarse_encoder_does_not_oscillate(seed):
    coarse = load_scenario().modified(
        seed=seed,
        duration=40.0,
        sensor={"velocity_noise": 0.0, "encoder_resolution": 2.0 * np.pi / 4096},
        velocity={"method": "kalman"},
        feedback={"bandwidth": 6.0},
    )
    assert judge(coarse).settled > 0.7  # 0.15 and 0.2 where the observer stays
