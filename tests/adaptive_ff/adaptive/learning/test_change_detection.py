"""Sudden changes of friction: what is noticed, what is forgotten, and how the loop fares.

Oracles: covariances of numpy for the release, sums written out for the means over the window, and the PI loop.
"""

import functools
import math

import numpy as np
import pytest
from closed_loops import (
    SCENARIO,
    begin,
    course_along,
    drive,
    error_of,
    lay_course,
    make,
    own_loop,
    run_plain,
)
from hypothesis import given
from hypothesis import strategies as st

from adaptive_ff import simulate
from adaptive_ff.adaptive.learning import forgetting
from adaptive_ff.adaptive.learning.change_detection import (
    EITHER,
    FRICTION,
    JUMP,
    LEAST_ERROR,
    LOAD,
    NO_ALARM,
    NOTHING,
    RENEWED,
    SETTLING,
    TURNED_FOR,
    UNDECIDED,
    UNDONE,
    Alarm,
    Surprise,
    attribute_change,
    explained_by_friction,
    is_decided,
    load_is_undone,
    note_surprise,
    shows_cause,
    since_turned,
    undecided_factor,
)
from adaptive_ff.adaptive.learning.forgetting import (
    LARGEST_FACTOR,
    LEAST_FACTOR,
    error_to_learn,
    explain_in_place,
    follow_friction_in_place,
    forget_friction_in_place,
    forget_offset_in_place,
    leave_to_loads_in_place,
    release_in_place,
)
from adaptive_ff.adaptive.learning.prediction import add_friction
from adaptive_ff.friction.bounds import COULOMB, OFFSET, STICTION, VISCOUS
from adaptive_ff.friction.model import PER_DIRECTION
from adaptive_ff.simulation.experiment import empty_record

JOINT, CHANGE = SCENARIO.joint, 20.0
LEARNER = "adaptive_unsupervised"
"""The identification alone, without an offset: it forgets as soon as it notices."""
SEEDS, SCALES = (201, 202, 203, 204), (0.6, 1.5)
changes = pytest.mark.parametrize("scale", SCALES)
seeds = pytest.mark.parametrize("seed", SEEDS)


def random_information(seed, size=5):
    rng = np.random.default_rng(seed)
    rows = rng.standard_normal((2 * size, size)) * 10.0 ** rng.uniform(-1.0, 1.0, size)
    return rows.T @ rows, rng.standard_normal(size)


def released(information, direction, known):
    result = information.copy()
    release_in_place(result, direction, known, np.empty(direction.size))
    return result


@given(seed=st.integers(0, 10**6), size=st.integers(2, 8), share=st.floats(1e-3, 0.999))
def test_release_is_a_variance_added_along_the_direction(seed, size, share):
    """Oracle: ``(M^-1 + q d d')^-1`` has ``d'M d / (1 + q d'M d)`` left along ``d``."""
    information, direction = random_information(seed, size)
    total = direction @ information @ direction
    variance = (1.0 / share - 1.0) / total
    covariance = np.linalg.inv(information) + variance * np.outer(direction, direction)
    result = released(information, direction, share * total)
    assert direction @ result @ direction == pytest.approx(share * total, rel=1e-9)
    assert np.allclose(result @ covariance, np.eye(size), rtol=0.0, atol=1e-7)
    assert np.allclose(result, result.T, rtol=1e-13, atol=1e-13 * np.max(information))
    assert np.linalg.eigvalsh(result)[0] > 0.0


@given(seed=st.integers(0, 10**6), size=st.integers(2, 8), share=st.floats(1e-6, 0.9))
def test_release_leaves_what_is_known_of_the_rest(seed, size, share):
    """The Schur complement of the direction: information about the others where nothing is known along it."""
    information, direction = random_information(seed, size)
    rest = np.linalg.qr(np.column_stack([direction, np.eye(size)]))[0][:, 1:]

    def of_the_rest(matrix):
        cross = rest.T @ matrix @ direction
        return rest.T @ matrix @ rest - np.outer(cross, cross) / (direction @ matrix @ direction)

    result = released(information, direction, share * (direction @ information @ direction))
    expected = of_the_rest(information)
    assert np.allclose(of_the_rest(result), expected, rtol=0.0, atol=1e-9 * np.max(information))
    total = direction @ information @ direction
    cross = rest.T @ information @ direction
    taken = (1.0 - share) * np.outer(cross, cross) / total
    assert np.allclose(rest.T @ (information - result) @ rest, taken, rtol=0.0, atol=1e-9 * np.max(information))
    assert np.max(taken) > 0.0


@seeds
def test_little_is_known_already_and_nothing_is_released(seed):
    information, direction = random_information(seed)
    total = direction @ information @ direction
    assert np.array_equal(released(information, direction, 1.001 * total), information)
    assert np.array_equal(released(information, np.zeros(5), 1e-9), information)
    assert np.array_equal(released(information, np.zeros(5), 0.0), information)
    assert not np.array_equal(released(information, direction, 0.999 * total), information)


WHOLE_ESTIMATE = np.array([20.0, 60.0, 90.0, 80.0, 0.02, 15.0, 4.0, 7.0])
WHOLE_SCALE = np.array([18.0, 70.0, 50.0, 300.0, 0.03, 6.0, 5.0, 25.0])


@pytest.mark.parametrize("size", [5, 6, 8])
def test_what_is_forgotten_of_friction_is_a_common_factor(size):
    """Inertia, lag, offset and the ratios of the friction parameters are known as well as before."""
    information, _ = random_information(size, size)
    estimate, scale = WHOLE_ESTIMATE[:size], WHOLE_SCALE[:size]
    mean, share = 0.3, 0.02
    factor = estimate / scale
    factor[[i for i in range(size) if i not in (COULOMB, STICTION, VISCOUS) and i <= OFFSET]] = 0.0
    result = information.copy()
    forget_friction_in_place(result, estimate, scale, mean, share, np.empty((size, size)))
    assert np.allclose(result, released(information, factor, share * mean), rtol=1e-12)
    assert factor @ result @ factor <= share * mean * (1.0 + 1e-9)
    kept = [i for i in (0, 4, OFFSET) if i < size]
    assert np.allclose(np.linalg.inv(result)[kept], np.linalg.inv(information)[kept], rtol=1e-6, atol=1e-12), (
        "what is uncertain of inertia, lag and offset"
    )


@pytest.mark.parametrize("size", [6, 8])
def test_what_is_forgotten_of_a_load_is_the_offset_alone(size):
    information, _ = random_information(size, size)
    scale, unit, share = WHOLE_SCALE[:size], 62.0, 0.02
    result = information.copy()
    forget_offset_in_place(result, scale, unit, share, np.empty((size, size)))
    known = share * (scale[OFFSET] / unit) ** 2
    assert np.allclose(result, released(information, np.eye(size)[OFFSET], known), rtol=1e-12)
    assert result[OFFSET, OFFSET] == pytest.approx(known, rel=1e-6)
    others = [i for i in range(size) if i != OFFSET]
    found, before = np.linalg.inv(result), np.linalg.inv(information)
    assert np.allclose(found[others], before[others], rtol=1e-6, atol=1e-12), "what is uncertain of the rest"


@pytest.mark.parametrize(("size", "loads"), [(5, 0), (7, 2)])
def test_without_an_offset_there_is_none_to_forget(size, loads):
    """With gravity the sixth parameter is the size of a known load."""
    information, _ = random_information(size, size)
    result = information.copy()
    forget_offset_in_place(result, WHOLE_SCALE[:size], 62.0, 0.02, np.empty((size, size)), loads)
    assert np.array_equal(result, information)


WINDOW, LONGEST = 0.1, 5.0
PUSHED, BACK, GONE = Surprise(0.2, 0.4, 0.3), Surprise(-0.2, 0.4, 0.3), Surprise(0.2, 0.4, -0.28)


def attributed(*phases, alarm=NO_ALARM):
    """Alarm after phases of so many samples of 10 ms, each of one surprise and one friction."""
    for count, noticed, surprise, friction in phases:
        for _ in range(count):
            alarm = attribute_change(alarm, noticed, surprise, friction, WINDOW, LONGEST, 0.01)
    return alarm


def test_a_change_waits_undecided_while_the_joint_moves_one_way():
    assert attributed((100, False, PUSHED, 0.8)) == NO_ALARM
    assert attributed((1, True, PUSHED, 0.8)) == Alarm(UNDECIDED, 0.2, 0.8, 0.0, 0.0, 0.0, False)
    waiting = attributed((1, True, PUSHED, 0.8), (300, True, PUSHED, 0.8))
    assert waiting.cause == UNDECIDED
    assert waiting.turned == 0.0
    assert waiting.age == pytest.approx(3.0)


@pytest.mark.parametrize(("after", "cause"), [(BACK, LOAD), (PUSHED, FRICTION)])
def test_moved_the_other_way_the_sign_of_the_error_tells_a_load_from_friction(after, cause):
    """A load keeps its sign and so changes that of error times friction; friction turns with the motion."""
    both_ways = ((1, True, PUSHED, 0.8), (14, False, after, -0.6))
    assert attributed(*both_ways).cause == UNDECIDED
    assert attributed(*both_ways, (2, False, after, -0.6)).cause == cause


@pytest.mark.parametrize(
    ("product", "factor"),
    [(0.0, 1.0), (0.6, 1.3), (-0.4, 0.8), (2.9, 2.45), (3.1, 1.0), (-0.69, 0.655), (-0.71, 1.0), (-3.0, 1.0)],
)
def test_half_of_an_undecided_change_is_fed_as_friction_where_it_may_be_that(product, factor):
    alarm, window = NO_ALARM._replace(cause=UNDECIDED, product=product * 4.0, age=0.2), 0.1
    means = Surprise(0.0, 4.0, 0.0)
    assert undecided_factor(alarm, means, window) == pytest.approx(factor, rel=1e-12)
    assert undecided_factor(alarm, Surprise(1.0, 0.0, 0.0), window) == 1.0
    assert undecided_factor(alarm._replace(age=0.9 * TURNED_FOR * window), means, window) == 1.0
    for cause in (NOTHING, FRICTION, LOAD, EITHER):
        assert undecided_factor(alarm._replace(cause=cause), means, window) == 1.0


def test_only_the_other_way_shows_the_cause_of_a_change_that_is_not_known():
    for cause in (UNDECIDED, EITHER):
        alarm = NO_ALARM._replace(cause=cause, friction=-0.5)
        assert [shows_cause(alarm, plan) for plan in (0.1, 0.0, -0.1)] == [True, False, False]
        assert shows_cause(alarm._replace(friction=0.5), -0.1)
    for cause in (NOTHING, FRICTION, LOAD):
        assert not shows_cause(NO_ALARM._replace(cause=cause, friction=-0.5), 0.1)


def test_motion_the_other_way_that_hardly_slides_decides_nothing():
    assert attributed((1, True, PUSHED, 0.8), (400, False, BACK, -0.3)).cause == UNDECIDED


def test_what_cannot_be_decided_within_the_longest_wait_may_be_either():
    assert attributed((1, True, PUSHED, 0.8), (499, False, PUSHED, 0.8)).cause == UNDECIDED
    assert attributed((1, True, PUSHED, 0.8), (502, False, PUSHED, 0.8)).cause == EITHER


def test_what_may_be_either_waits_for_the_other_way_and_for_the_settling_after_it():
    """Until the joint turns no other change is looked for; once it has turned, moving back does not stop the clock."""
    either = attributed((1, True, PUSHED, 0.8), (502, False, PUSHED, 0.8))
    assert attributed((3000, True, PUSHED, 0.8), alarm=either) == either._replace(age=0.0)
    turned = attributed((5, True, PUSHED, -0.8), alarm=either)
    assert turned.cause == EITHER
    assert turned.turned == pytest.approx(0.05)
    settling = round(SETTLING * WINDOW / 0.01)
    assert attributed((settling - 8, True, PUSHED, 0.8), alarm=turned).cause == EITHER
    assert attributed((settling + 2, False, PUSHED, 0.8), alarm=turned) == NO_ALARM


@pytest.mark.parametrize("begun", [PUSHED, BACK])
@pytest.mark.parametrize(("factor", "cause"), [(0.98, FRICTION), (1.02, LOAD)])
def test_the_sign_of_an_error_counts_anew_once_it_is_large_enough(factor, cause, begun):
    """Moving on, the product of error and friction turns its sign: a large one is another state, a small one noise."""
    renewed = begun._replace(product=-factor * RENEWED * begun.product)
    assert attributed((1, True, begun, 0.8), (5, True, renewed, 0.8), (20, False, begun, -0.6)).cause == cause
    less = begun._replace(product=factor * RENEWED * begun.product)
    lessened = attributed((1, True, begun, 0.8), (1, True, less, 0.8))
    assert lessened.product == (begun.product if factor < 1.0 else less.product)


def test_after_a_decision_none_other_is_made_for_a_while():
    decided = attributed((1, True, PUSHED, 0.8), (20, False, BACK, -0.6))
    assert decided.cause == LOAD
    assert attributed((190, True, PUSHED, 0.8), alarm=decided).cause == LOAD
    assert attributed((202, False, PUSHED, 0.8), alarm=decided) == NO_ALARM._replace(load=0.3)


@pytest.mark.parametrize("pause", [0, 300])
def test_the_end_of_a_push_is_the_push_undone_at_once(pause):
    pushed = attributed((1, True, PUSHED, 0.8), (20, False, BACK, -0.6), (pause, False, Surprise(0.0, 0.4, 0.0), -0.6))
    assert pushed.load == 0.3
    found = attributed((1, True, GONE, -0.6), (20, True, GONE, -0.6), alarm=pushed)
    assert (found.cause, found.turned, found.load, found.undone) == (LOAD, 0.0, -0.3, True)
    other = attributed((1, True, PUSHED, -0.6), (20, True, PUSHED, -0.6), alarm=pushed)
    assert other.load == 0.3


def test_a_load_is_undone_once():
    """Friction that an offset stands for turns at every reversal, like a load that ends, again and again."""
    pushed = attributed((1, True, PUSHED, 0.8), (20, False, BACK, -0.6))
    undone = attributed(
        (1, True, GONE, -0.6), (20, True, GONE, -0.6), (300, False, Surprise(0.0, 0.4, 0.0), -0.6), alarm=pushed
    )
    assert undone == NO_ALARM._replace(load=-0.3, undone=True)
    again = Surprise(0.2, 0.4, 0.3)
    assert attributed((1, True, again, 0.6), (20, True, again, 0.6), alarm=undone).cause == UNDECIDED


def test_friction_follows_what_has_been_since_the_turn():
    """A push that ended just before it leaves a short mean that has not faded, and changes no friction."""
    times, window = np.arange(1, 40) * 0.01, 0.1
    mean = Surprise(-1.5, 1.5, 1.2)
    for time in times:
        mean = note_surprise(mean, 1.2, 0.25, 0.01, window)
        assert since_turned(mean.product, -1.5, time / window) == pytest.approx(0.3, abs=0.1)
    assert since_turned(math.exp(-1.5) * -1.6, -1.6, 1.5) == pytest.approx(0.0, abs=1e-15)


def test_a_push_that_ends_before_it_is_attributed_is_no_change_of_friction():
    """Its end turns the sign of the error while the joint moves on; what counts is the sign right before it turns."""
    ended = Surprise(-0.2, 0.4, -0.3)
    after = Surprise(0.2, 0.4, -0.3)
    assert attributed((1, True, PUSHED, 0.8), (30, True, ended, 0.8), (20, True, after, -0.6)).cause == LOAD


def test_a_push_that_ends_while_it_settles_is_undone_too():
    """Nothing is learnt from its end: a change waits that goes against the load, and no other one."""
    pushed = attributed((1, True, PUSHED, 0.8), (20, False, BACK, -0.6))
    assert (pushed.cause, pushed.load) == (LOAD, 0.3)
    assert attributed((1, True, PUSHED._replace(error=-0.02), -0.6), alarm=pushed).cause == LOAD
    ending = attributed((1, True, PUSHED._replace(error=-0.1), -0.6), alarm=pushed)
    assert ending == Alarm(UNDECIDED, 0.2, -0.6, 0.0, 0.0, 0.3, False)
    undone = attributed((20, True, GONE, -0.6), alarm=ending)
    assert (undone.cause, undone.load, undone.undone) == (LOAD, -0.3, True)


def test_short_turns_do_not_add_up():
    short = ((10, False, BACK, -0.6), (5, False, PUSHED, 0.8)) * 5
    assert attributed((1, True, PUSHED, 0.8), *short).cause == UNDECIDED


def test_what_a_change_is_attributed_to_is_followed_at_once():
    estimate = np.array([20.0, 60.0, 90.0, 80.0, 0.02, 15.0, 4.0, 7.0, 33.0])
    follow_friction_in_place(estimate, PUSHED.product, PUSHED.friction_squared, 1)
    assert estimate == pytest.approx([20.0, 90.0, 135.0, 120.0, 0.02, 15.0, 6.0, 10.5, 33.0])
    correction, gradient = np.array([0.1, 0.2, -0.1, 0.3, 0.05, 0.02, 0.01, 0.01, 0.03]), np.linspace(0.2, 1.0, 9)
    leave_to_loads_in_place(correction, 1)
    assert np.flatnonzero(correction).tolist() == [OFFSET, 8]
    explain_in_place(correction, gradient, 0.3)
    assert correction @ gradient == pytest.approx(0.3, rel=1e-12)
    assert correction[OFFSET] / correction[8] == pytest.approx(0.02 / 0.03, rel=1e-12)


def test_first_errors_of_a_change_are_cut_off_and_those_of_a_load_are_followed_whole():
    load = Alarm(LOAD, 0.2, 0.8, 0.0, 0.0, 1.3, False)
    assert error_to_learn(NO_ALARM, False, PUSHED, -0.9, 0.01) == pytest.approx(-0.5, rel=1e-12)
    assert error_to_learn(NO_ALARM, False, PUSHED, 0.4, 0.01) == 0.4
    assert error_to_learn(NO_ALARM, False, PUSHED, -0.9, math.inf) == -0.9
    assert error_to_learn(load, True, PUSHED, 0.2, 0.01) == PUSHED.error
    assert error_to_learn(load, False, PUSHED, 0.9, 0.01) == 0.9


@pytest.mark.parametrize(
    ("product", "squared", "factor"),
    [(-0.9, 1.0, LEAST_FACTOR), (-0.7, 1.0, 0.3), (3.9, 1.0, 4.9), (9.0, 1.0, LARGEST_FACTOR), (9.0, 0.0, 1.0)],
)
def test_friction_changes_at_once_by_no_more_than_is_plausible(product, squared, factor):
    estimate = np.array([20.0, 60.0, 90.0, 80.0, 0.02, 15.0])
    follow_friction_in_place(estimate, product, squared, 0)
    assert estimate == pytest.approx([20.0, 60.0 * factor, 90.0 * factor, 80.0 * factor, 0.02, 15.0])


@pytest.mark.parametrize("load", [0.4, -0.4])
@pytest.mark.parametrize(("share", "age", "undone"), [(0.9, 1.1, True), (0.9, 0.9, False), (1.1, 1.1, False)])
@pytest.mark.parametrize("side", [1.0, -1.0])
def test_a_load_is_undone_by_about_its_reverse_for_long_enough(load, share, age, undone, side):
    error = -load * (1.0 + side * share * UNDONE)
    alarm = Alarm(UNDECIDED, 0.2, 0.8, age * TURNED_FOR * WINDOW, 0.0, load, False)
    assert load_is_undone(alarm, Surprise(0.2, 0.4, error), WINDOW) is undone


def test_a_change_has_just_been_decided_in_the_sample_that_decides_it():
    fresh = {cause: is_decided(Alarm(cause, 0.2, 0.8, 0.0, 0.0, 0.0, False)) for cause in (NOTHING, UNDECIDED, EITHER)}
    assert not any(fresh.values())
    assert is_decided(Alarm(LOAD, 0.2, 0.8, 0.0, 0.0, 0.3, False))
    assert is_decided(Alarm(FRICTION, 0.2, 0.8, 0.0, 0.0, 0.3, False))
    assert not is_decided(Alarm(LOAD, 0.2, 0.8, 0.01, 0.0, 0.3, False))
    assert not is_decided(Alarm(FRICTION, 0.2, 0.8, 0.01, 0.0, 0.3, False))


def test_what_is_decided_no_longer_minds_which_way_the_joint_moves():
    decided = attributed((1, True, PUSHED, 0.8), (20, False, BACK, -0.6))
    later = attributed((30, False, BACK, -0.6), alarm=decided)
    assert later == decided._replace(age=later.age)
    assert later.age == pytest.approx(decided.age + 0.3)


def test_friction_is_predicted_without_inertia_lag_and_offset():
    estimate = np.array([20.0, 60.0, 90.0, 80.0, 0.02, 15.0, 4.0, 7.0])
    row = np.array([1e3, 1e3, 0.9, 0.1, 0.3, 1e3, 1.0, 0.2, 0.5])
    symmetric = 60.0 * 0.9 + 90.0 * 0.1 + 80.0 * 0.3
    assert add_friction(0.0, estimate[:5], row[:6]) == pytest.approx(symmetric, rel=1e-12)
    assert add_friction(0.0, estimate[:6], row[:7]) == pytest.approx(symmetric, rel=1e-12)
    assert add_friction(0.0, estimate, row) == pytest.approx(symmetric + 4.0 * 0.2 + 7.0 * 0.5, rel=1e-12)


NONE = Surprise(0.0, 0.0, 0.0)


@seeds
def test_surprise_compares_two_fading_means(seed):
    """Oracle: each sample's share times what later ones leave of it, summed, with samples of unequal length."""
    rng, window, surprise = np.random.default_rng(seed), 0.06, NONE
    friction, error = rng.uniform(-1.0, 1.0, 60), rng.uniform(-0.2, 0.2, 60)
    durations = rng.uniform(0.005, 0.015, 60)
    found = []
    for values in zip(friction, error, durations, strict=True):
        surprise = note_surprise(surprise, *values, window)
        found.append(explained_by_friction(surprise))
    left = window / (window + durations)
    for count in (1, 10, 60):
        weights = np.array([(1.0 - left[i]) * np.prod(left[i + 1 : count]) for i in range(count)])
        product = np.sum(weights * (friction * error)[:count])
        square = np.sum(weights * (friction**2)[:count])
        assert found[count - 1] == pytest.approx(product**2 / square, rel=1e-9)


@pytest.mark.parametrize("factor", [-0.4, 0.5])
def test_an_error_in_proportion_to_friction_is_explained_entirely(factor):
    surprise, rng, squares = NONE, np.random.default_rng(1), 0.0
    for _ in range(200):
        friction = rng.uniform(-1.0, 1.0)
        surprise = note_surprise(surprise, friction, factor * friction, 0.01, 0.09)
        squares += 0.1 * (friction**2 - squares)
        assert explained_by_friction(surprise) == pytest.approx(factor**2 * squares, rel=1e-9)


def test_an_error_that_has_nothing_to_do_with_friction_is_not_explained():
    surprise, sign = NONE, 1.0
    for _ in range(1000):
        sign = -sign
        surprise = note_surprise(surprise, 1.0, sign, 0.001, 0.1)
    assert explained_by_friction(surprise) < 1e-4


def test_without_friction_there_is_no_surprise():
    assert note_surprise(NONE, 0.0, 1.0, 0.01, 0.1)[:2] == NONE[:2]
    assert explained_by_friction(NONE) == 0.0


@functools.cache
def changed(seed, scale):
    scenario = SCENARIO.modified(seed=seed, duration=30.0, change=[{"time": CHANGE, "friction_scale": scale}])
    return {name: simulate(scenario, name) for name in ("pi", "adaptive", LEARNER)}


@changes
@seeds
def test_after_a_change_no_window_of_five_seconds_is_worse_than_without_compensation(seed, scale):
    window = round(5.0 / JOINT.solver_period)
    means = {}
    for name, run in changed(seed, scale).items():
        squares = np.concatenate([[0.0], np.cumsum((run.reference - run.velocity) ** 2)])
        means[name] = squares[window:] - squares[:-window]
    first = round(CHANGE / JOINT.solver_period)
    for name in ("adaptive", LEARNER):
        assert means[name].size - first > window
        assert np.all(means[name][first:] <= means["pi"][first:])


@changes
@seeds
def test_five_seconds_after_a_change_friction_is_known_again(seed, scale):
    estimates = changed(seed, scale)[LEARNER].estimates
    before, after = (round((CHANGE + seconds) / SCENARIO.sampling.period) - 1 for seconds in (0.0, 5.0))
    for name in ("coulomb", "stiction"):
        truth = getattr(JOINT, name)
        assert estimates[name][before] == pytest.approx(truth, rel=0.1)
        assert estimates[name][after] == pytest.approx(scale * truth, rel=0.1)
    assert estimates["inertia"][after] == pytest.approx(JOINT.inertia, rel=0.1)


@changes
@pytest.mark.parametrize("seed", SEEDS[:2])
def test_friction_is_forgotten_at_a_change_and_not_before(monkeypatch, seed, scale):
    """In plain Python, with every release counted."""
    calls = []

    def count(*arguments):
        calls.append(position.sample)
        forget_friction_in_place(*arguments)

    monkeypatch.setattr(forgetting, "forget_friction_in_place", count)
    scenario = changed(seed, scale)["pi"].scenario
    course, controller = lay_course(scenario), make(LEARNER, scenario)
    state, position = controller.state, begin(course)
    record = empty_record(course, len(controller.estimate_names))
    for stop, wanted in ((2000, False), (2050, True)):
        state, position = run_plain(controller.parameters, state, course, position, stop, record)
        assert bool(calls) is wanted


@seeds
def test_without_a_change_nothing_is_forgotten_in_a_minute(seed):
    """The condition of the module's docstring, with the usual error of the sample before."""
    controller, scenario = make(LEARNER), SCENARIO.modified(seed=seed)
    memory, usual, largest = controller.parameters.estimator.memory, math.inf, 0.0

    def watch(_):
        nonlocal usual, largest
        (product, square, _), levels = controller.state.estimator.surprise, controller.state.estimator.levels
        if levels.learnt > memory:
            largest = max(largest, product**2 / square / (usual + LEAST_ERROR))
        usual = levels.squared_error

    own_loop(controller, lay_course(scenario), watch=watch)
    assert 0.1 < largest < JUMP


def sine(seed, joint=JOINT):
    """Five periods from rest to rest."""
    return course_along(
        0.3 * np.sin(2.0 * math.pi * 0.25 * np.arange(20_001) * JOINT.solver_period),
        joint=joint,
        substeps=10,
        noise=0.002,
        seed=seed,
    )


@pytest.mark.parametrize("load", [20.0, -20.0, 40.0])
@pytest.mark.parametrize("identify", ["offset", "directions"])
def test_a_sudden_load_is_told_from_friction_as_soon_as_the_joint_has_moved_both_ways(identify, load):
    controller = make("adaptive", SCENARIO.modified(adaptation={"identify": identify}))
    drive(controller, sine(201))
    assert abs(controller.estimates["offset"]) < 1.0
    loaded = sine(202, JOINT.model_copy(update={"offset": load}))
    record, _ = drive(controller, loaded)
    coulomb, offset = record.estimates[:, PER_DIRECTION.index("coulomb")], record.estimates[:, OFFSET]
    assert offset[399:] == pytest.approx(np.full(offset[399:].size, load), rel=0.1)
    assert coulomb[399:] == pytest.approx(np.full(coulomb[399:].size, JOINT.coulomb), rel=0.1)
    pi, _ = drive(make("pi"), loaded)
    assert error_of(loaded, record, 15.0) < 0.3 * error_of(loaded, pi, 15.0)


@pytest.mark.parametrize("identify", ["offset", "gravity"])
@pytest.mark.parametrize("seed", [104, 105, 107])
def test_a_push_of_three_seconds_teaches_nothing_wrong_of_inertia_and_friction(seed, identify):
    """Seeds on which the push ends while it settles, is attributed at once, or ends at full speed."""
    scenario = SCENARIO.modified(
        seed=seed,
        duration=45.0,
        change=[{"time": 30.0, "load": 80.0}, {"time": 33.0, "load": 0.0}],
        adaptation={"identify": identify},
    )
    run = simulate(scenario, "adaptive")
    before, after = np.searchsorted(run.time, [29.9, 30.0])
    for name in ("inertia", "coulomb", "stiction", "viscous"):
        known = run.estimates[name][before]
        assert np.max(np.abs(run.estimates[name][after:] - known)) < 0.1 * known, name
