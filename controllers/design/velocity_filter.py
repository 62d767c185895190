"""What a velocity made of positions is of the true one: a filter ``F``, for the design of loops.

Between samples the torque is held and a joint accelerates evenly: the difference of two positions is the mean of the
velocities at the two, ``(1 + q)/2`` with ``q = z^-1``; a low-pass and a Kalman filter come on top of it. That positions
are rounded is left out.
"""

import math
from typing import Any, NamedTuple

import numpy as np
import scipy
from numpy.typing import NDArray

from controllers.velocity import DifferenceVelocity, DirectVelocity, KalmanVelocity, LowPassVelocity


class VelocityFilter(NamedTuple):
    """A filter ``F`` of the velocity as polynomials in ``q = z^-1``, falling powers."""

    numerator: tuple[float, ...]  # the polynomials
    denominator: tuple[float, ...]


NO_FILTER = VelocityFilter((1.0,), (1.0,))
"""That of a velocity that is measured itself."""


def filter_of(estimator: Any) -> VelocityFilter:
    """Return the filter of an estimator of :mod:`controllers.velocity`; None is a velocity that is measured itself."""
    match estimator:
        case None | DirectVelocity():
            return NO_FILTER
        case DifferenceVelocity():
            return VelocityFilter((0.5, 0.5), (1.0,))
        case LowPassVelocity(pole, period):
            fraction = -math.expm1(-pole * period)
            return VelocityFilter((0.5 * fraction, 0.5 * fraction), (fraction - 1.0, 1.0))
        case KalmanVelocity():
            return _kalman_filter(estimator)
    raise TypeError(f"velocity = {estimator!r} is not allowed: it must be an estimator of controllers.velocity")


def in_z(filter_of_velocity: VelocityFilter) -> tuple[NDArray[Any], NDArray[Any]]:
    """Return numerator and denominator of a filter in falling powers of ``z``."""
    size = max(map(len, filter_of_velocity))  # powers of z^-1 rise where those of z fall
    above, below = (np.pad(polynomial, (size - len(polynomial), 0))[::-1] for polynomial in filter_of_velocity)
    return above, below


def noise_of_positions(estimator: Any, period: float) -> float:
    """Return the noise of a velocity over that of the positions, 1/s: standard deviations, of independent errors.

    It is the H2 norm of the filter behind a difference of positions.
    """
    above, below = in_z(filter_of(estimator))
    response = 2.0 / period * np.convolve(np.polydiv(above, [1.0, 1.0])[0], [1.0, -1.0])
    first = np.eye(below.size - 1, 1)
    covariance = scipy.linalg.solve_discrete_lyapunov(scipy.linalg.companion(below), first @ first.T)
    later = response[1:] - response[0] * below[1:]
    return math.sqrt(response[0] ** 2 + later @ covariance @ later)


def _kalman_filter(estimator: KalmanVelocity) -> VelocityFilter:
    period = estimator.period
    transition = np.array([[1.0, period, 0.5 * period**2], [0.0, 1.0, period], [0.0, 0.0, 1.0]])
    gain = np.array([estimator.position_gain, estimator.velocity_gain, estimator.acceleration_gain])
    closed = transition - np.outer(gain, transition[0])
    characteristic = np.poly(closed)
    # the velocity row of z (z I - closed)^-1 gain, over the position (T/2)(z + 1)/(z - 1) of a velocity
    fed = np.outer(gain, [0.0, 1.0, 0.0])
    from_position = np.poly(closed - fed) - characteristic
    without_integrator, _ = np.polydiv(np.append(from_position[1:], 0.0), [1.0, -1.0])
    numerator = 0.5 * period * np.convolve(without_integrator, [1.0, 1.0])
    padded = np.pad(numerator, (characteristic.size - numerator.size, 0))
    return VelocityFilter(tuple(padded[::-1].tolist()), tuple(characteristic[::-1].tolist()))
