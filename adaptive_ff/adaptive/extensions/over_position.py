"""Columns over position: what a user gives of them, and the map of friction that they add up to."""

import math
from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from adaptive_ff.adaptive.prior import map_place
from adaptive_ff.friction.columns import COULOMB, PATHS, Hypothesis
from adaptive_ff.learning.kalman import LOOP
from controllers.arrays import NDArray
from controllers.checks import checked_array

Array = NDArray[np.float64]

MOST_PERIODS = 8
"""Most known periods: many of them take each other's part for long."""

MOST_HATS = 100
"""Most hats: each is a column of the filter."""

POINTS = 400
"""Positions at which a map is read."""


class LearntMap(NamedTuple):
    """Friction over position and load as it is learnt and fed.

    Attributes
    ----------
    position : ndarray, shape (m,)
        Positions, rad: from the first hat to the last, else one of the longest period; none where friction may depend
        on the load alone.
    factor : ndarray, shape (m,)
        Friction there over its mean.
    periods : tuple of float
        Known periods, rad.
    load_share : float
        Share of the friction without a load by which it rises for each N m of known torque, 1/(N m).
    """

    position: Array
    factor: Array
    periods: tuple[float, ...]
    load_share: float


def read_map(hypothesis: Hypothesis, mean: Array) -> LearntMap | None:
    """Return the map of friction that the states of a filter hold; None where there are no columns for one."""
    waves, hats = hypothesis.map_waves, hypothesis.hats
    if not (waves.size or hats or hypothesis.over_load):
        return None
    paths = hypothesis.distances.size
    coulomb = float(mean[LOOP + COULOMB] + mean[LOOP + PATHS : LOOP + PATHS + paths].sum())
    friction = coulomb if coulomb > 0.0 else math.inf
    position = _positions(hypothesis)
    first = LOOP + map_place(hypothesis)
    said = np.zeros(position.size)
    for i, wave in enumerate(waves.tolist()):
        said += mean[first + 2 * i] * np.sin(wave * position) + mean[first + 2 * i + 1] * np.cos(wave * position)
    first += 2 * waves.size
    if hats and position.size:
        centres = hypothesis.lowest + hypothesis.spacing * np.arange(hats)
        said += np.interp(position, centres, mean[first : first + hats])
    factor = np.maximum(1.0 + said / friction, 0.0)
    rise = float(mean[first + hats]) if hypothesis.over_load else 0.0
    average = float(factor.mean()) if position.size else 1.0
    periods = tuple((2.0 * math.pi / waves).tolist())
    return LearntMap(position, factor / (average or 1.0), periods, rise / friction)


def _positions(hypothesis: Hypothesis) -> Array:
    """Return the positions at which a map is read, rad."""
    if hypothesis.hats:
        return np.linspace(hypothesis.lowest, hypothesis.lowest + hypothesis.spacing * (hypothesis.hats - 1), POINTS)
    if hypothesis.map_waves.size:
        return np.linspace(0.0, 2.0 * math.pi / float(np.min(hypothesis.map_waves)), POINTS)
    return np.empty(0)


def checked_periods(name: str, periods: Sequence[float]) -> Array:
    """Return known periods over the position (rad), or raise ``ValueError`` that names the argument."""
    lengths = checked_array(name, periods)
    if lengths.ndim != 1 or lengths.size > MOST_PERIODS or not np.all(np.isfinite(lengths) & (lengths > 0.0)):
        shown = list(periods) if lengths.ndim == 1 else periods
        raise ValueError(f"{name} = {shown} is not allowed: at most {MOST_PERIODS} positive numbers of rad")
    return lengths


def checked_hats(hats: int, positions: Sequence[float] | None) -> tuple[int, float, float]:
    """Return number, first position and spacing (rad) of the hats, a turn about zero where no range is given."""
    if isinstance(hats, bool) or not isinstance(hats, int | np.integer) or hats == 1 or not 0 <= hats <= MOST_HATS:
        raise ValueError(
            f"position_hats = {hats} is not allowed: it must be 0, or a whole number from 2 to {MOST_HATS}"
        )
    ends = checked_array("position_range", (-math.pi, math.pi) if positions is None else positions)
    if ends.shape != (2,) or not (math.isfinite(ends[0]) and ends[0] < ends[1] < math.inf):
        shown = list(positions or ()) if ends.ndim == 1 else positions
        raise ValueError(
            f"position_range = {shown} is not allowed: it must be two finite numbers of rad, the lower first"
        )
    if hats == 0 and positions is not None:
        raise ValueError(f"position_range = {list(positions)} is not allowed without position_hats")
    return int(hats), float(ends[0]), float(ends[1] - ends[0]) / max(1, int(hats) - 1)
