"""Velocities made of measurements, and the Kalman filter among what makes them."""

import math

import numpy as np
import pytest
from filterpy.common import Q_continuous_white_noise
from filterpy.kalman import KalmanFilter
from scipy.linalg import solve_discrete_are

import controllers

PERIOD = 0.001
RESOLUTION = 2.0 * np.pi / 20_000

ON_POSITIONS = {
    "difference": controllers.difference_velocity(PERIOD),
    "low-pass": controllers.low_pass_velocity(40.0, PERIOD),
    "Kalman": controllers.kalman_velocity(
        *controllers.kalman_velocity_gains(RESOLUTION / np.sqrt(12.0), 200.0, PERIOD), PERIOD
    ),
}
ESTIMATORS = {"direct": controllers.direct_velocity(PERIOD), **ON_POSITIONS}


def run_plain(block, state, measured, dt, velocities):
    for k in range(measured.size):
        velocities[k], state = controllers.estimate_velocity(block, state, measured[k], dt[k])
    return state


run_compiled = controllers.compiled(run_plain)


def estimate(block, measured, *, dt=PERIOD, velocity=0.0, run=run_plain):
    """Velocity at each sample, and the state at the end; ``dt`` is the time before each sample."""
    measured = np.asarray(measured, dtype=float)
    found = np.zeros(measured.size)
    first = measured[np.isfinite(measured)][0]
    state = controllers.initial_velocity_state(block, first, velocity)
    state = run(block, state, measured, np.broadcast_to(dt, measured.size).copy(), found)
    return found, state


every = pytest.mark.parametrize("block", ESTIMATORS.values(), ids=ESTIMATORS)
on_positions = pytest.mark.parametrize("block", ON_POSITIONS.values(), ids=ON_POSITIONS)


def encoder(position):
    return RESOLUTION * np.round(np.asarray(position) / RESOLUTION)


def test_every_estimator_is_tested():
    assert {type(block) for block in ESTIMATORS.values()} == set(controllers.VELOCITY_ESTIMATORS)


@every
def test_compiled_run_is_plain_python_bit_for_bit(block):
    generator = np.random.default_rng(1)
    dt = PERIOD * generator.uniform(0.5, 1.5, 3000)
    measured = encoder(0.3 * np.sin(4.0 * np.cumsum(dt)))
    measured[generator.integers(1, 3000, 100)] = math.nan
    found, state = estimate(block, measured, dt=dt, velocity=1.2)
    again, same_state = estimate(block, measured, dt=dt, velocity=1.2, run=run_compiled)
    assert np.array_equal(found, again, equal_nan=True)
    assert state == same_state
    assert np.count_nonzero(np.isfinite(found)) > 2850


@on_positions
@pytest.mark.parametrize("velocity", [0.0, 0.35, -2.0])
def test_constant_velocity_is_exact_from_the_first_sample_whatever_the_periods(block, velocity):
    dt = PERIOD * np.random.default_rng(2).uniform(0.5, 1.5, 500)
    dt[0] = PERIOD
    position = 0.7 + velocity * (np.cumsum(dt) - dt[0])
    found, _ = estimate(block, position, dt=dt, velocity=velocity)
    assert found == pytest.approx(np.full(500, velocity), abs=1e-10)


@on_positions
@pytest.mark.parametrize("lost", [math.nan, math.inf, -math.inf], ids=str)
def test_lost_positions_are_passed_on_and_spoil_nothing(block, lost):
    position = 0.35 * PERIOD * np.arange(400)
    gaps = [3, 50, 51, 52, 53, 200]
    measured = position.copy()
    measured[gaps] = lost
    found, _ = estimate(block, measured, velocity=0.35)
    assert np.all(np.isnan(found[gaps]))
    assert np.delete(found, gaps) == pytest.approx(np.full(400 - len(gaps), 0.35), abs=1e-10)
    np.testing.assert_array_equal(estimate(ESTIMATORS["direct"], [0.1, lost, 0.2])[0], [0.1, math.nan, 0.2])


@pytest.mark.parametrize("jitter", [0.0, 0.6])
def test_low_pass_answers_a_step_with_one_exponential_in_real_time(jitter):
    dt = PERIOD * (1.0 + jitter * np.random.default_rng(3).uniform(-1.0, 1.0, 200))
    position = np.concatenate([[0.0], 0.5 * np.cumsum(dt[1:])])
    found, _ = estimate(controllers.low_pass_velocity(40.0, PERIOD), position, dt=dt)
    time = np.concatenate([[0.0], np.cumsum(dt[1:])])
    assert found == pytest.approx(0.5 * -np.expm1(-2.0 * math.pi * 40.0 * time), abs=1e-12)


@pytest.mark.parametrize("period", [0.01, 0.002, 0.0005])
def test_lag_is_that_behind_a_joint_that_accelerates_evenly(period):
    time = period * np.arange(4000)
    found, _ = estimate(controllers.low_pass_velocity(50.0, period), 0.5 * 3.0 * time**2, dt=np.full(time.size, period))
    assert time[-1] - found[-1] / 3.0 == pytest.approx(controllers.low_pass_lag(50.0, period), rel=1e-7)


def quantisation_noise(block, samples=200_000):
    """Noise that the encoder adds: estimate from quantised minus estimate from exact positions."""
    time = PERIOD * np.arange(samples)
    position = 3.0 * time + 0.2 * np.sin(1.3 * time)  # many steps a period
    rounded, _ = estimate(block, encoder(position), velocity=3.26, run=run_compiled)
    exact, _ = estimate(block, position, velocity=3.26, run=run_compiled)
    return (rounded - exact)[1000:]


def test_noise_of_a_difference_is_the_resolution_over_the_period_and_the_root_of_six():
    noise = quantisation_noise(controllers.difference_velocity(PERIOD))
    assert np.std(noise) == pytest.approx(RESOLUTION / (PERIOD * math.sqrt(6.0)), rel=0.03)


def test_low_pass_leaves_the_noise_that_its_pole_predicts():
    """White rounding errors through ``(1 - a)(1 - 1/z)/(1 - a/z)``: ``2 (1 - a)^2/(1 + a)`` of the variance of one."""
    noise = quantisation_noise(controllers.low_pass_velocity(40.0, PERIOD))
    kept = math.exp(-2.0 * math.pi * 40.0 * PERIOD)
    variance = RESOLUTION**2 / 12.0 / PERIOD**2 * 2.0 * (1.0 - kept) ** 2 / (1.0 + kept)
    assert np.std(noise) == pytest.approx(math.sqrt(variance), rel=0.03)


NOISE, WALK = 1e-4, 300.0


def make_kalman(noise=NOISE, walk=WALK, period=PERIOD):
    return controllers.kalman_velocity(*controllers.kalman_velocity_gains(noise, walk, period), period)


def settled_filterpy(noise=NOISE, walk=WALK, period=PERIOD):
    """Constant acceleration with white jerk, as filterpy has it, run until its gain stands."""
    kalman = KalmanFilter(dim_x=3, dim_z=1)
    kalman.F = np.array([[1.0, period, 0.5 * period**2], [0.0, 1.0, period], [0.0, 0.0, 1.0]])
    kalman.H, kalman.R = np.array([[1.0, 0.0, 0.0]]), np.array([[noise**2]])
    kalman.Q = Q_continuous_white_noise(3, period, walk**2)
    kalman.P = np.diag([noise**2, 1.0, 1e3])
    for _ in range(5000):
        kalman.predict()
        kalman.update(0.0)
    return kalman


@pytest.mark.parametrize(("noise", "walk", "period"), [(1e-4, 300.0, 0.001), (1e-3, 20.0, 0.01), (1e-5, 1e4, 0.001)])
def test_gains_are_those_at_which_filterpy_settles_and_solve_scipys_riccati_equation(noise, walk, period):
    block, kalman = make_kalman(noise, walk, period), settled_filterpy(noise, walk, period)
    found = np.array([block.position_gain, block.velocity_gain, block.acceleration_gain])
    assert found == pytest.approx(kalman.K[:, 0], rel=1e-8)
    units = np.array([noise, noise / period, noise / period**2])  # without units, for scipy's sake
    transition, added = kalman.F / units[:, None] * units, kalman.Q / np.outer(units, units)
    covariance = solve_discrete_are(transition.T, np.array([[1.0], [0.0], [0.0]]), added, np.eye(1))
    assert found == pytest.approx(covariance[:, 0] / (covariance[0, 0] + 1.0) * units / noise, rel=1e-6)


def test_velocities_are_those_of_settled_filterpy_step_by_step():
    kalman = settled_filterpy()
    generator = np.random.default_rng(4)
    position = 0.3 * np.sin(5.0 * PERIOD * np.arange(500)) + NOISE * generator.standard_normal(500)
    found, _ = estimate(make_kalman(), position, velocity=1.5)
    kalman.x = np.array([[position[0] - 1.5 * PERIOD], [1.5], [0.0]])
    expected = []
    for measured in position:
        kalman.predict()
        kalman.update(measured)
        expected.append(kalman.x[1, 0])
    assert found == pytest.approx(np.array(expected), rel=1e-8)


def test_noise_of_the_velocity_is_the_one_that_the_covariance_predicts():
    """On the motion that it assumes: acceleration a random walk, white noise on the position."""
    kalman, generator, samples = settled_filterpy(), np.random.default_rng(5), 60_000
    steps = generator.multivariate_normal(np.zeros(3), kalman.Q, size=samples, method="svd")
    state, states = np.zeros(3), np.zeros((samples, 3))
    for k in range(1, samples):
        state = kalman.F @ state + steps[k]
        states[k] = state
    measured = states[:, 0] + NOISE * generator.standard_normal(samples)
    found, _ = estimate(make_kalman(), measured, run=run_compiled)
    error = (found - states[:, 1])[1000:]
    assert np.std(error) == pytest.approx(math.sqrt(kalman.P[1, 1]), rel=0.03)
