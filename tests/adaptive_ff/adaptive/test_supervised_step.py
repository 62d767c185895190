"""The supervised controller as a whole: torque without jumps, step by step as in one run, saved and restored."""

import json
import math

import numpy as np
import pytest
from closed_loops import SCENARIO, course_along, drive, error_of, lay_course, make, own_loop, run_plain

from adaptive_ff import load_scenario, simulate
from adaptive_ff.adaptive.controller import AdaptiveController, UnsupervisedController
from adaptive_ff.adaptive.learning.change_detection import NOTHING, UNDECIDED
from adaptive_ff.adaptive.learning.fed_model import identified_model
from adaptive_ff.adaptive.learning.unexplained import unexplained
from adaptive_ff.adaptive.step import step_model
from adaptive_ff.adaptive.watching import may_stick, unobserved_error
from adaptive_ff.friction.bounds import COULOMB, STICTION
from adaptive_ff.friction.model import WITH_GRAVITY
from adaptive_ff.friction.turning import turning_of
from adaptive_ff.scenario.library import SCENARIOS
from controllers import planned_inputs

SHORT = SCENARIO.modified(duration=8.0, change=[{"time": 5.0, "load": 40.0}])
STEP = {"next_reference": 0.21, "realised_torque": 70.0}


def controller_after(seconds):
    """A controller some seconds into the motion."""
    controller = make("adaptive")
    course = lay_course(SCENARIO.modified(duration=seconds, seed=101))
    own_loop(controller, course)
    return controller


@pytest.fixture(scope="module")
def states():
    """Saved states, early and late, frozen: so that trust and gain alone change the torque."""
    return [controller_after(seconds).state_to_json() for seconds in (0.5, 3.0, 4.0, 6.0)]


def restored(saved):
    controller = make("adaptive")
    controller.state_from_json(saved)
    controller.enabled = False
    return controller


def distrusting(controller):
    """Let the trust fall to nothing at the next step, as if the friction fed forward did not exist."""
    state = controller.state
    controller.state = state._replace(trust=state.trust._replace(xx=1e3, xy=0.0, yy=1e-6))
    return controller


def test_falling_trust_does_not_let_the_torque_jump(states):
    falls = 0
    for saved in states:
        for velocity in (0.18, 0.2, 0.23):
            trusting, other = restored(saved), distrusting(restored(saved))
            before, sign = other.trust, math.copysign(1.0, other.state.feedforward.friction)  # the way it is moving
            torques = [
                controller.step(0.2 * sign, velocity * sign, next_reference=0.21 * sign, realised_torque=70.0 * sign)
                for controller in (trusting, other)
            ]
            assert other.trust < 0.01
            falls += before > 0.5 and abs(trusting.state.feedforward.friction) > 20.0
            assert torques[1] == pytest.approx(torques[0], rel=1e-12)
    assert falls == 12, "with little friction or trust to lose nothing is tested"


def at(state, velocity):
    """A state whose last measured velocity was next to one: that is neither a leap nor a value once more."""
    return state._replace(seen=state.seen._replace(last=velocity + 1e-6, believed=velocity + 1e-6))


def test_falling_gain_does_not_let_the_torque_jump(states):
    """Louder noise closes the gates: the torque stays where it is, the integral takes over."""
    for saved in states[1:]:  # the first is held back for lack of learning
        first, second = restored(saved), restored(saved)
        for controller, variance in ((first, None), (second, 1.0)):
            state = controller.state
            # without a change of the error, the inertia of the observer, which depends on the noise, does not matter
            observer = state.observer._replace(gain=1.0, disturbance=35.0, velocity=0.2, reference=0.2)
            foreseen = state.doubt._replace(foresight=state.doubt.foresight._replace(coming=0.2))
            noise = observer.noise._replace(measured=10.0, mean=variance or 0.0, variance=variance or 0.0)
            # without noise the gates are open; a level to begin with that high closes them
            observed = state._replace(observer=observer._replace(noise=noise, squared=1e3), doubt=foreseen)
            controller.state = at(observed, 0.2)
        torques = [controller.step(0.2, 0.2, **STEP) for controller in (first, second)]
        assert second.observer_gain == 0.0
        assert abs(first.state.feedback.integral - second.state.feedback.integral) > 1.0
        assert first.observer_gain == 1.0
        assert torques[1] == pytest.approx(torques[0], rel=1e-12)


def test_observer_does_not_wait_where_the_cause_of_a_change_comes_to_light(states):
    """Something is missed there, whichever cause it has; the gates would open some samples later."""
    for cause, gain in ((UNDECIDED, 1.0), (NOTHING, 0.0)):
        controller = restored(states[-1])
        state = controller.state
        quiet = state.observer._replace(gain=0.0, squared=0.0, predicted_squared=0.0, error_squared=0.0)
        sign = math.copysign(1.0, state.feedforward.friction)
        estimator = state.estimator._replace(alarm=state.estimator.alarm._replace(cause=cause, friction=-sign))
        controller.state = state._replace(observer=quiet, estimator=estimator)
        controller.step(0.2 * sign, 0.2 * sign, next_reference=0.2 * sign, realised_torque=70.0 * sign)
        assert controller.observer_gain == gain


def test_trust_waits_for_the_cause_of_a_change_where_it_was_full(states):
    """A model that was not trusted before is no better for a change."""
    for cause, trust, moved in ((UNDECIDED, 1.0, False), (UNDECIDED, 0.7, True), (NOTHING, 1.0, True)):
        controller = restored(states[-1])
        state = controller.state
        estimator = state.estimator._replace(alarm=state.estimator.alarm._replace(cause=cause))
        controller.state = at(state._replace(estimator=estimator, trust=state.trust._replace(trust=trust)), 0.25)
        controller.step(0.2, 0.25, **STEP)
        assert (controller.state.trust.xx != state.trust.xx) == moved


@pytest.mark.parametrize(
    ("correction", "unfit", "learnt", "counts"),
    [(0.0, 1e3, 1e3, True), (0.01, 1e3, 1e3, False), (0.0, 0.0, 1e3, False), (0.0, 1e3, 1.0, False)],
)
def test_error_counts_where_the_model_does_not_fit_and_no_outer_loop_asks_for_it(
    states, correction, unfit, learnt, counts
):
    """And where as much has been learnt as the estimator remembers."""
    controller = restored(states[-1])
    state = controller.state
    state.estimator.candidates.errors[:] = unfit
    levels = state.estimator.levels._replace(learnt=learnt)
    observer = state.observer._replace(error=0.1, error_squared=0.01)
    controller.state = at(state._replace(estimator=state.estimator._replace(levels=levels), observer=observer), 0.2)
    controller.step(0.2, 0.2, correction=correction, **STEP)
    assert (controller.state.trust.missed > state.trust.missed) == counts


def test_what_the_model_leaves_is_that_of_the_candidate_in_use_where_there_are_any():
    for factors, expected in (((), 3.0), ((0.5, 1.0), 7.0)):
        controller = AdaptiveController(
            1000.0,
            1e4,
            period=0.01,
            inertia=20.0,
            stribeck_velocity=0.05,
            stribeck_factors=factors,
            presliding_factors=(),
        )
        estimator, state = controller.parameters.estimator, controller.state.estimator
        state.candidates.errors[state.candidates.chosen :] = 7.0
        levels = state.levels._replace(squared_error=3.0 / estimator.torque_scale**2)
        assert unexplained(estimator, state._replace(levels=levels)) == pytest.approx(expected)


@pytest.mark.parametrize(("fall", "share"), [(0.0, 1.0), (4.9, 1.0), (7.5, 0.5), (10.1, 0.0)])
def test_error_without_the_observer_is_taken_where_the_loop_is_what_the_prediction_takes_it_for(states, fall, share):
    """Half a gain of the observer takes half of what the prediction takes away, but not on steeply falling friction."""
    controller = restored(states[-1])
    state, block = controller.state, controller.parameters
    estimate = state.estimator.recursion.estimate
    excess = fall * block.feedback.proportional * state.estimator.candidates.stribeck_velocity
    estimate[STICTION] = estimate[COULOMB] + excess
    observer = state.observer._replace(response=state.observer.response._replace(velocity=0.03))
    state = state._replace(observer=state.observer._replace(gain=0.5))
    assert unobserved_error(block, state, observer, 0.01) == pytest.approx(0.01 + 0.5 * share * 0.02, rel=1e-9)


def test_observer_does_not_hide_from_the_tuning_of_the_lag_what_the_lag_leaves():
    """Without noise the observer is on for good; on this course tracking was 58 times worse than without it."""
    scenario = load_scenario(SCENARIOS / "ideal_1khz.toml").modified(seed=104, duration=30.0)
    settled = []
    for name in ("adaptive", "adaptive_unsupervised"):
        run = simulate(scenario, name)
        error = (run.reference - run.velocity)[run.solver_time > 20.0]
        settled.append(math.sqrt(float(np.mean(error**2))))
    assert settled[0] < 1.1 * settled[1]


@pytest.mark.parametrize(("share", "expected"), [(0.1, 1.0), (1.0, 1.0), (2.0, 0.5)])
def test_less_inertia_than_is_assumed_does_not_hold_friction_longer(states, share, expected):
    controller, inertia = restored(states[-1]), share * SCENARIO.feedback.inertia
    block, state = controller.parameters, controller.state
    model = identified_model(block, state)._replace(inertia=inertia)
    inputs = planned_inputs(0.1, 0.1, 0.1, math.nan, block.period)
    before = state.feedforward._replace(turned=0.0)
    _, _, found = step_model(block, model, state.estimator, before, inputs)
    usual = turning_of(model, SCENARIO.feedback.inertia, block.feedback.proportional, block.period).speed
    assert found.turned == pytest.approx(expected * usual, rel=1e-12)


@pytest.mark.parametrize(("share", "held"), [(0.5, True), (0.99, True), (1.01, False), (3.0, False)])
def test_observer_holds_while_friction_of_the_last_direction_is_held(states, share, held):
    """The joint may stick then; bristles that are known to bend turn friction at once, and nothing is held."""
    for presliding in (0.0, 0.01):
        controller = restored(states[-1])
        state, turned = controller.state, 0.003
        plan = -math.copysign(share * turned, state.feedforward.friction)
        candidates = state.estimator.candidates._replace(presliding=presliding)
        before = state._replace(
            feedforward=state.feedforward._replace(reference=0.5 * plan, turned=turned),
            estimator=state.estimator._replace(candidates=candidates),
        )
        assert may_stick(before, plan) == (held and presliding == 0.0)
        controller.state = at(before, 0.0)
        controller.step(plan, 0.0, next_reference=plan, realised_torque=70.0)
        moved = controller.state.observer.error_squared != before.observer.error_squared
        assert moved != (held and presliding == 0.0)


def test_loop_of_steps_and_plain_python_are_the_whole_run():
    course = lay_course(SHORT)
    fast, plain, stepped = (make("adaptive", SHORT) for _ in range(3))
    found, _ = drive(fast, course)
    expected, _ = drive(plain, course, run=run_plain)
    for series in ("torque", "velocity", "estimates"):
        wanted = getattr(expected, series)
        assert np.max(np.abs(getattr(found, series) - wanted)) <= 1e-12 * np.max(np.abs(wanted))
    without_load = lay_course(SHORT.modified(change=[]))
    whole, _ = drive(make("adaptive"), without_load)
    assert own_loop(stepped, without_load) == pytest.approx(whole.torque, rel=1e-12)


def test_by_default_offset_and_gravity_are_estimated_with_the_settings_of_the_unsupervised_controller():
    common = {"period": 0.01, "inertia": 20.0, "stribeck_velocity": 0.05}
    gains = SCENARIO.feedback.gains
    supervised = AdaptiveController(*gains, **common)
    assert supervised.estimate_names == (*WITH_GRAVITY, "stribeck_velocity", "presliding")
    unsupervised = UnsupervisedController(*gains, **common, parameters=WITH_GRAVITY)
    assert supervised.parameters.estimator.memory == unsupervised.parameters.estimator.memory
    assert np.array_equal(supervised.parameters.estimator.scale, unsupervised.parameters.estimator.scale)


def test_lost_measurements_neither_stop_it_nor_leave_a_trace_in_its_observer():
    course = lay_course(SCENARIO.modified(duration=6.0, seed=102))
    controller = make("adaptive")
    lost = dict.fromkeys(range(300, 600, 7), math.nan)
    torques = own_loop(controller, course, lost=lost)
    assert np.all(np.isfinite(torques))
    assert math.isfinite(controller.observed_torque)
    assert 0.0 <= controller.observer_gain <= 1.0
    assert 0.0 <= controller.trust <= 1.0


@pytest.mark.parametrize("seed", [101, 102])
def test_slow_motion_after_fast_is_tracked_no_worse_than_by_the_loop_alone(seed):
    """On so slow a plan PI stands still for seconds; what breaks the joint loose makes it slip."""
    fast = SCENARIO.modified(seed=seed, duration=30.0).reference_velocity()
    slow = SCENARIO.modified(seed=seed, duration=120.0, reference={"peak": 0.003}).reference_velocity()
    course = course_along(np.concatenate([fast, slow]), substeps=10, noise=0.002, seed=seed)
    errors = {name: error_of(course, drive(make(name), course)[0], 90.0) for name in ("pi", "adaptive")}
    assert errors["adaptive"] < errors["pi"] / 0.95


@pytest.mark.parametrize(
    ("path", "value"),
    [
        (("moved",), 1e9),
        (("moved",), -1.0),
        (("standing", "wound"), 1e9),
        (("standing", "left"), -1e9),
        (("doubt", "foresight", "coming"), 1e9),
        (("doubt", "foresight", "square"), -1.0),
        (("observer", "unforeseen"), -1e9),
        (("bridge", "unforeseen"), 1e9),
    ],
)
def test_a_saved_state_that_no_plan_and_no_torque_can_have_made_is_refused(path, value):
    controller = make("adaptive")
    saved = json.loads(controller.state_to_json())
    place = saved["state"]
    for name in path[:-1]:
        place = place[name]
    place[path[-1]] = value
    with pytest.raises(ValueError, match=rf"state\.{'.'.join(path)} = "):
        controller.state_from_json(json.dumps(saved))
