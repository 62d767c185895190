"""What a controller has learnt of friction over position and load, for people and pictures."""

import math
from collections.abc import Sequence
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from adaptive_ff.adaptive.learning.friction_map import (
    LARGEST_COEFFICIENT,
    MapParameters,
    MapState,
    limited_factor,
    map_value,
)

POINTS = 400
"""Positions at which a map is read."""

LEAST_UNLOADED = 0.1
"""Least friction without a known torque, over that at its mean, that a rise is told against."""


class LearntMap(NamedTuple):
    """A learnt map as it is fed.

    Attributes
    ----------
    position : ndarray, shape (m,)
        Positions, rad: where there are hats, from the first to the last that was visited, else one of the longest
        period; none where friction may depend on the load alone.
    factor : ndarray, shape (m,)
        Friction there over its mean.
    share : float
        Share of the map that is fed, from 0 to 1.
    periods : tuple of float
        Known periods, rad.
    load_share : float
        Share of the friction without a load by which it rises for each N m of known torque, 1/(N m).
    """

    position: NDArray[np.float64]
    factor: NDArray[np.float64]
    share: float
    periods: tuple[float, ...]
    load_share: float


def read_map(parameters: MapParameters, state: MapState) -> LearntMap:
    """Return a map as it is fed."""
    periods = tuple((2.0 * math.pi / parameters.waves).tolist())
    positions = _positions(parameters, state)
    said = [map_value(parameters, state.coefficients, position, 0.0) for position in positions.tolist()]
    factor = np.array([limited_factor(state.share, value) for value in said])
    mean = float(np.mean(factor)) if factor.size else 1.0
    rise = state.share * float(state.coefficients[0]) / parameters.load if parameters.load > 0.0 else 0.0
    unloaded = max(1.0 - rise * state.load, LEAST_UNLOADED)
    return LearntMap(positions, factor / mean, float(state.share), periods, rise / unloaded)


def position_sentence(
    position: NDArray[np.float64], factor: NDArray[np.float64], periods: Sequence[float], unit: str = "rad"
) -> str:
    """Return where friction over its mean rises and falls, and by how much."""
    high, low = int(np.argmax(factor)), int(np.argmin(factor))
    rise, fall = 100.0 * (factor[high] - 1.0), 100.0 * (1.0 - factor[low])
    repeats = f", and repeats every {periods[0]:.3g} {unit}" if len(periods) == 1 else ""
    return (
        f"Friction depends on position: it rises by {rise:.0f} % at {position[high]:.3g} {unit} and falls by "
        f"{fall:.0f} % at {position[low]:.3g} {unit}{repeats}."
    )


def load_sentence(share: float, unit: str = "N m") -> str:
    """Return by how much friction rises with the known torque."""
    change = "rises" if share > 0.0 else "falls"
    return f"Friction {change} by {100.0 * abs(share):.2g} % for each {unit} of known torque."


def _positions(parameters: MapParameters, state: MapState) -> NDArray[np.float64]:
    """Return the positions at which a map is read, rad."""
    if parameters.hats > 0:
        visited = np.flatnonzero(state.information[-parameters.hats :])
        if visited.size:
            ends = parameters.lowest + parameters.spacing * visited[[0, -1]]
            return np.linspace(ends[0], ends[1], POINTS)
    elif parameters.waves.size:
        return np.linspace(0.0, 2.0 * math.pi / float(np.min(parameters.waves)), POINTS)
    return np.empty(0)


def check_map_state(state: MapState, largest: float) -> None:
    """Raise ``ValueError`` where a map cannot have come to a state; the largest plausible torque is in N m."""
    if min(state.age, state.seen, state.xx, state.yy, state.friction, *state.information.tolist(), 0.0) < 0.0:
        raise ValueError("state.estimator.friction_map is not allowed: times and squares must be zero or more")
    if not 0.0 <= state.share <= 1.0 or abs(state.direction) > 1.0:
        raise ValueError(f"state.estimator.friction_map.share = {state.share} is not allowed: it must be from 0 to 1")
    if np.any(np.abs([state.coefficients, state.before]) > LARGEST_COEFFICIENT):
        raise ValueError(
            f"state.estimator.friction_map.coefficients = {state.coefficients} is not allowed: from "
            f"{-LARGEST_COEFFICIENT:g} to {LARGEST_COEFFICIENT:g}"
        )
    if max(state.xx, state.yy, abs(state.xy), state.friction) > largest * largest:
        raise ValueError(
            "state.estimator.friction_map is not allowed: its torques are beyond the largest plausible one"
        )
