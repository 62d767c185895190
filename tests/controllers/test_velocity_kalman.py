import math

import numpy as np
import pytest
from filterpy.common import Q_continuous_white_noise
from filterpy.kalman import KalmanFilter
from scipy.linalg import solve_discrete_are
from velocity_runs import PERIOD, estimate, run_compiled

from controllers import kalman_velocity, kalman_velocity_gains

NOISE, WALK = 1e-4, 300.0


def make_kalman(noise=NOISE, walk=WALK, period=PERIOD):
    return kalman_velocity(*kalman_velocity_gains(noise, walk, period), period)


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
