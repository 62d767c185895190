"""The filter of the coefficients against filters of others; what makes it the recursive least squares of the paper.

And the response of the loop that it learns behind, against python-control's discrete loop.
"""

import math

import control
import numpy as np
import pytest
from filterpy.kalman import KalmanFilter
from hypothesis import given
from hypothesis import strategies as st
from scipy.optimize import lsq_linear

from adaptive_ff.learning import kalman
from adaptive_ff.learning.kalman import LOOP, Estimate, Modes, Prior
from adaptive_ff.learning.response import advance_response, initial_response, put_in
from adaptive_ff.learning.rls import RLSState, update_rls_in_place
from controllers import check_gains, pi_gains
from controllers.arrays import packed, unpacked

SEEDS = st.integers(0, 10**6)


def spread(rng, size):
    """A random covariance."""
    root = rng.standard_normal((size, size)) * 10.0 ** rng.uniform(-1.0, 1.0, size)
    return root @ root.T + 1e-6 * np.eye(size)


ONE = Modes(0.0, 0.0, 0.5)  # two modes that are alike: a Kalman filter


def drawn(rng, count):
    return Estimate(rng.standard_normal(LOOP + count), packed(spread(rng, LOOP + count)))


def oracle(estimate, size=1):
    found = KalmanFilter(dim_x=estimate.mean.size, dim_z=size)
    found.x, found.P = estimate.mean[:, np.newaxis].copy(), unpacked(estimate.covariance)
    return found


def updated(estimate, x, y, noise, clip=math.inf, modes=ONE):
    """Update with one measurement; the sensitivities hold at their own parameters."""
    lag, velocity = estimate.mean[-2], estimate.mean[-1]
    return kalman.update_in_place(estimate, x, y, noise, modes, clip, lag, velocity, np.zeros(estimate.mean.size))


@given(seed=SEEDS)
def test_update_and_flow_are_those_of_a_kalman_filter(seed):
    rng = np.random.default_rng(seed)
    estimate = drawn(rng, 5)
    other = oracle(estimate)
    x, noise, y = rng.standard_normal(5), 10.0 ** rng.uniform(-3.0, 1.0), float(rng.standard_normal())
    rate, proportional, integral = rng.uniform(0.01, 1.0), rng.uniform(0.0, 2.0), rng.uniform(0.0, 0.5)
    move = np.eye(7)
    move[:2, :2] = [[1.0 - rate * proportional, -rate], [integral * (1.0 - rate * proportional), 1.0 - integral * rate]]
    other.predict(F=move, Q=np.diag([noise, *np.zeros(6)]))
    kalman.flow_in_place(estimate, rate, proportional, integral, noise)
    np.testing.assert_allclose(estimate.mean, other.x[:, 0], rtol=1e-9, atol=1e-12)
    np.testing.assert_allclose(unpacked(estimate.covariance), other.P, rtol=1e-9, atol=1e-12 * np.max(other.P))
    row = np.concatenate([[1.0, 0.0], x])
    other.update(y + x[-2:] @ estimate.mean[-2:], R=np.array([[noise]]), H=row[np.newaxis])
    normalised, _ = updated(estimate, x, y, noise)
    np.testing.assert_allclose(estimate.mean, other.x[:, 0], rtol=1e-6, atol=1e-9)
    absolute = 1e-9 * np.max(spread(rng, 2)) + 1e-9
    np.testing.assert_allclose(unpacked(estimate.covariance), other.P, rtol=1e-6, atol=absolute)
    assert normalised == pytest.approx(float(other.y[0, 0]) / math.sqrt(float(other.S[0, 0])))


@pytest.mark.parametrize("forgetting", [1.0, 0.99, 0.9])
def test_without_loop_states_it_is_the_recursive_least_squares_of_the_paper(forgetting):
    """Process noise ``(1/lambda - 1) P``, ``G = 1``: equations (11) to (13)."""
    rng = np.random.default_rng(7)
    count, size = 300, 6
    rows = rng.standard_normal((count, size))
    outputs = rows @ rng.standard_normal(size) + 0.1 * rng.standard_normal(count)
    first = 100.0 * np.eye(size)
    paper = RLSState(np.zeros(size), first.copy(), np.zeros(size))
    estimate = Estimate(np.zeros(LOOP + size + 2), packed(np.pad(first, LOOP)))
    for row, output in zip(rows, outputs, strict=True):
        update_rls_in_place(paper, row, output, forgetting)
        estimate.covariance[:] /= forgetting
        updated(estimate, np.concatenate([row, [0.0, 0.0]]), output, 1.0)
        np.testing.assert_allclose(estimate.mean[LOOP:-2], paper.estimate, rtol=1e-9, atol=1e-9)
    np.testing.assert_allclose(unpacked(estimate.covariance)[LOOP:-2, LOOP:-2], paper.covariance, rtol=1e-8, atol=1e-12)


@given(seed=SEEDS, weight=st.floats(0.01, 0.99), quiet=st.floats(0.0, 1.0), further=st.floats(0.01, 10.0))
def test_two_modes_are_merged_from_two_kalman_filters(seed, weight, quiet, further):
    """Generalised pseudo-Bayes of first order: each mode has a filter, and the mixture one mean and covariance."""
    rng = np.random.default_rng(seed)
    estimate = drawn(rng, 3)
    x, noise, y = rng.standard_normal(3), 10.0 ** rng.uniform(-2.0, 1.0), float(3.0 * rng.standard_normal())
    row, offset = np.concatenate([[1.0, 0.0], x]), float(x[-2:] @ estimate.mean[-2:])
    filters, odds = [], []
    for variance, probability in ((quiet, 1.0 - weight), (quiet + further, weight)):
        other = oracle(estimate)
        other.predict(F=np.eye(5), Q=np.diag([variance, *np.zeros(4)]))
        other.update(y + offset, R=np.array([[noise]]), H=row[np.newaxis])
        filters.append(other)
        odds.append(probability * other.likelihood)
    odds = np.array(odds) / sum(odds)
    mean = sum(part * other.x[:, 0] for part, other in zip(odds, filters, strict=True))
    apart = [other.x[:, 0] - mean for other in filters]
    triples = zip(odds, filters, apart, strict=True)
    covariance = sum(part * (other.P + np.outer(away, away)) for part, other, away in triples)
    _, found = updated(estimate, x, y, noise, modes=Modes(quiet, quiet + further, weight))
    assert found == pytest.approx(odds[1], rel=1e-6, abs=2e-6)
    np.testing.assert_allclose(estimate.mean, mean, rtol=1e-6, atol=1e-8)
    np.testing.assert_allclose(unpacked(estimate.covariance), covariance, rtol=1e-6, atol=1e-8 * np.max(covariance))


@given(seed=SEEDS)
def test_the_bounds_are_met_by_the_projection_in_the_metric_of_the_information(seed):
    """Against a bounded least-squares solver: with up to four bounds at work."""
    rng = np.random.default_rng(seed)
    count = 6
    root = np.eye(LOOP + count) + 0.1 * rng.standard_normal((LOOP + count,) * 2)
    estimate = Estimate(rng.standard_normal(LOOP + count), packed(root @ root.T))
    lowest = np.full(count, -math.inf)
    lowest[:4] = 0.0
    prior = Prior(np.zeros(count), packed(np.eye(count)), np.zeros(count, bool), lowest, np.full(count, math.inf))
    bounds = (np.concatenate([[-math.inf] * LOOP, lowest]), math.inf)
    solution = lsq_linear(np.linalg.inv(root), np.linalg.solve(root, estimate.mean), bounds, tol=1e-12)
    kalman.constrain_in_place(estimate, prior, np.zeros(count))
    assert np.all(estimate.mean[LOOP:] >= lowest)
    np.testing.assert_allclose(estimate.mean, solution.x, atol=1e-3)  # after the sweeps of one update


def test_what_is_not_measured_returns_to_the_prior():
    rng = np.random.default_rng(3)
    estimate = drawn(rng, 4)
    scaled = np.array([False, True, True, False])
    known = np.where(scaled[:, np.newaxis] == scaled, spread(rng, 4), 0.0)
    prior = Prior(rng.standard_normal(4), packed(known), scaled, np.full(4, -math.inf), np.full(4, math.inf))
    for _ in range(2000):
        kalman.return_in_place(estimate, prior, 10.0, 0.99)
    units = np.where(scaled, 10.0, 1.0)
    np.testing.assert_allclose(estimate.mean[LOOP:], prior.mean * units, rtol=1e-6)
    expected = unpacked(prior.covariance) * np.outer(units, units)
    np.testing.assert_allclose(unpacked(estimate.covariance)[LOOP:, LOOP:], expected, rtol=1e-6, atol=1e-9)


@given(seed=SEEDS)
def test_an_outlier_counts_no_more_than_the_clip_says(seed):
    rng = np.random.default_rng(seed)
    plain, clipped, wild = (drawn(np.random.default_rng(seed), 4) for _ in range(3))
    x = rng.standard_normal(4)
    base = plain.mean.copy()
    row = np.concatenate([[1.0, 0.0], x])
    level = math.sqrt(row @ unpacked(plain.covariance) @ row + 1.0)
    centre = base[0] + x[:-2] @ base[LOOP:-2]
    updated(clipped, x, centre + 3.0 * level, 1.0, clip=3.0)
    updated(wild, x, centre + 1e6 * level, 1.0, clip=3.0)
    steps = [np.abs(estimate.mean - base) for estimate in (clipped, wild)]
    assert np.all(steps[1] <= steps[0] * (1.0 + 1e-6) + 1e-12)


@pytest.mark.parametrize("seed", range(5))
def test_sum_of_squared_innovations_is_the_least_regularised_sum_of_squares(seed):
    """``sum R nu^2/S = min [sum (y - theta'x)^2 + R |theta - theta_0|^2]``, in the metric of ``P_0^-1``."""
    rng = np.random.default_rng(seed)
    count, size, noise = 200, 5, 10.0 ** rng.uniform(-3.0, 1.0)
    rows = np.cumsum(rng.standard_normal((count, size)), axis=0) * 0.1
    outputs = np.cumsum(rng.standard_normal(count))
    first, covariance = rng.standard_normal(size), spread(rng, size)
    estimate = Estimate(np.pad(first, LOOP), packed(np.pad(covariance, LOOP)))
    total = 0.0
    for row, output in zip(rows, outputs, strict=True):
        normalised, _ = updated(estimate, np.concatenate([row, [0.0, 0.0]]), output, noise)
        total += noise * normalised**2
    root = np.linalg.inv(np.linalg.cholesky(covariance)) * math.sqrt(noise)
    stacked = np.vstack([rows, root])
    best, *_ = np.linalg.lstsq(stacked, np.concatenate([outputs, root @ first]), rcond=None)
    least = np.sum((np.concatenate([outputs, root @ first]) - stacked @ best) ** 2)
    assert total == pytest.approx(least, rel=1e-6)
    np.testing.assert_allclose(estimate.mean[LOOP:-2], best, rtol=1e-4, atol=1e-6)


INERTIA, PERIOD = 20.0, 0.01
GAINS = pi_gains(INERTIA, 10.0)


def answers(torques, delay=0.0, lag=0.0):
    """Measured velocities, rad/s, of a torque that is put in from the first sample on."""
    pi, response = check_gains(*GAINS, PERIOD, delay), initial_response(1, delay)
    followed, found = PERIOD / (PERIOD + lag), []
    for torque in torques:
        put_in(response, 0, torque)
        found.append(advance_response(response, 0, 0.0, pi, INERTIA, followed, PERIOD, True))
    return np.array(found)


def discrete_loop(delay, lag):
    z = control.tf([1.0, 0.0], [1.0], PERIOD)
    whole, part = int(delay), delay - int(delay)
    late = (1.0 - part) * z**-whole if whole else control.tf([1.0 - part], [1.0], PERIOD)
    if part:
        late = late + part * z ** -(whole + 1)
    joint = control.tf([PERIOD / INERTIA, 0.0], [1.0, -1.0], PERIOD)  # measured at the end of the period
    share = PERIOD / (PERIOD + lag)
    seen = control.tf([share, 0.0], [1.0, share - 1.0], PERIOD)
    feedback = control.tf([GAINS[0] + GAINS[1] * PERIOD, -GAINS[0]], [1.0, -1.0], PERIOD)
    forward = joint * late * seen
    return forward / (1.0 + forward * feedback * z**-1)


@pytest.mark.parametrize("lag", [0.0, 0.004])
@pytest.mark.parametrize("delay", [0.0, 1.0, 0.5, 1.5])
def test_it_is_the_response_of_the_sampled_loop(delay, lag):
    torques = np.random.default_rng(1).standard_normal(200)
    time = PERIOD * np.arange(torques.size)
    expected = control.forced_response(discrete_loop(delay, lag), time, torques).outputs
    np.testing.assert_allclose(answers(torques, delay, lag), expected, rtol=1e-8, atol=1e-10)
