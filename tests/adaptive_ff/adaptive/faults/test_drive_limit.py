"""Torque of a drive that saturates untold is neither learnt from nor observed; other torque is."""

import itertools
import math

import numpy as np
import pytest
from closed_loops import SCENARIO

from adaptive_ff import AdaptiveController, simulate
from adaptive_ff.adaptive.faults.drive_limit import (
    ANSWERED,
    IMPOSSIBLE,
    LOOSENS,
    advance_drive_limit,
    answered_share,
    believed_share,
    given_torque,
    is_impossible,
    reassured,
    without_never_given,
)
from adaptive_ff.adaptive.faults.drive_limit_state import PATIENCE, initial_drive_limit
from adaptive_ff.adaptive.faults.proven_torque import BELIEVED, GIVEN
from controllers import PI

PERIOD, INERTIA = 0.01, 20.0
FEEDBACK = PI.design(inertia=INERTIA, period=PERIOD, bandwidth=10.0)
PARAMETERS = PI(FEEDBACK.proportional, FEEDBACK.integral, PERIOD).parameters
FRICTION = 90.0
TIME = FEEDBACK.proportional / FEEDBACK.integral
NEVER = math.inf


def pulled(state, torque, *, seconds, plan=0.5, velocity=0.5, variance=0.0, answer=0.0):
    """The state after a time in which a joint moved at a constant speed under a constant torque."""
    for _ in range(round(seconds / PERIOD)):
        state = advance_drive_limit(
            state, PARAMETERS, INERTIA, torque, plan, velocity, 0.02, variance=variance, answer=answer, duration=PERIOD
        )
    return state


def following(torque=80.0):
    return pulled(initial_drive_limit()._replace(velocity=0.5), torque, seconds=2.0)


def test_a_torque_is_proven_by_a_joint_that_follows_with_it():
    state = following()
    assert state.proven == pytest.approx(80.0, rel=1e-3)
    assert state.given == pytest.approx(GIVEN * 80.0, rel=1e-3)
    assert (state.unproven, believed_share(state, FRICTION)) == (False, 1.0)


def test_a_larger_one_is_doubted_until_the_joint_has_followed_with_it_too():
    doubted = pulled(following(), 200.0, seconds=2.0 * TIME)
    assert doubted.unproven
    assert doubted.proven == pytest.approx(80.0, rel=1e-3)
    assert pulled(doubted, 200.0, seconds=40.0 * TIME).proven == pytest.approx(200.0, rel=1e-2)


def test_a_joint_that_follows_with_a_larger_one_is_not_doubted_meanwhile():
    following_on = pulled(following(), 120.0, seconds=1.5 * TIME)
    assert (following_on.unproven, following_on.doubt) == (True, 0.0)
    assert pulled(following_on, 120.0, seconds=4.0 * TIME).proven > 110.0
    behind = pulled(following(), 120.0, seconds=1.5 * TIME, velocity=0.4)
    assert behind.unproven
    assert behind.doubt > 0.5


def test_at_a_limit_the_torque_is_doubted_for_good_and_only_the_feedback_is_left():
    state = pulled(following(), 900.0, seconds=5.0, plan=0.6)
    assert (state.unproven, believed_share(state, FRICTION)) == (True, 0.0)
    assert state.proven == pytest.approx(80.0, rel=1e-3)
    assert state.largest == pytest.approx(900.0, rel=1e-3)
    assert given_torque(state, 900.0, 0.0) == pytest.approx(GIVEN * 80.0, rel=1e-3)
    assert given_torque(state, -900.0, 100.0) == pytest.approx(100.0 - GIVEN * 80.0, rel=1e-3)


def test_a_drive_that_has_been_doubted_for_long_is_given_another_chance_and_the_next_one_later():
    state = pulled(following(), 900.0, seconds=5.0, plan=0.6)
    assert state.established
    again = pulled(state, 900.0, seconds=0.9 * PATIENCE * TIME - 5.0, plan=0.6)
    assert (again.established, again.patience) == (True, PATIENCE)
    while again.established:
        again = pulled(again, 900.0, seconds=PERIOD, plan=0.6)
    assert believed_share(again, FRICTION) == 1.0
    assert again.patience == 2.0 * PATIENCE
    assert again.proven == pytest.approx(state.proven, rel=0.2)
    doubted = pulled(again, 900.0, seconds=5.0, plan=0.6)
    assert (doubted.established, believed_share(doubted, FRICTION)) == (True, 0.0)


def test_a_joint_that_is_at_rest_waits_for_nothing():
    state = pulled(following(), 900.0, seconds=5.0, plan=0.6)
    assert pulled(state, 900.0, seconds=5.0, plan=0.0, velocity=0.0).waited == state.waited


def test_a_report_ends_the_doubt_in_the_time_in_which_it_came_and_leaves_what_is_proven():
    state = pulled(following(), 900.0, seconds=5.0, plan=0.6)
    told = reassured(state, PARAMETERS, PERIOD)
    assert not told.unproven
    assert told.given == 0.0
    while told.doubt > 0.0:
        told = reassured(told, PARAMETERS, PERIOD)
    assert believed_share(told, FRICTION) == 1.0
    assert told.proven == state.proven
    assert reassured(told, PARAMETERS, PERIOD) is told


def test_before_anything_is_proven_no_more_is_fed_than_the_feedback_has_asked_for():
    state = pulled(initial_drive_limit(), 40.0, seconds=2.0 * PERIOD, plan=0.6, answer=-40.0)
    assert state.answered == pytest.approx(40.0, rel=0.01)
    assert answered_share(state, 100.0) == answered_share(state, -100.0) == pytest.approx(0.4 * ANSWERED, rel=0.01)
    assert answered_share(state, 40.0) == 1.0
    assert answered_share(pulled(state, 80.0, seconds=2.0), 1e3) == 1.0
    assert answered_share(initial_drive_limit(), 1e3) == 1.0


def test_the_bound_before_a_proof_loosens_while_nothing_is_doubted():
    pulls = initial_drive_limit()._replace(torque=40.0, velocity=0.5)
    state = pulled(pulls, 40.0, seconds=PERIOD, plan=0.6, answer=40.0)
    later = pulled(state, 40.0, seconds=LOOSENS * TIME, plan=0.6, answer=40.0)
    assert (later.doubt, later.proven) == (0.0, 0.0)
    assert later.answered == pytest.approx(40.0 * math.e, rel=0.02)
    assert pulled(later, 40.0, seconds=5.0, plan=0.0, velocity=0.0).answered == later.answered


def test_no_bound_before_a_proof_with_a_given_model_or_a_drive_that_has_reported():
    state = pulled(initial_drive_limit(), 40.0, seconds=PERIOD, plan=0.6, answer=40.0)
    assert answered_share(reassured(state, PARAMETERS, PERIOD), 1e3) == 1.0
    given = pulled(initial_drive_limit(model_given=True), 40.0, seconds=PERIOD, plan=0.6, answer=40.0)
    assert answered_share(given, 1e3) == 1.0


def test_the_integral_takes_over_nothing_that_was_never_given():
    state = pulled(following(), 900.0, seconds=5.0, plan=0.6)
    never = 900.0 - BELIEVED * 80.0
    assert without_never_given(state, -1000.0, 50.0) == pytest.approx(never - 1000.0, rel=0.01)
    assert without_never_given(state, 1000.0, -50.0) == pytest.approx(1000.0 - never, rel=0.01)
    assert without_never_given(state, -100.0, 50.0) == 0.0
    assert without_never_given(state, 100.0, 50.0) == 100.0
    assert without_never_given(following(), -1000.0, 50.0) == -1000.0


def test_what_is_asked_for_within_reason_is_believed_at_once():
    state = pulled(following(), 0.95 * BELIEVED * 80.0, seconds=0.5, plan=0.6)
    assert not state.unproven


def test_what_was_proven_by_mistake_falls_to_what_is_needed():
    assert pulled(following(800.0), 80.0, seconds=30.0).proven < 200.0


def test_friction_far_beyond_what_is_proven_is_fed_as_far_as_it_can_be():
    state = following()
    assert believed_share(state, 10.0 * IMPOSSIBLE * 80.0) == pytest.approx(0.1, rel=1e-3)
    assert believed_share(initial_drive_limit(), 1e6) == 1.0


@pytest.mark.parametrize(("friction", "impossible"), [(100.0, False), (500.0, True)])
def test_impossible_friction_is_found_at_the_first_proof(friction, impossible):
    assert is_impossible(initial_drive_limit(), following(), friction) == impossible
    assert not is_impossible(following(), following(), friction)


def test_without_a_limit_all_is_taken_to_have_acted():
    assert given_torque(initial_drive_limit(), 1e6, 0.0) == 1e6


def test_a_drive_that_saturates_from_the_first_motion_on_is_learnt_from_once_the_joint_follows():
    state, torque = initial_drive_limit(), 10.0
    for _ in range(100):
        torque *= 1.05
        state = pulled(state, torque, seconds=PERIOD, plan=0.6)
    assert (state.suspect, state.unproven, believed_share(state, FRICTION), state.proven) == (True, True, 0.0, 0.0)
    forgotten = False
    for _ in range(300):
        state = pulled(state, 80.0, seconds=PERIOD)
        forgotten = forgotten or state.anew
    assert forgotten
    assert not state.suspect
    assert state.proven == pytest.approx(80.0, rel=0.2)  # a mean, which holds some of the torque before
    assert pulled(state, 80.0, seconds=30.0).proven == pytest.approx(80.0, rel=0.01)


def test_noise_is_no_resistance():
    generator, state, deviation = np.random.default_rng(101), following(), 0.01
    for _ in range(2000):
        velocity = 0.5 + deviation * generator.standard_normal()
        torque = 80.0 + FEEDBACK.proportional * (0.5 - velocity)
        state = pulled(state, torque, seconds=PERIOD, velocity=velocity, variance=deviation**2)
        assert believed_share(state, FRICTION) == 1.0
    assert 60.0 < state.proven < 120.0


def along(controller, limit, *, peak=0.8, seconds=60.0, reports=False):
    """The error in the second half of a sine with a drive of a limit (N m), and the largest torque asked for."""
    plan = peak * np.sin(0.2 * np.pi * PERIOD * np.arange(round(seconds / PERIOD)))
    generator, velocity, errors, asked, realised = np.random.default_rng(101), 0.0, [], [], math.nan
    for now, after in itertools.pairwise(plan):
        more = {"realised_torque": realised} if reports and math.isfinite(realised) else {}
        measured = velocity + 0.002 * generator.standard_normal()
        asked.append(controller.step(now, measured, next_reference=after, **more))
        realised = min(max(asked[-1], -limit), limit)
        for _ in range(10):
            free = velocity + 0.1 * PERIOD * (realised - 80.0 * velocity) / INERTIA
            velocity = math.copysign(max(0.0, abs(free) - 0.1 * PERIOD * 60.0 / INERTIA), free)
        errors.append(after - velocity)
    return float(np.sqrt(np.mean(np.square(errors[len(errors) // 2 :])))), max(map(abs, asked))


def make(kind=AdaptiveController, **told):
    return kind(FEEDBACK.proportional, FEEDBACK.integral, PERIOD, inertia=INERTIA, stribeck_velocity=0.05, **told)


def test_the_built_in_joint_beside_a_limit_is_tracked_and_identified_as_well_as_can_be():
    """The error was ten times that of PI, with friction of 9000 N m."""
    controller = make()
    error, asked = along(controller, 120.0)
    alone, wound_up = along(PI(FEEDBACK.proportional, FEEDBACK.integral, PERIOD), 120.0)
    assert error < 1.1 * alone
    assert asked < 1.3 * wound_up
    assert controller.estimates["coulomb"] == pytest.approx(60.0, rel=0.15)
    assert controller.estimates["inertia"] == pytest.approx(INERTIA, rel=0.1)


@pytest.mark.parametrize("told", [{"torque_limit": 120.0}, {}])
def test_a_drive_that_is_known_is_not_watched(told):
    controller = make(**told)
    along(controller, 120.0, seconds=10.0, reports=not told)
    assert controller.state.drive == initial_drive_limit()._replace(bounded=False)


def test_where_nothing_saturates_an_unreported_torque_costs_nothing():
    told = simulate(SCENARIO, "adaptive").metrics.rms_error
    untold = simulate(SCENARIO.modified(actuator={"reports_torque": False}), "adaptive").metrics.rms_error
    assert untold < 1.1 * told


@pytest.mark.parametrize(("field", "value"), [("proven", -1.0), ("moved", math.nan), ("doubt", 3.0), ("given", NEVER)])
def test_an_impossible_state_of_a_drive_is_refused(field, value):
    controller = make()
    state = controller.state
    with pytest.raises(ValueError, match=rf"state\.drive\.{field} = {value} is not allowed"):
        controller._check_state(state._replace(drive=state.drive._replace(**{field: value})))
