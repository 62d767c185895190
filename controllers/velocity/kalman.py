"""Velocity by a Kalman filter on the position.

R. E. Kalman, "A new approach to linear filtering and prediction problems" (1960), for a joint whose acceleration is a
random walk in continuous time (white jerk), sampled exactly. Such a filter does not lag behind a constant acceleration.
The settled gains are those of the nominal period; where the real one differs, the prediction takes the real one and the
gains stay. Over lost measurements the filter predicts.
"""

import math
from functools import cache
from typing import NamedTuple

import numpy as np
from numba.extending import register_jitable

from controllers.checks import check_positive
from controllers.design.stationary import stationary_gain
from controllers.velocity.estimators import INITIAL_VELOCITY_STATES, VELOCITY_ESTIMATORS


class KalmanVelocity(NamedTuple):
    """Kalman filter on the position.

    Attributes
    ----------
    position_gain : float
        Share of the innovation that goes to the position.
    velocity_gain : float
        Share that goes to the velocity, 1/s.
    acceleration_gain : float
        Share that goes to the acceleration, 1/s^2.
    period : float
        Nominal sampling period, s.
    """

    position_gain: float
    velocity_gain: float
    acceleration_gain: float
    period: float


class KalmanVelocityState(NamedTuple):
    """What the filter believes of the joint.

    Attributes
    ----------
    position : float
        Position, rad.
    velocity : float
        Velocity, rad/s.
    acceleration : float
        Acceleration, rad/s^2.
    """

    position: float
    velocity: float
    acceleration: float


def _initial_kalman(block: KalmanVelocity, position: float, velocity: float) -> KalmanVelocityState:
    return KalmanVelocityState(position - velocity * block.period, velocity, 0.0)


@register_jitable
def follow_positions(
    block: KalmanVelocity, state: KalmanVelocityState, measurement: float, dt: float
) -> tuple[float, KalmanVelocityState]:
    """Predict over the time that has passed, and correct by a position (rad)."""
    position = state.position + dt * (state.velocity + 0.5 * dt * state.acceleration)
    velocity = state.velocity + dt * state.acceleration
    if not math.isfinite(measurement):
        return math.nan, KalmanVelocityState(position, velocity, state.acceleration)
    innovation = measurement - position
    velocity += block.velocity_gain * innovation
    return velocity, KalmanVelocityState(
        position + block.position_gain * innovation,
        velocity,
        state.acceleration + block.acceleration_gain * innovation,
    )


VELOCITY_ESTIMATORS[KalmanVelocity] = follow_positions
INITIAL_VELOCITY_STATES[KalmanVelocity] = _initial_kalman


@cache
def _gains(index: float) -> tuple[float, float, float]:
    """Return the settled gains for a period and a position noise of 1 and a walk of the acceleration."""
    transition = np.array([[1.0, 1.0, 0.5], [0.0, 1.0, 1.0], [0.0, 0.0, 1.0]])
    # what white jerk of unit intensity adds over a period
    walk = np.array([[1.0 / 20.0, 1.0 / 8.0, 1.0 / 6.0], [1.0 / 8.0, 1.0 / 3.0, 0.5], [1.0 / 6.0, 0.5, 1.0]])
    gain = stationary_gain(transition, index**2 * walk)
    return float(gain[0]), float(gain[1]), float(gain[2])


def kalman_velocity(position_noise: float, acceleration_walk: float, period: float) -> KalmanVelocity:
    """Return the estimator by a Kalman filter.

    Parameters
    ----------
    position_noise : float
        Standard deviation of the measured position, rad; for an encoder its resolution over ``sqrt(12)``.
    acceleration_walk : float
        Intensity of the random walk of the acceleration, rad/s^2 in a root of a second.
    period : float
        Nominal sampling period, s.

    Raises
    ------
    ValueError
        A value is not positive.
    """
    check_positive(position_noise=position_noise, acceleration_walk=acceleration_walk, period=period)
    gains = _gains(acceleration_walk * period**2.5 / position_noise)
    return KalmanVelocity(gains[0], gains[1] / period, gains[2] / period**2, float(period))
