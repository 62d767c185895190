"""Trust in the friction that is fed forward."""

import json
import math

import numpy as np
import pytest
from closed_loops import SCENARIO, begin, course_along, lay_course, make, run_compiled
from hypothesis import given
from hypothesis import strategies as st

from adaptive_ff.adaptive.supervision.trust import (
    GRACE,
    LEARNT,
    MISSED,
    PEAK_MEMORY,
    RISE,
    SLOWER,
    SOFT_GRACE,
    SPAN,
    advance_trust,
    caution,
    initial_trust,
    soft_bound,
    with_friction,
)
from adaptive_ff.friction.bounds import COULOMB, STICTION
from adaptive_ff.simulation.experiment import empty_record
from controllers import check_gains

PERIOD, SLOWEST = 0.01, 0.01
FEEDBACK = check_gains(*SCENARIO.feedback.gains, 0.01)
INERTIA = SCENARIO.feedback.inertia


def trusts_along(controller, course, position=None):
    """Trust after each sample of a course, and the position at its end."""
    record = empty_record(course, len(controller.estimate_names))
    position = begin(course) if position is None else position._replace(sample=0, acting=-1)
    state, trusts = controller.state, []
    for sample in range(1, course.noise.size + 1):
        state, position = run_compiled(controller.parameters, state, course, position, sample, record)
        trusts.append(state.trust.trust)
    controller.state = state
    return np.array(trusts), position


def test_where_the_model_holds_the_friction_is_trusted_in_full():
    """From half a memory on, until when the caution of the start may hold it back."""
    controller = make("adaptive")
    trusts, _ = trusts_along(controller, lay_course(SCENARIO.modified(seed=101, duration=30.0)))
    assert np.all(trusts[round(controller.parameters.estimator.memory / PERIOD) :] == 1.0)
    assert controller.trust == 1.0


@pytest.fixture(scope="module")
def absent_and_back():
    """Trust of a controller that assumes 60 N m of Coulomb friction: on a joint without any, then on one with it."""
    controller = make("adaptive")
    controller.state.estimator.recursion.estimate[COULOMB : STICTION + 1] = 60.0
    controller.enabled = False
    reference = SCENARIO.modified(seed=101, duration=30.0).reference_velocity()
    courses = (
        course_along(
            part,
            joint=SCENARIO.joint.model_copy(update={"coulomb": size, "stiction": size, "viscous": 0.0}),
            substeps=10,
            noise=0.002,
            seed=1,
        )
        for part, size in ((reference[:12_001], 0.0), (reference[12_000:], 60.0))
    )
    absent, position = trusts_along(controller, next(courses))
    back, _ = trusts_along(controller, next(courses), position)
    return absent, back


def test_friction_that_does_not_exist_is_not_fed_for_long(absent_and_back):
    absent, _ = absent_and_back
    assert np.all(absent[200:] < 0.05)


def test_friction_that_is_there_again_is_trusted_in_full_again(absent_and_back):
    """Once the seconds without it have faded, and then no faster than trust may rise."""
    _, back = absent_and_back
    assert back[0] < 0.05
    assert back[-1] == 1.0


def test_trust_rises_by_at_most_one_in_ten_seconds(absent_and_back):
    rises = np.diff(np.concatenate(absent_and_back))
    assert np.max(rises) == pytest.approx(PERIOD / RISE, rel=1e-9)
    assert RISE == 10.0


@given(seed=st.integers(0, 10**6), factor=st.floats(-2.0, 2.0))
def test_trust_is_a_share_whatever_is_predicted(seed, factor):
    rng, state = np.random.default_rng(seed), initial_trust(FEEDBACK)
    for friction in 60.0 * np.sign(rng.standard_normal(40)):
        state = with_friction(state, state.trust, friction)
        predicted, before = factor * state.response.measured + 1e-3 * rng.standard_normal(), state.trust
        state = advance_trust(state, FEEDBACK, INERTIA, 0.0, 0.0, predicted, 0.0, 0.1, True, False, PERIOD)
        assert 0.0 <= state.trust <= min(1.0, before + PERIOD / RISE)


@pytest.mark.parametrize("there", [0.0, 0.2, 0.4])
def test_trust_is_the_share_of_the_friction_that_is_there(there):
    """Oracle: with ``y = there x`` the regression is ``there``, drawn to one by the prior: ``(s+p s^2)/(1+p s^2)``."""
    state = initial_trust(FEEDBACK)
    for k in range(3000):
        state = with_friction(state, state.trust, 60.0 * math.copysign(1.0, math.sin(0.05 * k)))
        # what the loop would be left with: the friction that is there less the share that is fed; delay zero
        response = state.response
        predicted = (there - state.trust) * advance_response(response, state.frictions[0])
        state = advance_trust(state, FEEDBACK, INERTIA, 0.0, 0.0, predicted, 0.0, 0.1, True, False, PERIOD)
    expected = (there + 0.05 * there**2) / (1.0 + 0.05 * there**2)
    assert state.trust == pytest.approx(expected, rel=1e-6, abs=1e-6)


def test_friction_that_was_in_the_integral_before_is_not_blamed():
    """It is fed as the integral gives it up: the joint notices nothing, whatever the model is worth."""
    state, blamed = initial_trust(FEEDBACK), initial_trust(FEEDBACK)
    for _ in range(100):
        state, blamed = with_friction(state, state.trust, 60.0), with_friction(blamed, blamed.trust, 60.0)
        state = advance_trust(state, FEEDBACK, INERTIA, 0.0, 60.0, 0.0, 0.0, 0.1, True, False, PERIOD)
        predicted = -blamed.trust * advance_response(blamed.response, 60.0)
        blamed = advance_trust(blamed, FEEDBACK, INERTIA, 0.0, 0.0, predicted, 0.0, 0.1, True, False, PERIOD)
    assert state.trust == 1.0
    assert blamed.trust < 0.1


@pytest.mark.parametrize(("reference", "trust"), [(0.1, 0.5), (0.0, 1.0)])
def test_error_that_is_there_lowers_trust_in_friction_that_is_there(reference, trust):
    """Oracle: an error of ``sqrt(3) 0.16 x`` leaves ``gamma = 2 - 3 gamma``; at rest an error tells nothing."""
    state = initial_trust(FEEDBACK)
    for k in range(9000):
        state = with_friction(state, state.trust, 60.0 * math.copysign(1.0, math.sin(0.05 * k)))
        whole = advance_response(state.response, state.frictions[0])
        predicted, missed = (1.0 - state.trust) * whole, 3.0 * (MISSED * whole) ** 2
        state = advance_trust(state, FEEDBACK, INERTIA, 0.0, 0.0, predicted, missed, reference, True, False, PERIOD)
    assert state.trust == pytest.approx(trust, abs=0.02)


def advance_response(response, friction):
    """Velocity that the loop makes of the friction by the next sample."""
    return response.velocity + PERIOD / INERTIA * (friction - response.commands[0])


def test_invalid_samples_and_a_joint_at_rest_leave_the_trust():
    state = initial_trust(FEEDBACK)._replace(trust=0.4, earned=0.4)
    for _ in range(100):
        state = advance_trust(state, FEEDBACK, INERTIA, 0.0, 0.0, math.nan, 0.0, 0.1, False, False, PERIOD)
    assert (state.trust, state.xx, state.yy) == (0.4, 0.0, 0.0)


def moving(speed):
    state = initial_trust(FEEDBACK)
    for _ in range(round(1.0 / PERIOD)):
        state = advance_trust(state, FEEDBACK, INERTIA, 0.0, 0.0, 0.0, 0.0, speed, True, False, PERIOD)
    return state


def test_little_learnt_and_slow_motion_hold_it_back():
    fast, slow, medium = moving(-0.1), moving(0.25 * SLOWEST), moving(0.375 * SLOWEST)
    assert caution(fast, SLOWEST, 0.0, 5.0, GRACE) == 1.0
    assert caution(slow, SLOWEST, 0.0, 5.0, GRACE) == 0.0
    assert caution(medium, SLOWEST, 0.0, 5.0, GRACE) == pytest.approx(0.5)
    assert caution(slow, SLOWEST, LEARNT * 5.0, 5.0, GRACE) == 1.0
    for later, kept in ((0.0, 1.0), (0.01, 1.0 / math.e)):  # it fades while the plan moves
        later_on = fast
        for _ in range(round(PEAK_MEMORY / PERIOD)):
            later_on = advance_trust(later_on, FEEDBACK, INERTIA, 0.0, 0.0, 0.0, 0.0, later, True, False, PERIOD)
        assert later_on.peak == pytest.approx(0.1 * kept, rel=1e-6)


@pytest.mark.parametrize(("slower", "forgotten"), [(0.9 * SLOWER, False), (1.4 * SLOWER, True)])
def test_the_largest_speed_is_forgotten_when_the_plan_has_become_far_slower(slower, forgotten):
    state, speed = moving(0.1), 0.1 / slower
    for k in range(round(2.1 * SPAN / PERIOD)):
        state = advance_trust(state, FEEDBACK, INERTIA, 0.0, 0.0, 0.0, 0.0, speed * (-1.0) ** k, True, False, PERIOD)
        assert state.peak > 0.09 * math.exp(-2.1 * SPAN / PEAK_MEMORY) or k * PERIOD > 0.8 * SPAN
    assert (state.peak == pytest.approx(speed)) == forgotten
    assert advance_trust(state, FEEDBACK, INERTIA, 0.0, 0.0, 0.0, 0.0, 0.2, True, False, PERIOD).peak == 0.2


def test_at_the_start_slow_motion_is_no_reason_yet():
    state = initial_trust(FEEDBACK)
    assert [caution(state, SLOWEST, 0.0, 5.0, share * GRACE) for share in (0.0, 0.25, 1.0, 3.0)] == [
        1.0,
        0.75,
        0.0,
        0.0,
    ]


@pytest.mark.parametrize(("share", "bound"), [(0.02, 0.0), (0.0375, 0.0), (0.06875, 0.5), (0.1, 1.0), (2.0, 1.0)])
def test_plan_that_is_slow_for_friction_and_gain_holds_it_back(share, bound):
    friction = 90.0
    state = moving(-share * friction / FEEDBACK.proportional)
    assert soft_bound(state, FEEDBACK.proportional, friction, 60.0) == pytest.approx(bound, abs=1e-9)
    assert soft_bound(state, FEEDBACK.proportional, 0.0, 60.0) == 1.0  # without friction there is nothing to wait for


def test_at_the_start_a_plan_that_is_slow_for_friction_is_no_reason_yet():
    state = initial_trust(FEEDBACK)
    assert [
        soft_bound(state, FEEDBACK.proportional, 90.0, share * SOFT_GRACE) for share in (0.0, 0.5, 1.0, 1.5, 3.0)
    ] == [
        1.0,
        1.0,
        0.5,
        0.0,
        0.0,
    ]


def test_what_was_held_back_is_there_at_once_when_the_reason_ends():
    state = with_friction(initial_trust(FEEDBACK), 0.1, 0.0)
    state = advance_trust(state, FEEDBACK, INERTIA, 0.0, 0.0, 0.0, 0.0, 0.0, True, False, PERIOD)
    assert state.trust == 1.0


@pytest.mark.parametrize(
    ("field", "value"),
    [
        ("earned", 1.5),
        ("peak", -1.0),
        ("peak", 1e9),
        ("fastest", -1.0),
        ("before", 1e9),
        ("span", -1.0),
        ("xx", -1e-9),
        ("yy", -1.0),
    ],
)
def test_trust_that_cannot_be_is_refused_when_it_is_restored(field, value):
    controller = make("adaptive", SCENARIO)
    saved = json.loads(controller.state_to_json())
    saved["state"]["trust"][field] = value
    with pytest.raises(ValueError, match="trust"):
        controller.state_from_json(json.dumps(saved))
