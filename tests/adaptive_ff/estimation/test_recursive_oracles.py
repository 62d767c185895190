"""Each recursive estimator against an independent solution."""

import math
import warnings

import numpy as np
import pytest
from filterpy.kalman import KalmanFilter

from adaptive_ff.estimation.exponential_resetting import ExponentialResetting
from adaptive_ff.estimation.instrumental_variable import InstrumentalVariable
from adaptive_ff.estimation.kalman_random_walk import KalmanRandomWalk
from adaptive_ff.estimation.least_squares import LeastSquares

PERIOD = 0.01
TRUE = np.array([3.0, -1.0, 50.0])
FIRST = np.array([1.0, 0.0, 20.0])
DEVIATION = np.array([2.0, 5.0, 40.0])


def data(steps, seed, noise=0.3):
    rng = np.random.default_rng(seed)
    rows = rng.standard_normal((steps, 3)) * np.array([1.0, 1.0, 0.05])
    return rows, rows @ TRUE + noise * rng.standard_normal(steps)


@pytest.mark.parametrize("memory", [math.inf, 1.5])
@pytest.mark.parametrize("steps", [2, 40, 1000])
def test_least_squares_is_one_weighted_batch_solution(memory, steps):
    """Weights ``lambda^age``, the first estimate faded alike; covariance of that solution for independent errors."""
    rows, outputs = data(steps, seed=21)
    estimator = LeastSquares(FIRST, PERIOD, first_deviation=DEVIATION, noise=0.5, memory=memory)
    estimator.run(rows, outputs)
    keep = math.exp(-PERIOD / memory)
    weights = keep ** np.arange(steps - 1, -1, -1)
    prior = np.diag((0.5 / DEVIATION) ** 2)
    solution = np.linalg.inv(rows.T @ (weights[:, np.newaxis] * rows) + keep**steps * prior)
    expected = solution @ (rows.T @ (weights * outputs) + keep**steps * prior @ FIRST)
    assert estimator.estimate == pytest.approx(expected, rel=1e-9)
    squared = rows.T @ (weights[:, np.newaxis] ** 2 * rows) + keep ** (2 * steps) * prior
    spread = solution @ squared @ solution
    assert estimator.covariance == pytest.approx(estimator.noise**2 * spread, rel=1e-8, abs=1e-12)


def test_without_forgetting_the_covariance_is_that_of_the_recursion():
    rows, outputs = data(300, seed=22)
    estimator = LeastSquares(FIRST, PERIOD, first_deviation=DEVIATION, noise=0.5)
    estimator.run(rows, outputs)
    assert estimator.state.spread == pytest.approx(estimator.state.recursion.covariance, rel=1e-9, abs=1e-12)


def filterpy_walk(noise, walk):
    """Filter of filterpy for the same parameters."""
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", DeprecationWarning)
        kalman = KalmanFilter(dim_x=3, dim_z=1)
    kalman.x = FIRST[:, np.newaxis].copy()
    kalman.F, kalman.R, kalman.P = np.eye(3), noise**2 * np.eye(1), np.diag(DEVIATION**2)
    return kalman, np.diag(walk**2)


def test_random_walk_is_the_kalman_filter_of_filterpy():
    rows, outputs = data(2000, seed=23)
    steps = np.random.default_rng(24).uniform(0.5, 2.0, 2000) * PERIOD
    walk = np.array([0.5, 0.0, 3.0])
    estimator = KalmanRandomWalk(
        FIRST, PERIOD, first_deviation=DEVIATION, noise=0.3, walk=walk, largest_deviation=1e3 * DEVIATION
    )
    kalman, growth = filterpy_walk(0.3, walk)
    for row, output, step in zip(rows, outputs, steps, strict=True):
        error = estimator.update(row, output, dt=step)
        kalman.predict(Q=growth * step)
        kalman.H = row[np.newaxis, :]
        kalman.update(output)
        assert error == pytest.approx(kalman.y.item(), rel=1e-9, abs=1e-9)
    assert estimator.estimate == pytest.approx(kalman.x[:, 0], rel=1e-10)
    assert estimator.covariance == pytest.approx(kalman.P, rel=1e-9, abs=1e-12)
    assert estimator.consistency == pytest.approx(1.0, abs=0.1)


def test_no_variance_of_a_random_walk_exceeds_the_largest_and_correlations_are_kept():
    rows, outputs = data(20, seed=25)
    estimator = KalmanRandomWalk(
        FIRST, PERIOD, first_deviation=DEVIATION, noise=0.3, walk=DEVIATION, largest_deviation=2.0 * DEVIATION
    )
    estimator.run(rows[:2], outputs[:2])
    before = estimator.covariance
    estimator.update(np.zeros(3), 0.0, dt=1e6)
    assert estimator.standard_errors == pytest.approx(2.0 * DEVIATION, rel=1e-12)
    grown = before + np.diag(DEVIATION**2) * 1e6
    shares = 2.0 * DEVIATION / np.sqrt(np.diag(grown))
    assert estimator.covariance == pytest.approx(grown * np.outer(shares, shares), rel=1e-9)


def test_resetting_without_excitation_returns_to_the_first_gain_and_keeps_the_estimate():
    rows, outputs = data(2000, seed=26)
    estimator = ExponentialResetting(FIRST, PERIOD, first_deviation=DEVIATION, noise=0.3, memory=2.0)
    fresh = estimator.state.recursion.information.copy()
    estimator.run(rows, outputs)
    learnt = estimator.estimate
    assert np.min(np.diag(estimator.state.recursion.information)) > 3.0 * fresh[0, 0]
    estimator.run(np.zeros((10_000, 3)), np.ones(10_000))
    assert estimator.state.recursion.information == pytest.approx(fresh, rel=1e-9, abs=1e-15)
    assert np.array_equal(estimator.estimate, learnt)


def test_resetting_is_weighted_least_squares_that_is_drawn_to_where_it_is():
    """Each step minimises the faded information about the last estimate, the floor's, and the new equation."""
    rows, outputs = data(60, seed=27)
    estimator = ExponentialResetting(FIRST, PERIOD, first_deviation=DEVIATION, noise=0.3, memory=0.5)
    keep = math.exp(-PERIOD / 0.5)
    information, estimate = np.diag((0.3 / DEVIATION) ** 2), FIRST.copy()
    floor = information.copy()
    for row, output in zip(rows, outputs, strict=True):
        about = keep * information + (1.0 - keep) * floor
        information = about + np.outer(row, row)
        estimate = np.linalg.solve(information, about @ estimate + row * output)
        estimator.update(row, output)
        assert estimator.estimate == pytest.approx(estimate, rel=1e-9)


def noisy_regressors(steps, seed):
    rng = np.random.default_rng(seed)
    clean = rng.standard_normal((steps, 3)) * np.array([1.0, 1.0, 0.05])
    outputs = clean @ TRUE + 0.3 * rng.standard_normal(steps)
    return clean, clean + 0.5 * np.array([1.0, 1.0, 0.05]) * rng.standard_normal((steps, 3)), outputs


def test_instruments_give_the_batch_solution_and_remove_the_bias_that_least_squares_has():
    clean, rows, outputs = noisy_regressors(100_000, seed=28)
    assumed = {"first_deviation": DEVIATION, "noise": 1.0, "memory": 200.0}
    estimator, biased = InstrumentalVariable(FIRST, PERIOD, **assumed), ExponentialResetting(FIRST, PERIOD, **assumed)
    estimator.run(rows, outputs, instruments=clean)
    biased.run(rows, outputs)
    weights = math.exp(-PERIOD / 200.0) ** np.arange(outputs.size - 1, -1, -1)
    weighted = (clean * weights[:, np.newaxis]).T
    expected = np.linalg.solve(weighted @ rows, weighted @ outputs)
    assert np.all(np.abs(estimator.estimate - expected) < 0.5 * estimator.standard_errors)
    assert np.all(np.abs(estimator.estimate - TRUE) < 3.0 * estimator.standard_errors)
    assert biased.estimate == pytest.approx(TRUE / 1.25, rel=0.05)
    assert np.all(np.abs(biased.estimate - TRUE) > 10.0 * estimator.standard_errors)


@pytest.mark.parametrize("factor", [-1.0, 5.0])
def test_instruments_that_do_not_resemble_the_regressors_are_not_believed(factor):
    """Used, the first would drive the estimate away, exponentially."""
    rows, outputs = data(5000, seed=29)
    estimator = InstrumentalVariable(FIRST, PERIOD, first_deviation=DEVIATION, noise=0.3, memory=2.0)
    given = factor * rows
    estimator.run(rows, outputs, instruments=given)
    assert np.array_equal(given, factor * rows)
    plain = ExponentialResetting(FIRST, PERIOD, first_deviation=DEVIATION, noise=0.3, memory=2.0)
    plain.run(rows, outputs)
    assert estimator.estimate == pytest.approx(plain.estimate, rel=1e-12)


def test_instruments_that_are_zero_teach_nothing():
    rows, outputs = data(5000, seed=30)
    estimator = InstrumentalVariable(FIRST, PERIOD, first_deviation=DEVIATION, noise=0.3, memory=2.0)
    estimator.run(rows, outputs, instruments=0.0 * rows)
    assert np.array_equal(estimator.estimate, FIRST)
    assert estimator.standard_errors / estimator.noise == pytest.approx(DEVIATION / 0.3)
