"""Velocity as the difference of two positions over the time between them.

For an encoder of resolution ``r`` that passes many steps in a period, the two rounding errors are independent, with a
variance of ``r^2/12`` each: the velocity has a noise of ``r/(sqrt(6) Ts)``. It lags half a period behind.
"""

import math
from typing import NamedTuple

from numba.extending import register_jitable

from controllers.checks import check_positive
from controllers.velocity.estimators import INITIAL_VELOCITY_STATES, VELOCITY_ESTIMATORS


class DifferenceVelocity(NamedTuple):
    """Difference of positions.

    Attributes
    ----------
    period : float
        Nominal sampling period, s; only the state at the start depends on it.
    """

    period: float


class DifferenceState(NamedTuple):
    """State of a difference.

    Attributes
    ----------
    position : float
        Last valid position, rad.
    elapsed : float
        Time from there to the last sample, s.
    """

    position: float
    elapsed: float


def _initial_difference(block: DifferenceVelocity, position: float, velocity: float) -> DifferenceState:
    return DifferenceState(position - velocity * block.period, 0.0)


@register_jitable
def difference_positions(
    block: DifferenceVelocity, state: DifferenceState, measurement: float, dt: float
) -> tuple[float, DifferenceState]:
    """Return the mean velocity (rad/s) since the last valid position."""
    elapsed = state.elapsed + dt
    if not math.isfinite(measurement):
        return math.nan, DifferenceState(state.position, elapsed)
    return (measurement - state.position) / elapsed, DifferenceState(measurement, 0.0)


VELOCITY_ESTIMATORS[DifferenceVelocity] = difference_positions
INITIAL_VELOCITY_STATES[DifferenceVelocity] = _initial_difference


def difference_velocity(period: float) -> DifferenceVelocity:
    """Return the estimator by differences for a nominal period in s.

    Raises
    ------
    ValueError
        The period is not positive.
    """
    check_positive(period=period)
    return DifferenceVelocity(float(period))
