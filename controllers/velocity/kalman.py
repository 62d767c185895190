"""Velocity by a Kalman filter on the position.

R. E. Kalman, "A new approach to linear filtering and prediction problems" (1960), for a joint whose acceleration is a
random walk in continuous time (white jerk), sampled exactly. Such a filter does not lag behind a constant acceleration.
The gains are the settled ones of the nominal period; where the real one differs, the prediction takes the real one and
the gains stay. Over lost measurements the filter predicts.
"""

import math
from typing import NamedTuple

from numba.extending import register_jitable

from controllers.checks import check_positive
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
    """Estimated motion of the joint.

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


def kalman_velocity(
    position_gain: float, velocity_gain: float, acceleration_gain: float, period: float
) -> KalmanVelocity:
    """Return the estimator by a Kalman filter.

    Parameters
    ----------
    position_gain, velocity_gain, acceleration_gain : float
        Settled shares of the innovation that go to position (at most 1), velocity (1/s) and acceleration (1/s^2), as
        :func:`controllers.kalman_velocity_gains` computes them.
    period : float
        Nominal sampling period, s.

    Raises
    ------
    ValueError
        A value is not positive, or the position's share above 1.
    """
    check_positive(
        position_gain=position_gain, velocity_gain=velocity_gain, acceleration_gain=acceleration_gain, period=period
    )
    if position_gain > 1.0:
        raise ValueError(f"position_gain = {position_gain} is not allowed: it must be at most 1")
    return KalmanVelocity(float(position_gain), float(velocity_gain), float(acceleration_gain), float(period))
