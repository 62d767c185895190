"""What an outer loop can tell of a joint at rest."""

import math

import numpy as np
import pytest
from closed_loops import SCENARIO, make

from adaptive_ff import simulate
from adaptive_ff.adaptive.at_rest.outer_loop import (
    ENOUGH,
    SETTLED,
    initial_outer_loop,
    note_correction,
    unseen_error,
    unseen_velocity,
)
from benchmarks.cases.holding import held_joints, scenario_of

COUNT, PERIOD, GAIN = 6e-6, 0.01, 10.0
STEP = GAIN * COUNT


def after_kicks(counts, start=0.3, rests=True):
    """State after readings of the encoder, in counts; the plan rests between two of them."""
    state, before = initial_outer_loop(), counts[0]
    for reading in counts:
        velocity = (reading - before) * COUNT / PERIOD
        state, before = note_correction(state, GAIN * COUNT * (start - reading), velocity, rests, PERIOD), reading
    return state


def test_a_count_is_the_least_step_that_comes_again_and_again():
    state = after_kicks([9, 5, 3, 2, 1, 0, 1])
    assert state.step == pytest.approx(STEP)
    assert state.seen == ENOUGH
    assert unseen_error(state, True) == pytest.approx(-0.7 * STEP)
    assert unseen_error(state, False) == 0.0


def test_of_a_larger_error_a_count_is_left_out():
    state = after_kicks([0, 1, 0, 1, 0, 1, 5, 8])
    assert unseen_error(state, True) == pytest.approx(-STEP)


def test_larger_steps_than_the_least_do_not_count():
    assert after_kicks([0, 1, 4, 8, 12, 16]).seen == 1


def test_nothing_is_taken_from_a_plan_that_moves():
    assert after_kicks([0, 1, 0, 1, 0, 1], rests=False).seen == 0


def test_a_noisy_position_makes_no_count():
    readings = 5.0 * np.random.default_rng(101).standard_normal(2000)
    assert after_kicks(list(readings)).seen < ENOUGH


def test_a_joystick_in_steps_is_followed():
    """The joint moves because of the correction, which is no error of an encoder then."""
    state, velocity = initial_outer_loop(), 0.0
    for k in range(4000):
        wanted = 0.01 * (k // 100 % 2)
        velocity += 0.1 * (wanted - velocity)
        state = note_correction(state, wanted, velocity, True, PERIOD)
        assert unseen_error(state, True) == 0.0


def shown_to_the_feedback(counts, state, sign=1.0):
    """Displacement, in counts, of which the feedback is shown the velocity; and what it is shown at each sample."""
    shown, before = [], counts[0]
    for reading in counts[1:]:
        velocity, correction = sign * (reading - before) * COUNT / PERIOD, sign * GAIN * COUNT * (0.3 - reading)
        shown.append((velocity - unseen_velocity(state, correction, velocity, True)) * PERIOD / COUNT)
        state, before = note_correction(state, correction, velocity, True, PERIOD), reading
    return np.array(shown)


@pytest.mark.parametrize("sign", [1.0, -1.0])
def test_a_count_there_and_back_is_no_velocity(sign):
    known = initial_outer_loop()._replace(correction=sign * GAIN * COUNT * 0.3, step=STEP, seen=ENOUGH, rested=SETTLED)
    shown = shown_to_the_feedback([0, 1, 0, 0, 1, 0, 1, 1, 0], known, sign)
    assert shown[0] == pytest.approx(0.5 * sign)  # which side of the play the joint is on is not known before
    assert shown[1:] == pytest.approx(np.zeros(7), abs=1e-9)


def test_of_a_motion_that_goes_on_nothing_but_half_a_count_is_hidden():
    known = initial_outer_loop()._replace(correction=GAIN * COUNT * 0.3, step=STEP, seen=ENOUGH, rested=SETTLED)
    assert shown_to_the_feedback([0, 1, 2, 3, 6, 7], known) == pytest.approx([0.5, 1.0, 1.0, 3.0, 1.0])
    back = shown_to_the_feedback([0, 3, 2, 1, 0], known)
    assert back == pytest.approx([2.5, 0.0, -1.0, -1.0])


def test_nothing_is_hidden_before_the_count_is_known_nor_while_the_plan_moves():
    velocity = COUNT / PERIOD
    known = initial_outer_loop()._replace(step=STEP, seen=ENOUGH, rested=SETTLED)
    assert unseen_velocity(known, -STEP, velocity, True) == pytest.approx(0.5 * velocity)
    assert unseen_velocity(known._replace(seen=ENOUGH - 1), -STEP, velocity, True) == 0.0
    assert unseen_velocity(known, -STEP, velocity, False) == 0.0
    assert unseen_velocity(known, STEP, velocity, True) == 0.0  # no motion has made it
    assert unseen_velocity(known, -STEP, math.nan, True) == 0.0


def test_a_joint_that_settles_is_damped_in_full():
    known = initial_outer_loop()._replace(correction=GAIN * COUNT * 0.3, step=STEP, seen=ENOUGH)
    toggling = [k % 2 for k in range(round(SETTLED / PERIOD) + 10)]
    shown = shown_to_the_feedback(toggling, known)
    assert np.abs(shown[:-12]) == pytest.approx(np.ones(shown.size - 12))
    assert shown[-7:] == pytest.approx(np.zeros(7), abs=1e-9)
    moved = note_correction(known._replace(rested=SETTLED), 0.0, 0.0, False, PERIOD)
    assert moved.rested == 0.0


def test_play_is_in_its_middle_after_a_motion():
    assert note_correction(after_kicks([0, 1, 0, 1, 0, 1]), 0.0, 0.0, False, PERIOD).play == 0.0


@pytest.mark.parametrize("seed", [105, 119])
def test_joint_with_stiff_bristles_rests(seed):
    """Where the integral winds up on a fraction of a count, PI kicks the joint all the time."""
    case = next(case for case in held_joints() if case.name == "LuGre 1e+05, 20 kg m^2, 500 Hz")
    steps, rest = {}, {}
    for name in ("pi", "adaptive"):
        run = simulate(scenario_of(case, seed), name)
        held = run.time >= run.time[-1] - 5.0
        steps[name] = np.diff(run.torque[held])
        rest[name] = run.position_error[run.solver_time >= run.time[-1] - 5.0]
    assert np.max(np.abs(steps["pi"])) > 1.0
    assert np.max(np.abs(steps["adaptive"])) < 0.01
    assert np.max(np.abs(rest["adaptive"])) < 1.5 * COUNT


def test_a_lost_measurement_leaves_the_integral_alone():
    controller = make("adaptive")
    for plan in SCENARIO.modified(seed=101, duration=5.0).reference_velocity()[::10]:
        controller.step(plan, plan)
    for _ in range(3):
        controller.step(0.0, 0.0, correction=0.5 * STEP)
    known = controller.state.outer._replace(step=STEP, seen=ENOUGH)
    controller.state = controller.state._replace(outer=known)
    before = controller.state.feedback.integral
    controller.step(0.0, 0.0, correction=0.5 * STEP)
    assert controller.state.feedback.integral == pytest.approx(before, abs=1e-9)
    controller.step(0.0, math.nan, correction=0.5 * STEP)
    assert controller.state.feedback.integral == pytest.approx(before, abs=1e-9)


@pytest.mark.parametrize(
    ("name", "value"),
    [
        ("step", -1.0),
        ("step", 1e999),
        ("seen", -1),
        ("seen", ENOUGH + 1),
        ("play", 1.0),
        ("play", math.nan),
        ("rested", 1.5),
        ("rested", -0.5),
    ],
)
def test_a_state_with_an_impossible_step_is_refused(name, value):
    controller = make("adaptive")
    controller.state = controller.state._replace(outer=controller.state.outer._replace(**{name: value}))
    with pytest.raises(ValueError, match=f"state.outer.{name}"):
        make("adaptive").state_from_json(controller.state_to_json())
