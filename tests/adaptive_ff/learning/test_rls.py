import numpy as np
import pytest
from filterpy.kalman import FadingKalmanFilter

from adaptive_ff.learning.rls import begin_anew_in_place, initial_rls_state, update_rls_in_place

SIZE = 6
TRUE = np.array([1.6, 0.7, 2e-2, 1e-2, -0.5, 0.3])


def exciting_data(steps, seed, noise=0.05):
    rng = np.random.default_rng(seed)
    rows = rng.standard_normal((steps, SIZE)) * np.array([1.0, 1.0, 5.0, 5.0, 1.0, 1.0])
    return rows, rows @ TRUE + noise * rng.standard_normal(steps)


def rows_near(found, expected, tolerance):
    """Whether each step's numbers are those of the oracle, by the norm of their difference."""
    found, expected = found.reshape(len(found), -1), expected.reshape(len(expected), -1)
    return np.linalg.norm(found - expected, axis=1) <= tolerance * np.linalg.norm(expected, axis=1)


@pytest.mark.parametrize(("forgetting_factor", "prior"), [(0.998, 1e4), (0.99, 100.0), (1.0, 1.0)])
def test_it_is_the_fading_memory_kalman_filter_of_filterpy(forgetting_factor, prior):
    """At each of 2000 steps: prediction error, estimate and covariance; compared at the end, which is quick."""
    steps = 2000
    rows, outputs = exciting_data(steps, seed=8)
    state = initial_rls_state(np.zeros(SIZE), prior * np.eye(SIZE))
    with pytest.warns(DeprecationWarning, match="KalmanFilter class"):
        kalman = FadingKalmanFilter(forgetting_factor**-0.5, dim_x=SIZE, dim_z=1)  # alpha^2 = 1/lambda
    kalman.P, kalman.F, kalman.Q = prior * np.eye(SIZE), np.eye(SIZE), np.zeros((SIZE, SIZE))
    kalman.R = np.eye(1)
    errors, estimates, covariances = np.empty((2, steps)), np.empty((2, steps, SIZE)), np.empty((2, steps, SIZE, SIZE))
    for k in range(steps):
        errors[0, k] = update_rls_in_place(state, rows[k], outputs[k], forgetting_factor)
        estimates[0, k], covariances[0, k] = state.estimate, state.covariance
        kalman.predict()  # the division by lambda comes before the update
        kalman.H = rows[k : k + 1]
        kalman.update(outputs[k])
        errors[1, k], estimates[1, k], covariances[1, k] = kalman.y[0, 0], kalman.x[:, 0], kalman.P
    assert np.all(np.abs(errors[0] - errors[1]) <= np.maximum(1e-6 * np.abs(errors[1]), 1e-9))
    assert np.all(rows_near(*estimates, 1e-9))
    assert np.all(rows_near(*covariances, 1e-9))


@pytest.mark.parametrize(("forgetting_factor", "prior"), [(0.995, 1e4), (0.9, 10.0), (1.0, 1.0)])
@pytest.mark.parametrize("steps", [3, 60, 1500])
def test_it_is_one_weighted_batch_solution_with_the_fading_prior(forgetting_factor, prior, steps):
    rows, outputs = exciting_data(steps, seed=9)
    start = np.array([1.0, 0.0, 0.1, 0.0, 0.0, 1.0])
    state = initial_rls_state(start, prior * np.eye(SIZE))
    for row, output in zip(rows, outputs, strict=True):
        update_rls_in_place(state, row, output, forgetting_factor)
    weights = forgetting_factor ** np.arange(steps - 1, -1, -1)
    fading = forgetting_factor**steps / prior * np.eye(SIZE)
    information = rows.T @ (weights[:, np.newaxis] * rows) + fading
    expected = np.linalg.solve(information, rows.T @ (weights * outputs) + fading @ start)
    assert rows_near(state.estimate[np.newaxis], expected[np.newaxis], 1e-8)
    assert rows_near(state.covariance[np.newaxis], np.linalg.inv(information)[np.newaxis], 1e-8)


def test_covariance_stays_exactly_symmetric_and_positive_definite():
    rows, outputs = exciting_data(3000, seed=10)
    rows[:, 1] = rows[:, 0] + 1e-3 * rows[:, 1]  # nearly collinear
    state = initial_rls_state(np.zeros(SIZE), 1e4 * np.eye(SIZE))
    for row, output in zip(rows, outputs, strict=True):
        update_rls_in_place(state, row, output, 0.99)
        assert np.array_equal(state.covariance, state.covariance.T)
    assert np.min(np.linalg.eigvalsh(state.covariance)) > 0.0


def test_one_update_is_that_of_11_to_13_by_hand():
    state = initial_rls_state(np.array([1.0, 2.0]), np.eye(2))
    error = update_rls_in_place(state, np.array([3.0, 1.0]), 7.0, 0.5)
    assert error == 2.0  # of the prediction before the update
    assert state.gain == pytest.approx([3.0 / 10.5, 1.0 / 10.5], rel=1e-14)
    assert state.estimate == pytest.approx([1.0 + 3.0 / 10.5 * 2.0, 2.0 + 1.0 / 10.5 * 2.0], rel=1e-14)
    assert state.covariance == pytest.approx(2.0 * np.array([[1.5, -3.0], [-3.0, 9.5]]) / 10.5, rel=1e-14)


@pytest.mark.parametrize("lost", ["estimate", "covariance"])
def test_it_begins_anew_where_a_number_is_lost_and_only_there(lost):
    state = initial_rls_state(np.array([1.0, 2.0]), 3.0 * np.eye(2))
    update_rls_in_place(state, np.array([3.0, 1.0]), 7.0, 0.5)
    assert not begin_anew_in_place(state, 5.0)
    getattr(state, lost).flat[-1] = np.nan
    assert begin_anew_in_place(state, 5.0)
    assert [part.tolist() for part in state] == [[0.0, 0.0], [[5.0, 0.0], [0.0, 5.0]], [0.0, 0.0]]
