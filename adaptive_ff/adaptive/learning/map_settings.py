"""Parameters of the map of friction over position and load from what a user gives."""

import math
from collections.abc import Sequence

import numpy as np

from adaptive_ff.adaptive.learning.friction_map import NO_MAP, MapParameters
from controllers import check_positive
from controllers.arrays import NDArray
from controllers.checks import checked_array

MAP_MEMORY = 1.0
"""Default memory of the map, s of sliding motion at a position."""

MAP_DEVIATION = 0.05
"""How sure a first map is where nothing else is said: standard deviation of each coefficient, a share of friction."""

MOST_PERIODS = 8
"""Most known periods: many of them take each other's part for long."""

MOST_HATS = 1000
"""Most hats: they cost memory only, but each must be visited."""


def map_parameters(
    periods: Sequence[float], hats: int, positions: Sequence[float] | None, load: float, memory: float
) -> MapParameters:
    """Return the parameters of a map.

    Parameters
    ----------
    periods : sequence of float
        Known periods, rad.
    hats : int
        Number of hats.
    positions : sequence of float or None
        Positions of the first and of the last hat, rad; from ``-pi`` to ``pi`` where there are hats and none is given.
    load : float
        Unit of the known torque, N m; zero where friction is not assumed to depend on it.
    memory : float
        Memory, s of sliding motion at a position.

    Raises
    ------
    ValueError
        A value is out of range.
    """
    lengths = checked_periods("position_periods", periods)
    if isinstance(hats, bool) or not isinstance(hats, int | np.integer) or hats == 1 or not 0 <= hats <= MOST_HATS:
        raise ValueError(
            f"position_hats = {hats} is not allowed: it must be 0, or a whole number from 2 to {MOST_HATS}"
        )
    check_positive(map_memory=memory)
    lowest, highest = _checked_range(positions)
    if hats == 0 and positions is not None:
        raise ValueError(f"position_range = {list(positions)} is not allowed without position_hats")
    if not (lengths.size or hats or load):
        return NO_MAP
    spacing = (highest - lowest) / (hats - 1) if hats else 1.0
    return MapParameters(2.0 * math.pi / lengths, int(hats), lowest, spacing, float(load), float(memory))


def checked_periods(name: str, periods: Sequence[float]) -> NDArray[np.float64]:
    """Return known periods over the position (rad), or raise ``ValueError`` that names the argument."""
    lengths = checked_array(name, periods)
    if lengths.ndim != 1 or lengths.size > MOST_PERIODS or not np.all(np.isfinite(lengths) & (lengths > 0.0)):
        shown = list(periods) if lengths.ndim == 1 else periods
        raise ValueError(f"{name} = {shown} is not allowed: at most {MOST_PERIODS} positive numbers of rad")
    return lengths


def _checked_range(positions: Sequence[float] | None) -> tuple[float, float]:
    if positions is None:
        return -math.pi, math.pi
    ends = checked_array("position_range", positions)
    if ends.shape != (2,) or not (math.isfinite(ends[0]) and ends[0] < ends[1] < math.inf):
        shown = list(positions) if ends.ndim == 1 else positions
        raise ValueError(
            f"position_range = {shown} is not allowed: it must be two finite numbers of rad, the lower first"
        )
    return float(ends[0]), float(ends[1])
