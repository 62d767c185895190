"""The lag of the feedforward that the errors after reversals ask for.

Oracles: ``scipy``'s simulation of a low-pass, differences of simulated runs, weighted least squares over all samples.
"""

import functools
import itertools
import math

import numpy as np
import pytest
from closed_loops import SCENARIO, begin, drive, lay_course, make, run_compiled, run_plain
from hypothesis import given
from hypothesis import strategies as st
from plan_inputs import plan_inputs
from scipy import signal

from adaptive_ff import TorqueModel, simulate
from adaptive_ff.adaptive.controller import UnsupervisedController
from adaptive_ff.adaptive.learning.lag_tuning import (
    CLIP,
    GROWTH,
    HIDDEN_DEVIATION,
    LATE,
    LEAST_LEFT,
    LONGEST,
    MOVED,
    PRIOR_DEVIATION,
    advance_response,
    best_lag,
    drop_stale_evidence,
    empty_evidence,
    initial_timing_state,
    lag_torque,
    lateness,
    learn_timing,
    note_friction,
)
from adaptive_ff.baselines.model_based import ModelBased
from adaptive_ff.friction.bounds import FRICTION_LAG, largest_lag
from adaptive_ff.friction.feedforward import initial_feedforward_state, step_feedforward
from adaptive_ff.simulation.experiment import empty_record, lay_plain_course
from benchmarks.cases.situations import named_scenario
from controllers import check_gains, low_pass_velocity, pi_gains
from plant import Actuator, JointModel

PERIOD, SOLVER, INERTIA, LAG = 0.01, 1e-4, 20.0, 0.02
GAINS = pi_gains(INERTIA, 4.0)
LARGEST = 0.1


@pytest.mark.parametrize("lag", [0.0005, 0.004, 0.02, 1.0])
def test_lagged_torque_is_that_of_a_low_pass(lag):
    """Oracle: ``scipy.signal.lsim`` of ``1/(lag s + 1)`` and of its integral, on a fine grid."""
    torques, lagged, means = np.random.default_rng(1).uniform(-50.0, 50.0, 20), 0.0, []
    for torque in torques:
        mean, lagged = lag_torque(lag, lagged, float(torque), PERIOD)
        means.append(mean)
    system = signal.StateSpace([[-1.0 / lag, 0.0], [1.0, 0.0]], [[1.0 / lag], [0.0]], np.eye(2), np.zeros((2, 1)))
    fine = 100
    held = np.append(np.repeat(torques, fine), torques[-1])
    _, output, _ = signal.lsim(system, held, np.arange(held.size) * PERIOD / fine, interp=False)
    assert lagged == pytest.approx(output[-1, 0], rel=1e-9)
    assert np.allclose(means, np.diff(output[::fine, 1]) / PERIOD, rtol=1e-9, atol=1e-9)


@pytest.mark.parametrize("lag", [0.0, -1.0])
def test_without_a_lag_torque_is_as_it_is(lag):
    assert lag_torque(lag, 7.0, 3.0, PERIOD) == (3.0, 3.0)


def model(lag):
    return TorqueModel(INERTIA, 60.0, 60.0, 0.0, lag, 0.05, 1.0)


def reversing_course(coulomb, delay, low_pass):
    """Reversals at several speeds, without noise, on a fine grid; behind an encoder where there is a low-pass (s)."""
    flat = {"coulomb": coulomb, "stiction": coulomb, "viscous": 1e-3, "stribeck_velocity": 0.05}
    joint = JointModel(inertia=INERTIA, friction_lag=LAG, solver_period=SOLVER, **flat)
    time, steps = np.arange(80_001) * SOLVER, round(PERIOD / SOLVER)
    samples = np.arange(0, time.size, steps, dtype=np.int64)
    reference = 0.2 * np.sin(2.0 * math.pi * 0.7 * time) + 0.1 * np.sin(2.0 * math.pi * 1.3 * time)
    noise = np.zeros(samples.size - 1)
    course = lay_plain_course(joint, samples, reference, noise, Actuator(delay=delay * PERIOD))
    if low_pass == 0.0:
        return course
    observer = low_pass_velocity(1.0 / (2.0 * math.pi * low_pass), PERIOD)
    return course._replace(resolution=1e-10, observer=observer)


def measured_error(course, lag, delay):
    record, _ = drive(ModelBased(*GAINS, PERIOD, model(lag), delay=delay), course)
    return course.reference[course.samples[:-1]] - record.measured


def slopes(course, lag, delay, velocity_lag):
    """Slope of the error by the lag at each sample, from the reference alone."""
    feedback = check_gains(*GAINS, 0.01, delay)
    state, feedforward, found = initial_timing_state(feedback, lag, lag), initial_feedforward_state(), []
    reference = course.reference[course.samples]
    plans = zip(itertools.pairwise(reference.tolist()), itertools.pairwise(course.acting.tolist()), strict=True)
    for plan in plans:
        state = advance_response(state, feedback, INERTIA, velocity_lag, PERIOD)
        found.append(state.slope)
        inputs = plan_inputs(*plan[0], *plan[1])
        _, coming = step_feedforward(model(lag), feedforward, inputs, PERIOD, float(delay))
        state = note_friction(state, feedforward.friction, coming.friction, lag, PERIOD)
        feedforward = coming
    return np.array(found)


@pytest.mark.parametrize(("low_pass", "previewed"), [(0.0, False), (0.005, False), (0.0, True)])
@pytest.mark.parametrize("delay", [0, 1, 1.5])
@pytest.mark.parametrize(("coulomb", "correlation", "scale"), [(1e-6, 0.98, 0.03), (60.0, 0.97, 0.25)])
def test_slope_is_what_a_change_of_the_lag_makes_of_the_error(coulomb, correlation, scale, delay, low_pass, previewed):
    """Oracle: two simulated runs. Without friction in the joint the loop is linear, and the slope nearly exact."""
    course, step = reversing_course(coulomb, delay, low_pass), 1e-3
    if not previewed:  # the plan for when the torque acts is extrapolated
        course = course._replace(acting=np.full_like(course.acting, math.nan))
    later, now = (measured_error(course, lag, delay) for lag in (LAG + 0.5 * step, LAG - 0.5 * step))
    expected = -(later - now) / step
    found = slopes(course, LAG, delay, 0.0 if low_pass == 0.0 else low_pass + 0.5 * PERIOD)
    assert np.max(np.abs(expected)) > 1.0
    assert np.corrcoef(found, expected)[0, 1] > correlation
    assert found @ expected == pytest.approx(found @ found, rel=scale)


class Samples:
    """Slopes and errors as they are taken into account, all kept."""

    def __init__(self, seed, *, spread=0.05, best=0.03, memory=2.0):
        rng = np.random.default_rng(seed)
        size = 400
        self.memory, self.durations = memory, PERIOD * rng.uniform(0.9, 1.1, size)
        self.learnt = 1.0 + np.cumsum(self.durations)
        self.slopes = np.where(rng.uniform(size=size) < 0.3, 5.0, 0.3) * rng.standard_normal(size)
        self.lags = rng.uniform(0.015, 0.025, size)
        self.errors = self.slopes * (best - self.lags) + spread * rng.standard_t(2, size)

    def learn(self):
        """State of the module after all samples."""
        state = initial_timing_state(check_gains(*GAINS, 0.01), LAG, LAG)
        rows = zip(self.slopes, self.lags, self.errors, self.learnt, self.durations, strict=True)
        for slope, lag, error, learnt, duration in rows:
            state = state._replace(slope=float(slope), lag=float(lag))
            state = learn_timing(state, float(error), float(learnt), self.memory, float(duration))
        return state

    def fit(self, identified):
        """Lag of least squares over all samples, each weighted as the module says, and the first guess."""
        weights, targets = np.empty(self.slopes.size), np.empty(self.slopes.size)
        times = np.cumsum(self.durations)
        for k in range(self.slopes.size):
            recent = np.exp(-(times[k] - times[: k + 1]) / self.memory)
            slope, error = self.slopes[: k + 1], self.errors[: k + 1]
            importance = np.sqrt(recent) * np.abs(slope)  # errors count where the joint reverses
            level = np.sum((importance * error) ** 2) / np.sum(importance**2)
            _, left, *_ = np.linalg.lstsq((importance * slope)[:, None], importance * error, rcond=None)
            suited = left[0] / np.sum(importance**2) if left.size else 0.0
            weights[k] = 1.0 / max(suited, LEAST_LEFT * level)
            believed = min(max(error[-1], -CLIP * math.sqrt(level)), CLIP * math.sqrt(level))
            targets[k] = believed + slope[-1] * self.lags[k]
        ages = self.durations / np.minimum(LONGEST * self.memory, GROWTH * self.learnt)
        fading = np.append(np.cumsum(ages[::-1])[::-1][1:], 0.0)
        roots = np.sqrt(weights * np.exp(-fading))
        rows = np.append(roots * self.slopes, 1.0 / (PRIOR_DEVIATION * PERIOD))
        solution, *_ = np.linalg.lstsq(
            rows[:, None], np.append(roots * targets, identified / (PRIOR_DEVIATION * PERIOD)), rcond=None
        )
        return float(solution[0])


@pytest.mark.parametrize("memory", [0.1, 2.0])
@pytest.mark.parametrize("spread", [0.01, 0.5, 5.0])
@pytest.mark.parametrize("seed", [201, 202])
def test_best_lag_is_that_of_least_squares(seed, spread, memory):
    evidence = Samples(seed, spread=spread, memory=memory)
    state = evidence.learn()
    for identified in (0.0, LAG):
        found = best_lag(state, identified, LARGEST, PERIOD, hidden=False)
        assert found == pytest.approx(min(max(evidence.fit(identified), 0.0), LARGEST), rel=1e-9)


@pytest.mark.parametrize("seed", [201, 202, 203, 204])
def test_best_lag_is_found_among_errors_that_have_another_cause(seed):
    state = Samples(seed, spread=0.01).learn()
    assert best_lag(state, LAG, LARGEST, 10.0 * PERIOD, hidden=False) == pytest.approx(0.03, abs=1.5e-3)


def test_what_was_fitted_near_an_identified_lag_that_has_moved_far_is_dropped_while_young():
    near, far = LAG * (1.0 + 0.9 * MOVED) + PERIOD, LAG * (1.0 + 1.1 * MOVED) + PERIOD
    state = Samples(201, spread=0.5).learn()
    assert best_lag(state, far, LARGEST, PERIOD, hidden=False) != far
    assert drop_stale_evidence(state, near, PERIOD, True) == state
    assert drop_stale_evidence(state, far, PERIOD, False) == state
    dropped = drop_stale_evidence(state, far, PERIOD, True)
    assert dropped == state._replace(evidence=empty_evidence(far))
    assert best_lag(dropped, near, LARGEST, PERIOD, hidden=False) == near  # nothing is left


def test_evidence_is_dropped_where_the_identified_lag_has_fallen_much_too():
    state = Samples(201, spread=0.5).learn()
    long = state._replace(evidence=state.evidence._replace(since=5.0 * LAG))
    near, far = 5.0 * LAG * (1.0 - 0.9 * MOVED) - PERIOD, 5.0 * LAG * (1.0 - 1.1 * MOVED) - PERIOD
    assert drop_stale_evidence(long, near, PERIOD, True) == long
    assert drop_stale_evidence(long, far, PERIOD, True) == state._replace(evidence=empty_evidence(far))


def test_the_best_lag_is_a_possible_one():
    state = Samples(201, spread=0.5).learn()
    found = best_lag(state, LAG, LARGEST, PERIOD, hidden=False)
    assert best_lag(state, LAG, 0.5 * found, PERIOD, hidden=False) == 0.5 * found
    against = state._replace(evidence=state.evidence._replace(weighted=-1e6 * state.evidence.information))
    assert best_lag(against, LAG, LARGEST, PERIOD, hidden=False) == 0.0


@pytest.mark.parametrize("young", [True, False])
def test_without_evidence_what_comes_is_fitted_around_the_lag_identified_now(young):
    state = initial_timing_state(check_gains(*GAINS, 0.01), LAG, LAG)
    assert drop_stale_evidence(state, 1.01 * LAG, PERIOD, young) == state._replace(evidence=empty_evidence(1.01 * LAG))


def test_evidence_is_kept_at_the_very_limit_of_how_far_the_lag_may_move():
    state = Samples(201, spread=0.5).learn()
    state = state._replace(evidence=state.evidence._replace(since=0.0))
    assert drop_stale_evidence(state, 0.25, 0.25, True) == state
    assert drop_stale_evidence(state, 0.2501, 0.25, True) != state


@pytest.mark.parametrize(("squares", "fourth", "learns"), [(1.0, 1e-100, 0), (1e-100, 1.0, 0), (1e-99, 1e-99, 1)])
def test_sums_of_a_joint_at_rest_for_very_long_are_nothing_to_learn_from(squares, fourth, learns):
    state = initial_timing_state(check_gains(*GAINS, 0.01), LAG, LAG)._replace(slope=1e-30)
    known = empty_evidence(LAG)._replace(energy=1.0, squares=squares, fourth=fourth)
    after = learn_timing(state._replace(evidence=known), 0.0, 1.0, 4.0, 0.0)
    assert (after.evidence.information > 0.0) == learns
    assert after.evidence[2:] == known[2:]


def test_asking_for_the_best_lag_drops_nothing():
    state = Samples(201, spread=0.5).learn()
    assert (
        best_lag(state, LARGEST, LARGEST, PERIOD, hidden=False)
        == best_lag(state, LARGEST, LARGEST, PERIOD, hidden=False)
        != LARGEST
    )


@given(identified=st.floats(0.0, LARGEST), period=st.floats(1e-4, 0.1))
def test_without_evidence_the_best_lag_is_the_identified_one_bit_for_bit(identified, period):
    state = initial_timing_state(check_gains(*GAINS, 0.01), LAG, LAG)
    assert best_lag(state, identified, LARGEST, period, hidden=False) == identified


@given(
    samples=st.lists(
        st.tuples(st.floats(-1e30, 1e30), st.floats(-1e12, 1e12), st.floats(1e-6, 1e3)), min_size=1, max_size=30
    )
)
def test_best_lag_is_possible_whatever_slopes_and_errors(samples):
    state = initial_timing_state(check_gains(*GAINS, 0.01), LAG, LAG)
    for slope, error, duration in samples:
        state = learn_timing(state._replace(slope=slope), error, 1.0, 4.0, duration)
        assert 0.0 <= best_lag(state, LAG, LARGEST, PERIOD, hidden=False) <= LARGEST


def test_errors_of_exactly_zero_for_very_long_leave_the_lag_possible():
    """Of a joint that exists in a test bench only: the level of the error fades until it is no longer a number."""
    state = initial_timing_state(check_gains(*GAINS, 0.01), LAG, LAG)._replace(slope=3.0)
    for k in range(4000):
        state = learn_timing(state, 1e-17 if k == 0 else 0.0, 1.0 + k, 4.0, 1.0)
        state = drop_stale_evidence(state, 1.2 * LAG, PERIOD, True)
        assert best_lag(state, 1.2 * LAG, LARGEST, PERIOD, hidden=False) == pytest.approx(LAG, rel=0.2001)
    assert np.all(np.isfinite(state.evidence))


def test_a_slope_that_grows_without_bounds_starts_anew():
    """Gains for a joint of 20 kg m^2, assumed to be one of 0.5: the loop that they make with it is not stable."""
    feedback = check_gains(*pi_gains(20.0, 10.0), 0.01)
    state, grown, anew = initial_timing_state(feedback, LAG, LAG), 0.0, 0
    for k in range(3000):
        before = state.slope
        state = advance_response(state, feedback, 0.5, 0.0, PERIOD)
        assert all(map(math.isfinite, (state.velocity, state.integral, state.slope, *state.commands)))
        grown, anew = max(grown, abs(state.slope)), anew + (state.slope == 0.0 != before)
        state = learn_timing(state, 0.01, 1.0 + k * PERIOD, 4.0, PERIOD)
        assert 0.0 <= best_lag(state, LAG, LARGEST, PERIOD, hidden=False) <= LARGEST
        state = note_friction(state, 0.0, 60.0 if k % 50 == 0 else 0.0, LAG, PERIOD)
    assert grown > 1e20
    assert anew > 1


@pytest.mark.parametrize("size", [1e3, 1e300])
def test_wild_measurements_leave_the_lag_possible_and_the_evidence_finite(size):
    course, controller = lay_course(SCENARIO.modified(duration=30.0)), make("adaptive")
    noise = course.noise.copy()
    noise[700::97] = size * np.resize([1.0, -1.0], noise[700::97].size)
    record, _ = drive(controller, course._replace(noise=noise))
    timing = controller.state.timing
    assert np.all(np.isfinite(timing.evidence))
    assert np.any(timing.evidence)
    assert 0.5 * LAG < timing.lag < 2.0 * LAG
    assert np.all(np.isfinite(record.torque))


@pytest.mark.parametrize("inertia", [0.5, 2.0])
def test_inertia_told_far_too_small_leaves_the_lag_possible(inertia):
    """In a closed loop, with gains for the joint as it is: ten times too small and the response is not stable."""
    controller = UnsupervisedController(*pi_gains(20.0, 10.0), PERIOD, inertia=inertia, stribeck_velocity=0.05)
    largest = largest_lag(inertia / controller.parameters.feedback.proportional)
    course, seen = lay_course(SCENARIO.modified(duration=30.0)), []
    record, _ = drive(controller, course)
    timing = controller.state.timing
    seen = [timing.velocity, timing.integral, timing.slope, timing.lag, *timing.commands, *timing.evidence]
    assert np.all(np.isfinite(seen))
    assert np.any(timing.evidence)
    assert 0.0 <= timing.lag <= largest
    assert np.all(np.isfinite(record.torque))


@functools.cache
def tuned(seed, name):
    scenario, controller = SCENARIO.modified(seed=seed), make(name)
    return controller, simulate(scenario, controller), simulate(scenario, "oracle")


@pytest.mark.parametrize("name", ["adaptive_unsupervised", "adaptive"])
@pytest.mark.parametrize("seed", [201, 202])
def test_at_100_hz_a_later_feedforward_than_the_true_lag_does_better_than_the_truth(seed, name):
    controller, run, oracle = tuned(seed, name)
    truth = SCENARIO.joint.friction_lag
    assert 1e-3 < controller.state.timing.lag - truth < 5e-3
    assert run.final_estimates["friction_lag"] == controller.state.estimator.recursion.estimate[FRICTION_LAG]
    assert run.final_estimates["friction_lag"] == pytest.approx(truth, abs=2e-3)
    assert run.metrics.rms_error_settled < oracle.metrics.rms_error_settled


def test_tuned_lag_is_the_one_fed_forward():
    """Frozen, the controller is the loop with a given model of that lag, and no other."""
    controller, _, _ = tuned(201, "adaptive_unsupervised")
    frozen = make("adaptive_unsupervised")
    frozen.state_from_json(controller.state_to_json())
    frozen.reset()
    frozen.enabled = False
    estimates, timing = controller.state.estimator, controller.state.timing
    frozen.state = frozen.state._replace(
        estimator=estimates, timing=initial_timing_state(controller.parameters.feedback, timing.lag, timing.lag)
    )
    assumed = TorqueModel(*estimates.recursion.estimate[:FRICTION_LAG], timing.lag, 0.05, 1.0)
    course = lay_course(SCENARIO.modified(duration=10.0, seed=203))
    found, _ = drive(frozen, course)
    expected, _ = drive(ModelBased(*SCENARIO.feedback.gains, PERIOD, assumed), course)
    assert frozen.state.timing.lag == timing.lag
    assert found.feedforward == pytest.approx(expected.feedforward, rel=1e-9, abs=1e-9)


def test_the_feedforward_is_late_until_the_errors_have_told_of_the_lag():
    guessed = initial_timing_state(check_gains(*GAINS, 0.01), LAG, LAG)
    known = initial_timing_state(check_gains(*GAINS, 0.01), LAG, 0.05 * LAG)
    assert 0.8 * LATE < lateness(guessed, LAG) < LATE
    assert lateness(known, LAG) < 0.1 * LATE
    assert lateness(guessed, 1e-4) < 1e-4
    controller = make("adaptive")
    simulate(SCENARIO.modified(seed=201, duration=20.0), controller)
    timing = controller.state.timing
    assert timing.seen > 100.0 * guessed.seen
    assert lateness(timing, timing.lag) < 0.1 * LATE


@pytest.mark.parametrize("seed", [201, 202])
def test_lag_that_is_not_tuned_is_the_identified_one_bit_for_bit(seed):
    adaptation = SCENARIO.adaptation
    controller = UnsupervisedController(
        *SCENARIO.feedback.gains,
        PERIOD,
        inertia=SCENARIO.feedback.inertia,
        stribeck_velocity=adaptation.stribeck_velocity,
        tunes_lag=False,
    )
    simulate(SCENARIO.modified(seed=seed, duration=20.0), controller)
    assert controller.state.timing.lag == controller.state.estimator.recursion.estimate[FRICTION_LAG]
    assert controller.state.timing.lag != controller.parameters.estimator.first[FRICTION_LAG]
    assert not np.any(controller.state.timing.evidence[:-1])


def test_switched_off_it_keeps_its_lag_and_evidence():
    controller, course = make("adaptive"), lay_course(SCENARIO.modified(duration=20.0, seed=204))
    drive(controller, course)
    timing = controller.state.timing
    controller.enabled = False
    drive(controller, course)
    assert controller.state.timing.lag == timing.lag
    assert controller.state.timing.evidence == timing.evidence
    controller.enabled = True
    drive(controller, course)
    assert controller.state.timing.lag != timing.lag


def test_at_rest_nothing_moves_the_lag():
    """In a minute of standstill and noise after motion there is no slope, and so no evidence."""
    controller = make("adaptive")
    course = lay_course(SCENARIO.modified(duration=90.0, seed=206, reference={"pause": [20.0, 89.0]}))
    state, position, lags = controller.state, begin(course), []
    record = empty_record(course, len(controller.estimate_names))
    for stop in (2500, 8800):
        state, position = run_compiled(controller.parameters, state, course, position, stop, record)
        lags.append(state.timing.lag)
    assert abs(lags[0] / LAG - 1.0) > 0.01
    assert lags[1] == pytest.approx(lags[0], rel=1e-3)


def test_plain_python_equals_compiled_while_the_lag_is_tuned():
    course = lay_course(SCENARIO.modified(duration=15.0, seed=206))
    plain, fast = make("adaptive"), make("adaptive")
    drive(plain, course, run=run_plain)
    drive(fast, course)
    assert fast.state.timing.lag != fast.state.estimator.recursion.estimate[FRICTION_LAG]
    assert fast.state.timing.lag == pytest.approx(plain.state.timing.lag, rel=1e-12)
    assert fast.state.timing.evidence == pytest.approx(plain.state.timing.evidence, rel=1e-9)


@pytest.mark.parametrize("seed", [101, 102])
def test_evidence_is_that_of_fading_sums(seed):
    """Oracle: sums over all samples, each with the weight that it has left."""
    rng, memory, duration, lag = np.random.default_rng(seed), 0.7, 0.01, 0.03
    slopes, errors = rng.standard_normal(300), 0.2 + 0.5 * rng.standard_normal(300)
    state = initial_timing_state(check_gains(*GAINS, 0.01), lag, lag)
    learnt = memory
    sums, fitted = np.zeros(4), np.zeros(2)
    for slope, error in zip(slopes, errors, strict=True):
        learnt += duration
        state = learn_timing(state._replace(slope=float(slope)), float(error), learnt, memory, duration)
        sums *= math.exp(-duration / memory)
        sums += slope**2, (slope * error) ** 2, slope**3 * error, slope**4
        energy, squares, cross, fourth = sums
        limit, left = CLIP * math.sqrt(squares / energy), squares - cross**2 / fourth
        weight = energy / max(left, LEAST_LEFT * squares)
        fitted *= math.exp(-duration / min(LONGEST * memory, GROWTH * learnt))
        fitted += weight * slope**2, weight * slope * (np.clip(error, -limit, limit) + slope * lag)
        assert tuple(state.evidence)[:6] == pytest.approx((*fitted, *sums), rel=1e-9)
    assert state.evidence.since == lag


@pytest.mark.parametrize(("hidden", "deviation"), [(False, PRIOR_DEVIATION * 0.001), (True, HIDDEN_DEVIATION)])
def test_a_lag_that_noise_hides_weighs_less_against_what_the_errors_say(hidden, deviation):
    """Oracle: the mean of two independent numbers, each weighted by the inverse of its variance."""
    state = initial_timing_state(check_gains(*GAINS, 0.01), LAG, 0.1)
    evidence = empty_evidence(LAG)._replace(information=1.0 / 0.004**2, weighted=0.03 / 0.004**2, energy=1.0)
    expected = np.average([LAG, 0.03], weights=[1.0 / deviation**2, 1.0 / 0.004**2])
    found = best_lag(state._replace(evidence=evidence), LAG, LARGEST, 0.001, hidden=hidden)
    assert found == pytest.approx(expected, rel=1e-12)


@pytest.mark.parametrize("seed", [101, 102])
def test_in_a_fast_loop_friction_turns_in_time_wherever_the_identified_lag_has_wandered(seed):
    """The joint has no lag. In four minutes the error had grown from 0.6 to 0.8 of PI's, that of ``fixed`` is 0.55."""
    scenario = named_scenario("data_sheet", seed)
    late = slice(-60_000, None)
    errors = {}
    for name in ("pi", "fixed", "adaptive"):
        run = simulate(scenario, name, uncertain=False)
        errors[name] = np.sqrt(np.mean(np.square((run.reference - run.velocity)[late])))
    assert errors["adaptive"] < 0.6 * errors["pi"]
    assert errors["adaptive"] < errors["fixed"]
