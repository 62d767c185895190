"""Velocity from what a sensor gives."""

from collections.abc import Callable
from typing import Any, NamedTuple

from numba.extending import register_jitable

from controllers.compiled import dispatched


class DirectVelocity(NamedTuple):
    """The measurement is a velocity already."""

    unused: float


@register_jitable
def take_velocity(block: DirectVelocity, state: float, measurement: float, dt: float) -> tuple[float, float]:
    """Return the measurement."""
    return measurement, state


VELOCITY_ESTIMATORS: dict[type, Callable[..., Any]] = {DirectVelocity: take_velocity}


def _estimate(block: Any, state: Any, measurement: float, dt: float) -> Any:
    return VELOCITY_ESTIMATORS[type(block)](block, state, measurement, dt)


estimate_velocity = dispatched(VELOCITY_ESTIMATORS, _estimate)


def initial_velocity(block: Any, position: float, velocity: float) -> Any:
    """Return the first state."""
    return 0.0
