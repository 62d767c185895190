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
from adaptive_ff.adaptive import estimator
from adaptive_ff.adaptive.change_detection import (
    JUMP,
    LEAST_ERROR,
    Surprise,
    explained_by_friction,
    forget_friction_in_place,
    note_surprise,
    release_in_place,
)
from adaptive_ff.adaptive.estimator import add_friction
from adaptive_ff.model.bounds import COULOMB, OFFSET, STICTION, VISCOUS
from adaptive_ff.model.friction import PER_DIRECTION
from adaptive_ff.simulation.experiment import empty_record

JOINT, CHANGE = SCENARIO.joint, 20.0
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
    assert not np.allclose(rest.T @ result @ rest, rest.T @ information @ rest, rtol=1e-6)


@seeds
def test_little_is_known_already_and_nothing_is_released(seed):
    information, direction = random_information(seed)
    total = direction @ information @ direction
    assert np.array_equal(released(information, direction, 1.001 * total), information)
    assert np.array_equal(released(information, np.zeros(5), 1e-9), information)
    assert np.array_equal(released(information, np.zeros(5), 0.0), information)
    assert not np.array_equal(released(information, direction, 0.999 * total), information)


@pytest.mark.parametrize("size", [5, 6, 8])
def test_what_is_forgotten_is_the_factor_on_friction_and_the_offset(size):
    """Inertia, lag and the ratios of the friction parameters are known as well as before."""
    information, _ = random_information(size, size)
    estimate = np.array([20.0, 60.0, 90.0, 80.0, 0.02, 15.0, 4.0, 7.0])[:size]
    scale = np.array([18.0, 70.0, 50.0, 300.0, 0.03, 6.0, 5.0, 25.0])[:size]
    mean, unit, share = 0.3, 62.0, 0.02
    factor = estimate / scale
    factor[[i for i in range(size) if i not in (COULOMB, STICTION, VISCOUS) and i <= OFFSET]] = 0.0
    result = information.copy()
    forget_friction_in_place(result, estimate, scale, mean, unit, share, np.empty((size, size)))
    expected = released(information, factor, share * mean)
    if size > OFFSET:
        expected = released(expected, np.eye(size)[OFFSET], share * (scale[OFFSET] / unit) ** 2)
    assert np.allclose(result, expected, rtol=1e-12)
    assert factor @ result @ factor <= share * mean * (1.0 + 1e-9)
    assert np.allclose(np.linalg.inv(result)[[0, 4]], np.linalg.inv(information)[[0, 4]], rtol=1e-6, atol=1e-12), (
        "what is uncertain of inertia and lag"
    )


def test_friction_is_predicted_without_inertia_lag_and_offset():
    estimate = np.array([20.0, 60.0, 90.0, 80.0, 0.02, 15.0, 4.0, 7.0])
    row = np.array([1e3, 1e3, 0.9, 0.1, 0.3, 1e3, 1.0, 0.2, 0.5])
    symmetric = 60.0 * 0.9 + 90.0 * 0.1 + 80.0 * 0.3
    assert add_friction(0.0, estimate[:5], row[:6]) == pytest.approx(symmetric, rel=1e-12)
    assert add_friction(0.0, estimate[:6], row[:7]) == pytest.approx(symmetric, rel=1e-12)
    assert add_friction(0.0, estimate, row) == pytest.approx(symmetric + 4.0 * 0.2 + 7.0 * 0.5, rel=1e-12)


NONE = Surprise(0.0, 0.0)


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
    assert note_surprise(NONE, 0.0, 1.0, 0.01, 0.1) == NONE
    assert explained_by_friction(NONE) == 0.0


@functools.cache
def changed(seed, scale):
    scenario = SCENARIO.modified(seed=seed, duration=30.0, change=[{"time": CHANGE, "friction_scale": scale}])
    return {name: simulate(scenario, name) for name in ("pi", "adaptive")}


@changes
@seeds
def test_after_a_change_no_window_of_five_seconds_is_worse_than_without_compensation(seed, scale):
    window = round(5.0 / JOINT.solver_period)
    means = {}
    for name, run in changed(seed, scale).items():
        squares = np.concatenate([[0.0], np.cumsum((run.reference - run.velocity) ** 2)])
        means[name] = squares[window:] - squares[:-window]
    first = round(CHANGE / JOINT.solver_period)
    assert means["adaptive"].size - first > window
    assert np.all(means["adaptive"][first:] <= means["pi"][first:])


@changes
@seeds
def test_five_seconds_after_a_change_friction_is_known_again(seed, scale):
    estimates = changed(seed, scale)["adaptive"].estimates
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

    monkeypatch.setattr(estimator, "forget_friction_in_place", count)
    scenario = changed(seed, scale)["pi"].scenario
    course, controller = lay_course(scenario), make("adaptive", scenario)
    state, position = controller.state, begin(course)
    record = empty_record(course, len(controller.estimate_names))
    for stop, wanted in ((2000, False), (2050, True)):
        state, position = run_plain(controller.parameters, state, course, position, stop, record)
        assert bool(calls) is wanted


@seeds
def test_without_a_change_nothing_is_forgotten_in_a_minute(seed):
    """The condition of the module's docstring, with the usual error of the sample before."""
    controller, scenario = make("adaptive"), SCENARIO.modified(seed=seed)
    memory, usual, largest = controller.parameters.estimator.memory, math.inf, 0.0

    def watch(_):
        nonlocal usual, largest
        (product, square), levels = controller.state.estimator.surprise, controller.state.estimator.levels
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
