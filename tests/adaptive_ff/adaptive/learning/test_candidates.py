"""The Stribeck velocity is chosen from a few candidates by the torque error of each one's own estimate."""

import json
import math

import numpy as np
import pytest
from closed_loops import drive, lay_course, make

from adaptive_ff import load_scenario, simulate
from adaptive_ff.adaptive.controller import AdaptiveController
from adaptive_ff.adaptive.learning.candidate_choice import FACTORS, assess_choice
from adaptive_ff.adaptive.learning.candidate_margins import alike, margin_of, note_reversal_in_place
from adaptive_ff.adaptive.learning.candidate_moments import OUTLIER, residual_moments_in_place, robust_share
from adaptive_ff.adaptive.learning.candidates import keep_offset_in_place
from adaptive_ff.adaptive.learning.prediction import predict_torque
from adaptive_ff.comparison.registry import make_adaptive
from adaptive_ff.friction.bounds import COULOMB, OFFSET, STICTION
from adaptive_ff.scenario.library import SCENARIOS
from adaptive_ff.simulation.metrics import rms

JOINT = load_scenario(SCENARIOS / "high_stiction.toml").modified(seed=101)
TRUE = JOINT.joint.stribeck_velocity
TOLD_A_QUARTER = JOINT.modified(adaptation={"stribeck_velocity": 0.25 * TRUE}, duration=12.0)
SETTINGS = {"period": 0.01, "inertia": 20.0, "stribeck_velocity": 0.05}


def without_candidates(scenario):
    """The controller of the line-up, but that it keeps the Stribeck velocity that it is told."""
    return make_adaptive(scenario, stribeck_factors=(), presliding_factors=())


@pytest.mark.parametrize("factor", [0.25, 4.0])
def test_a_joint_that_is_told_a_wrong_velocity_finds_its_own(factor):
    missed = {"stiction": [], "coulomb": []}
    for seed in (101, 102, 103, 104):
        scenario = JOINT.modified(adaptation={"stribeck_velocity": factor * TRUE}, duration=15.0, seed=seed)
        controller = make("adaptive", scenario)
        record, _ = drive(controller, lay_course(scenario))
        found = controller.estimates
        assert found["stribeck_velocity"] == pytest.approx(TRUE)
        for name, errors in missed.items():
            errors.append(found[name] / getattr(JOINT.joint, name) - 1.0)
        chosen = record.estimates[:, -2]
        assert chosen[0] == pytest.approx(factor * TRUE)
        assert np.count_nonzero(np.diff(chosen)) <= 2
        velocity, distance = assess_choice(controller.parameters.estimator, controller.state.estimator.candidates)
        assert velocity.identifiable
        assert distance.value == 0.0
    assert rms(missed["stiction"]) < 0.05
    assert rms(missed["coulomb"]) < 0.1


def test_told_right_the_others_are_not_chosen_and_cost_no_more_than_two_percent():
    """The one in use judges how well the model fits, and so the inertia of the observer; that alone differs."""
    errors = {True: [], False: []}
    for seed in (101, 102, 103):
        scenario = JOINT.modified(seed=seed, duration=40.0)
        for tries, controller in ((True, make("adaptive", scenario)), (False, without_candidates(scenario))):
            errors[tries].append(simulate(scenario, controller).metrics.rms_error_settled)
            assert not tries or controller.estimates["stribeck_velocity"] == TRUE
            assert not tries or controller.estimates["presliding"] == 0.0
    assert np.linalg.norm(errors[True]) <= 1.02 * np.linalg.norm(errors[False])


def test_what_the_choice_changes_in_the_torque_is_what_the_model_needs():
    scenario, controller = TOLD_A_QUARTER, make("adaptive", TOLD_A_QUARTER)
    record, _ = drive(controller, lay_course(scenario))
    changes = np.flatnonzero(np.diff(record.estimates[:, -2]))
    steps = np.abs(np.diff(record.torque))
    assert changes.size > 0
    # reversals step by some two times the stiction; the choice must not add one of its own
    assert np.max(steps[changes]) < 0.5 * np.max(steps)


def test_a_restored_state_goes_on_to_the_bit():
    course = lay_course(TOLD_A_QUARTER)
    first = make("adaptive", TOLD_A_QUARTER)
    torques, saved, after = [], None, []
    velocities = course.reference[course.samples[:-1]] + course.noise
    for k, velocity in enumerate(velocities[:-1]):
        torques.append(first.step(float(course.reference[course.samples[k]]), float(velocity)))
        if k == 150:
            saved = first.state_to_json()
    second = make("adaptive", TOLD_A_QUARTER)
    second.state_from_json(saved)
    for k in range(151, velocities.size - 1):
        after.append(second.step(float(course.reference[course.samples[k]]), float(velocities[k])))
    assert after == torques[151:]
    assert second.state_to_json() == first.state_to_json()
    assert second.state.estimator.candidates.seen > 0.0


def test_moments_give_the_error_that_the_rows_give():
    rng = np.random.default_rng(101)
    rows, estimate = rng.standard_normal((50, 9)), np.array([20.0, 60.0, 90.0, 80.0, 0.02, 5.0, 40.0])
    errors = np.array([row[-1] - predict_torque(estimate, row[:-1]) for row in rows])
    correlation = np.zeros(9)
    squared = residual_moments_in_place(rows.T @ rows / 50.0, estimate, correlation)
    assert squared == pytest.approx(np.mean(errors**2), rel=1e-9)
    assert correlation == pytest.approx(errors @ rows / 50.0, rel=1e-9)


def test_a_model_begins_with_the_velocity_that_it_was_identified_with():
    model = {"inertia": 20.0, "friction_lag": 0.02, "coulomb": 60.0, "stiction": 180.0, "stribeck_velocity": 0.19}
    assert AdaptiveController(1000.0, 1e4, **SETTINGS, model=model).estimates["stribeck_velocity"] == 0.2
    assert AdaptiveController(1000.0, 1e4, **SETTINGS).estimates["stribeck_velocity"] == 0.05
    with pytest.raises(ValueError, match="stribeck_velocity"):
        AdaptiveController(1000.0, 1e4, **SETTINGS, model=model | {"stribeck_velocity": math.nan})


@pytest.mark.parametrize("factors", [(0.5, 2.0), (2.0, 1.0), (-1.0, 1.0), (1.0, math.inf), tuple(range(1, 12))])
def test_factors_that_are_no_grid_are_refused(factors):
    with pytest.raises(ValueError, match="stribeck_factors"):
        AdaptiveController(1000.0, 1e4, **SETTINGS, stribeck_factors=factors)


def test_a_state_with_a_velocity_that_no_candidate_has_is_refused():
    controller = AdaptiveController(1000.0, 1e4, **SETTINGS)
    text = controller.state_to_json()
    wrong = text.replace('"stribeck_velocity": 0.05', '"stribeck_velocity": 0.07')
    assert wrong != text
    with pytest.raises(ValueError, match="stribeck_velocity"):
        controller.state_from_json(wrong)
    with pytest.raises(ValueError, match="chosen"):
        controller.state_from_json(text.replace('"chosen": 2', '"chosen": 17'))


def test_before_anything_is_learnt_the_velocity_is_as_uncertain_as_the_grid_is_wide():
    controller = AdaptiveController(1000.0, 1e4, **SETTINGS)
    known = controller.uncertainties["stribeck_velocity"]
    assert known > 0.5 * (FACTORS[-1] - FACTORS[0]) * 0.05 / math.sqrt(3.0)
    velocity, distance = controller.diagnose().parameters[-2:]
    assert (velocity.name, velocity.unit, velocity.identifiable) == ("stribeck_velocity", "rad/s", False)
    assert (distance.name, distance.unit, distance.identifiable) == ("presliding", "rad", False)


def test_bristles_are_found_and_fed_forward():
    scenario = load_scenario(SCENARIOS / "lugre_1e4.toml").modified(seed=101, duration=30.0)
    course = lay_course(scenario)
    errors = []
    for controller in (make("adaptive", scenario), without_candidates(scenario)):
        record, _ = drive(controller, course)
        error = (course.reference - record.velocity)[-record.velocity.size // 4 :]
        errors.append(float(np.sqrt(np.mean(error**2))))
        if controller.state.estimator.candidates.errors.size > 0:
            # bristles of 1e4 N m/rad under 60 to 90 N m of friction
            assert 0.004 < controller.estimates["presliding"] < 0.012
            assert controller.estimates["coulomb"] == pytest.approx(60.0, rel=0.1)
    assert errors[0] < 0.8 * errors[1]


def test_feedforward_goes_on_smoothly_when_bristles_are_given_up():
    """An unmodelled weight looks like bristles for a while; without them friction is fed as if they had never been."""
    scenario = load_scenario(SCENARIOS / "gravity_100.toml").modified(seed=113, duration=21.0)
    run = simulate(scenario, "adaptive", uncertain=False)
    bent = run.estimates["presliding"]
    given_up = np.flatnonzero((bent[:-1] > 0.0) & (bent[1:] == 0.0)) + 1
    assert given_up.size > 0
    for sample in given_up:
        after = run.feedforward[sample : sample + 5]
        assert np.ptp(after) < 5.0, "it was 200 N m while the old bristles were taken to be bent as the new ones"


@pytest.mark.parametrize("factors", [(0.0, 1.0), (3.0, 1.0), (math.nan,), (1.0, 2.0, 3.0, 4.0, 5.0, 6.0)])
def test_distances_that_are_no_grid_are_refused(factors):
    with pytest.raises(ValueError, match="presliding_factors"):
        AdaptiveController(1000.0, 1e4, **SETTINGS, presliding_factors=factors)


def test_bristles_must_be_clearly_better_and_stay_so():
    assert margin_of(0.0, 0.0, 0.001) == 0.75
    assert margin_of(0.0, 0.01, 0.001) == margin_of(0.02, 0.01, 0.001) == margin_of(0.001, 0.01, 0.001) == 0.3
    assert margin_of(0.01, 0.0, 0.001) == 1.5
    assert margin_of(0.0, 0.001, 0.001) == margin_of(0.01, 0.001, 0.001) == 0.7
    assert margin_of(0.001, 0.0, 0.001) == 1.3
    for distance in (0.001, 0.01):
        once, back = margin_of(0.0, distance, 0.001), margin_of(distance, 0.0, 0.001)
        assert once * back < 1.0, "or the choice would toggle"


@pytest.mark.parametrize(("torque", "weight"), [(0.0, 1.0), (12.0, 1.0), (40.0, 0.1), (-40.0, 0.1)])
def test_a_row_whose_error_is_out_of_proportion_counts_for_less(torque, weight):
    candidates = AdaptiveController(100.0, 500.0, **SETTINGS).state.estimator.candidates
    candidates.row[:] = 0.0
    candidates.row[-1] = torque
    assert robust_share(candidates, 0.5, 1.0) == 0.5, "before an error is known"
    candidates.errors[candidates.chosen] = 160.0 / OUTLIER
    assert robust_share(candidates, 0.5, 1.0) == pytest.approx(0.5 * weight)


def test_reversals_are_alike_on_one_sine_and_one_that_differs_fades():
    reversals = np.zeros(2)
    assert not alike(reversals), "none has been seen"
    for acceleration in (4.0, 4.3, 3.9):
        note_reversal_in_place(reversals, acceleration)
    assert alike(reversals)
    note_reversal_in_place(reversals, 1.6 * 4.3)
    assert not alike(reversals)
    for _ in range(20):
        note_reversal_in_place(reversals, 4.0)
    assert alike(reversals)


def test_on_one_sine_a_lag_in_time_is_not_taken_for_bristles():
    """At the same acceleration each time a way and a time are the same; it settled 1.4 times worse with bristles."""
    scenario = load_scenario(SCENARIOS / "fast_sine.toml").modified(seed=101, duration=20.0)
    run = simulate(scenario, "adaptive", uncertain=False)
    assert np.all(run.estimates["presliding"] == 0.0)


def test_reversals_out_of_order_are_refused():
    controller = AdaptiveController(1000.0, 1e4, **SETTINGS)
    saved = json.loads(controller.state_to_json())
    saved["state"]["estimator"]["candidates"]["reversals"] = [2.0, 1.0]
    with pytest.raises(ValueError, match="reversals"):
        controller.state_from_json(json.dumps(saved))


def moments_of_motion(directions, shares=(0.0, 0.3, 0.8)):
    """Second moments of rows along motion in these directions, with some shares of adhesion; nothing but friction."""
    moments, count = np.zeros((9, 9)), len(directions) * len(shares)
    for direction in directions:
        for share in shares:
            row = np.zeros(9)
            row[[COULOMB + 1, STICTION + 1, OFFSET + 1]] = direction * (1.0 - share), direction * share, 1.0
            moments += np.outer(row, row) / count
    return moments


@pytest.mark.parametrize("direction", [1.0, -1.0])
@pytest.mark.parametrize(("coulomb", "stiction", "offset"), [(38.0, 48.0, -20.0), (12.0, 12.0, 5.0), (4.0, 9.0, -30.0)])
def test_an_offset_stays_where_a_candidate_knows_motion_one_way_only(direction, coulomb, stiction, offset):
    """What is known, friction and offset together in that direction, stays; friction is not negative."""
    estimate = np.array([20.0, coulomb, stiction, 80.0, 0.01, direction * offset])
    keep_offset_in_place(estimate, moments_of_motion([direction] * 5), direction)
    assert estimate[COULOMB] + direction * estimate[OFFSET] == pytest.approx(coulomb + offset)
    assert estimate[STICTION] - estimate[COULOMB] == pytest.approx(stiction - coulomb)
    assert estimate[OFFSET] == pytest.approx(direction) or estimate[COULOMB] == 0.0
    assert estimate[COULOMB] >= 0.0


def test_stiction_below_coulomb_friction_does_not_bring_the_offset_back():
    estimate = np.array([20.0, 440.0, 0.0, 80.0, 0.01, -167.0])
    keep_offset_in_place(estimate, moments_of_motion([1.0] * 5), 0.0)
    assert (estimate[COULOMB], estimate[STICTION], estimate[OFFSET]) == (273.0, 273.0, 0.0)


def test_an_offset_that_both_directions_show_is_taken():
    estimate = np.array([20.0, 38.0, 48.0, 80.0, 0.01, -20.0])
    keep_offset_in_place(estimate, moments_of_motion([1.0] * 9 + [-1.0]), 0.0)
    assert (estimate[COULOMB], estimate[OFFSET]) == (38.0, -20.0)
