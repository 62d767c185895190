"""Velocity from what a sensor measures.

An estimator is a named tuple of parameters; its kernel, registered in ``VELOCITY_ESTIMATORS``, turns a measurement and
the real time since the last one into a velocity. A measurement that is not finite gives "not a number", which
controllers count and skip, and leaves the state such that the next valid one is used to the full.
"""

import math
from collections.abc import Callable
from typing import Any, NamedTuple

from numba.extending import register_jitable

from controllers.checks import check_finite, check_positive
from controllers.compiled import dispatched

VELOCITY_ESTIMATORS: dict[type, Callable[..., Any]] = {}
"""Kernel of each class of estimator: ``estimate(block, state, measurement, dt) -> (velocity, state)``."""

INITIAL_VELOCITY_STATES: dict[type, Callable[..., Any]] = {}
"""State of each class of estimator before its first sample: ``initial(block, position, velocity)``."""


def _estimate_velocity(block: Any, state: Any, measurement: float, dt: float) -> Any:
    """Do one sample of any velocity estimator, compiled or not.

    Parameters
    ----------
    block, state : NamedTuple
        The estimator, of a class that ``VELOCITY_ESTIMATORS`` knows, and its state.
    measurement : float
        Measured position, rad, or velocity, rad/s, as the estimator takes it.
    dt : float
        Time since the last sample, s.

    Returns
    -------
    velocity : float
        Estimated velocity, rad/s.
    state : NamedTuple
        The new state.
    """
    return VELOCITY_ESTIMATORS[type(block)](block, state, measurement, dt)


estimate_velocity = dispatched(VELOCITY_ESTIMATORS, _estimate_velocity)


def initial_velocity_state(block: Any, position: float, velocity: float = 0.0) -> Any:
    """Return the state of an estimator one nominal period before its first sample.

    Parameters
    ----------
    block : NamedTuple
        The estimator.
    position : float
        Position that the first sample will measure, rad.
    velocity : float, optional
        Velocity at which the joint comes there, rad/s.

    Raises
    ------
    ValueError
        A value is not finite.
    TypeError
        A value is no number, or the estimator is of no known class.
    """
    check_finite(position=position, velocity=velocity)
    if type(block) not in INITIAL_VELOCITY_STATES:
        raise TypeError(f"block = {block!r} is not allowed: it must be an estimator of controllers.velocity")
    return INITIAL_VELOCITY_STATES[type(block)](block, float(position), float(velocity))


class DirectVelocity(NamedTuple):
    """The measurement is a velocity already, and is passed on.

    Attributes
    ----------
    period : float
        Nominal sampling period, s; of no consequence.
    """

    period: float


class DirectVelocityState(NamedTuple):
    """State of a velocity that is passed on.

    Attributes
    ----------
    velocity : float
        Last valid velocity, rad/s.
    """

    velocity: float


def _initial_direct(block: DirectVelocity, position: float, velocity: float) -> DirectVelocityState:
    return DirectVelocityState(velocity)


@register_jitable
def pass_velocity(
    block: DirectVelocity, state: DirectVelocityState, measurement: float, dt: float
) -> tuple[float, DirectVelocityState]:
    """Pass a measured velocity (rad/s) on."""
    if not math.isfinite(measurement):
        return math.nan, state
    return measurement, DirectVelocityState(measurement)


VELOCITY_ESTIMATORS[DirectVelocity] = pass_velocity
INITIAL_VELOCITY_STATES[DirectVelocity] = _initial_direct


def direct_velocity(period: float) -> DirectVelocity:
    """Return the estimator for a sensor of velocity and a nominal period in s."""
    check_positive(period=period)
    return DirectVelocity(float(period))
