"""Velocity as a difference of positions behind a low-pass of first order.

The difference is the mean velocity since the last position; taken as constant over that time, it makes the low-pass
``wc/(s + wc)`` exact for whatever time has passed.
"""

import math
from typing import NamedTuple

from numba.extending import register_jitable

from controllers.checks import check_positive
from controllers.velocity.estimators import INITIAL_VELOCITY_STATES, VELOCITY_ESTIMATORS


class LowPassVelocity(NamedTuple):
    """Difference of positions behind a low-pass.

    Attributes
    ----------
    pole : float
        Pole ``wc``, rad/s.
    period : float
        Nominal sampling period, s; only the state at the start depends on it.
    """

    pole: float
    period: float


class LowPassState(NamedTuple):
    """State of a difference behind a low-pass.

    Attributes
    ----------
    position : float
        Last valid position, rad.
    elapsed : float
        Time from there to the last sample, s.
    velocity : float
        Velocity behind the low-pass, rad/s.
    """

    position: float
    elapsed: float
    velocity: float


def _initial_low_pass(block: LowPassVelocity, position: float, velocity: float) -> LowPassState:
    return LowPassState(position - velocity * block.period, 0.0, velocity)


@register_jitable
def filter_positions(
    block: LowPassVelocity, state: LowPassState, measurement: float, dt: float
) -> tuple[float, LowPassState]:
    """Return the velocity (rad/s) behind the low-pass."""
    elapsed = state.elapsed + dt
    if not math.isfinite(measurement):
        return math.nan, LowPassState(state.position, elapsed, state.velocity)
    mean = (measurement - state.position) / elapsed
    velocity = state.velocity - math.expm1(-block.pole * elapsed) * (mean - state.velocity)
    return velocity, LowPassState(measurement, 0.0, velocity)


VELOCITY_ESTIMATORS[LowPassVelocity] = filter_positions
INITIAL_VELOCITY_STATES[LowPassVelocity] = _initial_low_pass


def low_pass_velocity(cutoff: float, period: float) -> LowPassVelocity:
    """Return the estimator by filtered differences.

    Parameters
    ----------
    cutoff : float
        Corner frequency of the low-pass, Hz.
    period : float
        Nominal sampling period, s.

    Raises
    ------
    ValueError
        A value is not positive.
    """
    check_positive(cutoff=cutoff, period=period)
    return LowPassVelocity(2.0 * math.pi * float(cutoff), float(period))


def low_pass_lag(cutoff: float, period: float) -> float:
    """Return by how much such a velocity lags behind that of a joint that accelerates evenly, s.

    Half a period of the difference, and ``Ts k/(1 - k)`` of the low-pass with ``k = exp(-wc Ts)``: less than the
    ``1/wc`` of one in continuous time, as each difference counts as if it had been there for all of its period.

    Parameters
    ----------
    cutoff : float
        Corner frequency of the low-pass, Hz.
    period : float
        Sampling period, s.
    """
    check_positive(cutoff=cutoff, period=period)
    return period * (0.5 + 1.0 / math.expm1(2.0 * math.pi * cutoff * period))
