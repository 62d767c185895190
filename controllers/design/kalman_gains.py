"""Settled gains of the Kalman filters: of velocity and disturbance, and of the velocity behind an encoder."""

import math
from functools import cache

import numpy as np
import scipy
from numpy.typing import NDArray

from controllers.checks import check_positive


def stationary_gain(transition: NDArray[np.float64], process_noise: NDArray[np.float64]) -> NDArray[np.float64]:
    """Return the stationary gain of a filter that measures the first state with a variance of 1."""
    try:
        covariance = scipy.linalg.solve_discrete_are(transition.T, np.eye(len(transition), 1), process_noise, np.eye(1))
    except np.linalg.LinAlgError as error:
        raise ValueError(f"process noise and that of the measurement are too far apart: {error}") from error
    return np.asarray(covariance[:, 0] / (covariance[0, 0] + 1.0))


@cache
def scaled_disturbance_gains(angle: float) -> tuple[float, float]:
    """Return the settled gains for an inertia and a period of 1 and a bandwidth in radians a sample."""
    transition = np.array([[1.0, -1.0], [0.0, 1.0]])
    # a random walk of unit intensity over a period, and what it adds to the velocity
    walk = np.array([[1.0 / 3.0, -0.5], [-0.5, 1.0]])
    gain = stationary_gain(transition, angle**4 * walk)
    return float(gain[0]), -float(gain[1])


def kalman_disturbance_gains(
    inertia: float, period: float, velocity_noise: float, disturbance_walk: float
) -> tuple[float, float]:
    """Return the settled gains of the filter of :class:`controllers.KalmanDisturbance`.

    Parameters
    ----------
    inertia : float
        Assumed inertia, kg m^2.
    period : float
        Sampling period, s.
    velocity_noise : float
        Standard deviation of the measured velocity, rad/s.
    disturbance_walk : float
        Intensity of the random walk of the disturbance, N m/sqrt(s).

    Returns
    -------
    velocity_gain : float
        Share of the innovation that goes to the velocity.
    disturbance_gain : float
        Torque that the disturbance loses for each unit of innovation, N m s/rad.

    Raises
    ------
    ValueError
        A value is not positive and finite, or the walk is too far from the noise.
    """
    check_positive(inertia=inertia, period=period, velocity_noise=velocity_noise, disturbance_walk=disturbance_walk)
    angle = math.sqrt(disturbance_walk * period**1.5 / (inertia * velocity_noise))
    velocity_gain, disturbance_gain = scaled_disturbance_gains(angle)
    return velocity_gain, disturbance_gain * inertia / period


@cache
def _scaled_velocity_gains(index: float) -> tuple[float, float, float]:
    """Return the settled gains for a period and a position noise of 1 and a walk of the acceleration."""
    transition = np.array([[1.0, 1.0, 0.5], [0.0, 1.0, 1.0], [0.0, 0.0, 1.0]])
    # what white jerk of unit intensity adds over a period
    walk = np.array([[1.0 / 20.0, 1.0 / 8.0, 1.0 / 6.0], [1.0 / 8.0, 1.0 / 3.0, 0.5], [1.0 / 6.0, 0.5, 1.0]])
    gain = stationary_gain(transition, index**2 * walk)
    return float(gain[0]), float(gain[1]), float(gain[2])


def kalman_velocity_gains(position_noise: float, acceleration_walk: float, period: float) -> tuple[float, float, float]:
    """Return the settled gains for :func:`controllers.kalman_velocity`.

    Parameters
    ----------
    position_noise : float
        Standard deviation of the measured position, rad; for an encoder its resolution over ``sqrt(12)``.
    acceleration_walk : float
        Intensity of the random walk of the acceleration, rad/s^2 in a root of a second.
    period : float
        Sampling period, s.

    Returns
    -------
    position_gain, velocity_gain, acceleration_gain : float
        Shares of the innovation that go to position, velocity (1/s) and acceleration (1/s^2).

    Raises
    ------
    ValueError
        A value is not positive and finite, or the walk is too far from the noise.
    """
    check_positive(position_noise=position_noise, acceleration_walk=acceleration_walk, period=period)
    gains = _scaled_velocity_gains(acceleration_walk * period**2.5 / position_noise)
    return gains[0], gains[1] / period, gains[2] / period**2
