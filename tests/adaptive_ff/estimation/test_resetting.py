import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays

from adaptive_ff.estimation.resetting import (
    ResettingState,
    factor_in_place,
    move_parameter_in_place,
    prediction_variance_in_place,
    solve_in_place,
    update_resetting_in_place,
)
from adaptive_ff.learning.rls import initial_rls_state, update_rls_in_place
from controllers import compiled

SIZE = 5
FLOOR = 3e-5


def update(information, floor, keep, instrument, error):
    gain = np.empty(instrument.size)
    state = ResettingState(np.empty(instrument.size), information, instrument, gain, np.empty_like(information))
    update_resetting_in_place(state, floor, keep, error)
    return gain


def follow(state, floor, keep, regressors, instruments, outputs):
    estimate, information, correction, instrument = state.estimate, state.information, state.gain, state.instrument
    least, most, largest = math.inf, 0.0, 0.0
    for k in range(outputs.size):
        error = outputs[k]
        for i in range(estimate.size):
            error -= regressors[k, i] * estimate[i]
        instrument[:] = instruments[k]
        update_resetting_in_place(state, floor, keep, error)
        for i in range(estimate.size):
            estimate[i] += correction[i]
            largest = max(largest, abs(correction[i]))
            least, most = min(least, information[i, i]), max(most, information[i, i])
    return least, most, largest


FOLLOW = compiled(follow)


def run(information, floor, keep, regressors, instruments, outputs, estimate, way=FOLLOW):
    """Go through the data; the smallest and the largest entry on the diagonal, and the largest correction seen."""
    room = np.empty(estimate.size), np.empty(estimate.size), np.empty_like(information)
    state = ResettingState(estimate, information, *room)
    return way(state, floor, keep, regressors, instruments, outputs)


@pytest.mark.parametrize(("keep", "prior"), [(0.998, 1e4), (0.9, 10.0)])
def test_without_floor_and_with_the_regressors_as_instruments_it_is_least_squares(keep, prior):
    """The information is that of least squares per unit of memory, ``M = (1 - lambda) R^-1``."""
    rng = np.random.default_rng(11)
    state = initial_rls_state(np.zeros(SIZE), prior * np.eye(SIZE))
    other, information = np.zeros(SIZE), (1.0 - keep) / prior * np.eye(SIZE)
    for _ in range(2000):
        row = rng.standard_normal(SIZE)
        output = row @ np.array([3.0, -1.0, 0.5, 2.0, 10.0]) + 0.1 * rng.standard_normal()
        update_rls_in_place(state, row, output, keep)
        other += update(information, 0.0, keep, row, output - row @ other)
        assert np.linalg.norm(other - state.estimate) <= 1e-9 * np.linalg.norm(state.estimate)
    assert information == pytest.approx((1.0 - keep) * np.linalg.inv(state.covariance), rel=1e-9, abs=1e-10)


def test_information_is_the_fading_mean_of_what_the_instruments_saw_above_the_floor():
    keep, rng = 0.97, np.random.default_rng(12)
    instruments = rng.standard_normal((300, SIZE))
    start = rng.standard_normal((SIZE, SIZE))
    information = start @ start.T
    expected = keep**300 * information + (1.0 - keep**300) * 0.3 * np.eye(SIZE)
    for age, row in enumerate(instruments[::-1]):
        expected += (1.0 - keep) * keep**age * np.outer(row, row)
    for row in instruments:
        update(information, 0.3, keep, row, 1.0)
    assert information == pytest.approx(expected, rel=1e-11, abs=1e-13)
    assert np.array_equal(information, information.T)


@pytest.mark.parametrize("excitation", [0.0, 1.0], ids=["none", "one direction only"])
def test_two_hundred_thousand_samples_without_excitation_neither_wind_up_nor_move_the_estimate(excitation):
    steps, keep = 200_000, 0.9998
    rng = np.random.default_rng(13)
    rows = np.zeros((steps, SIZE)) + excitation * np.array([0.0, 1.0, 0.5, 0.3, 0.0])
    start = np.array([1.0, 2.0, 3.0, 4.0, 5.0])
    outputs = rows @ start + excitation * 0.1 * rng.standard_normal(steps)
    information, estimate = np.eye(SIZE), start.copy()
    least, most, largest = run(information, FLOOR, keep, rows, rows, outputs, estimate)
    assert least >= FLOOR * (1.0 - 1e-9)
    assert most <= 1.0 + excitation
    assert np.array_equal(information, information.T)
    expected = FLOOR * np.eye(SIZE) + np.outer(rows[0], rows[0])
    assert information == pytest.approx(expected, rel=1e-9, abs=1e-12)
    assert largest < 0.01 * excitation + 1e-12
    assert estimate == pytest.approx(start, abs=0.05 * excitation + 1e-12)


wild = st.floats(-1e3, 1e3) | st.sampled_from([0.0, 1e-300, -1e3, 1e3, 1.0])


@settings(max_examples=80, deadline=None)
@given(
    arrays(float, st.tuples(st.integers(1, 25), st.just(SIZE)), elements=wild),
    st.floats(0.5, 0.9999),
    st.floats(-1e6, 1e6),
)
def test_for_wild_data_information_stays_positive_definite_and_the_gain_bounded(instruments, keep, error):
    information = FLOOR * np.eye(SIZE)
    for instrument in instruments:
        correction = update(information, FLOOR, keep, instrument, error)
        assert np.array_equal(information, information.T)
        assert np.min(np.linalg.eigvalsh(information)) >= FLOOR - 1e-9 * np.max(information)
        # (1 - lambda) |M^-1 z| with M >= floor + (1 - lambda) z z' is largest at (1 - lambda) |z|^2 = floor
        bound = 0.5 * math.sqrt((1.0 - keep) / FLOOR) * abs(error)
        assert np.linalg.norm(correction) <= bound * 1.01
    assert np.max(np.diag(information)) <= (FLOOR + np.max(np.square(instruments))) * (1.0 + 1e-12)


def test_clean_instruments_remove_the_bias_that_noise_in_the_regressors_causes():
    """Errors in variables: least squares shrinks a parameter by ``var/(var + noise var)``."""
    rng = np.random.default_rng(14)
    true, steps = np.array([2.0, -1.0, 0.5]), 300_000
    clean = rng.standard_normal((steps, 3))
    outputs = clean @ true + 0.3 * rng.standard_normal(steps)
    noisy = clean + 0.5 * rng.standard_normal((steps, 3))
    found = {}
    for name, instruments in (("instruments", clean), ("regressors", noisy)):
        found[name] = np.zeros(3)
        run(0.01 * np.eye(3), 1e-6, 0.9999, noisy, instruments, outputs, found[name])
    assert found["instruments"] == pytest.approx(true, abs=0.03)
    assert found["regressors"] == pytest.approx(true / 1.25, abs=0.03)


def test_fixed_point_is_the_batch_solution_with_instruments_also_where_the_disturbance_is_in_the_regressors():
    rng = np.random.default_rng(15)
    steps, true = 200_000, np.array([1.0, 3.0])
    clean, fed_back = rng.standard_normal((steps, 2)), rng.standard_normal((steps, 2))
    rows = clean + fed_back
    instruments = clean @ np.array([[1.0, 0.4], [0.2, 0.8]])
    outputs = rows @ true + 0.8 * fed_back[:, 0]
    expected = np.linalg.solve(instruments.T @ rows, instruments.T @ outputs)
    least_squares = np.linalg.solve(rows.T @ rows, rows.T @ outputs)
    assert abs(least_squares[0] - true[0]) > 0.3
    estimate = np.zeros(2)
    run(0.01 * np.eye(2), 1e-9, 0.99995, rows, instruments, outputs, estimate)
    assert estimate == pytest.approx(expected, abs=0.03)


@st.composite
def positive_definite(draw):
    """A symmetric positive definite matrix and a vector."""
    size, ridge = draw(st.integers(1, 7)), draw(st.floats(1e-6, 1e3))
    rng = np.random.default_rng(draw(st.integers(0, 10_000)))
    root = rng.standard_normal((size, size))
    return root @ root.T + ridge * np.eye(size), rng.standard_normal(size)


def assert_near(found, expected, condition):
    assert np.linalg.norm(found - expected) <= 1e-14 * condition * np.linalg.norm(expected) + 1e-14


@settings(deadline=None)
@given(positive_definite())
def test_solution_by_cholesky_is_that_of_numpy(system):
    matrix, right = system
    factor, solution = matrix.copy(), right.copy()
    factor_in_place(factor)
    lower = np.tril(factor)
    assert lower @ lower.T == pytest.approx(matrix, rel=1e-12, abs=1e-12)
    solve_in_place(factor, solution)
    assert_near(solution, np.linalg.solve(matrix, right), np.linalg.cond(matrix))


@settings(deadline=None)
@given(positive_definite(), st.integers(0, 6), st.floats(-10.0, 10.0))
def test_a_parameter_that_is_moved_takes_the_others_along_as_constrained_least_squares_says(system, index, distance):
    """The smallest ``m' M m`` among moves with a given entry, from its equations with a Lagrange multiplier."""
    matrix, correction = system
    size = correction.size
    index %= size
    one = np.eye(size)[index]
    conditions = np.block([[matrix, -one[:, np.newaxis]], [one[np.newaxis, :], np.zeros((1, 1))]])
    expected = np.linalg.solve(conditions, np.append(np.zeros(size), distance))[:size]
    factor, moved = matrix.copy(), correction.copy()
    factor_in_place(factor)
    move_parameter_in_place(factor, index, distance, moved, np.empty(size))
    assert moved[index] - correction[index] == pytest.approx(distance, rel=1e-9, abs=1e-12)
    assert_near(moved, correction + expected, 10.0 * np.linalg.cond(matrix) * (1.0 + np.linalg.norm(expected)))


def test_prediction_variance_is_the_quadratic_form_of_the_inverse():
    rng = np.random.default_rng(12)
    rows = rng.standard_normal((20, SIZE))
    information, regressors = rows.T @ rows, rng.standard_normal(SIZE)
    kept = information.copy()
    state = ResettingState(np.zeros(SIZE), information, regressors, np.zeros(SIZE), np.zeros((SIZE, SIZE)))
    assert prediction_variance_in_place(state) == pytest.approx(
        regressors @ np.linalg.solve(kept, regressors), rel=1e-12
    )
    assert np.array_equal(information, kept)
