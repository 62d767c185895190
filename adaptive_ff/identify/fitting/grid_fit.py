"""A model fitted to some blocks of a log on the grid of its lag and speed, and tried on others."""

import math
from collections.abc import Sequence
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from adaptive_ff.identify.fitting.grid import Grid
from adaptive_ff.identify.terms import BENT
from adaptive_ff.logs.derivatives import Array

LEAD = "friction_lead"
"""Term of a friction that leads the motion, as where the motion is recorded later than the torque."""

RIDGE = 1e-10
"""Added to the diagonal of the scaled normal equations, so that dependent columns make no exception."""


class Point(NamedTuple):
    """A model at its best point of the grid.

    Attributes
    ----------
    squares : float
        Sum of squares on the rows that were fitted, in units of that of the torque; infinite where there is no fit.
    held : float
        On the rows that were held out.
    lag, speed : float
        Friction lag, s, and speed of the bend, rad/s.
    at_end : bool
        Whether that speed is the first or last of the grid.
    """

    squares: float
    held: float
    lag: float
    speed: float
    at_end: bool


NOWHERE = Point(math.inf, math.inf, 0.0, 0.0, False)


def fit_on_grid(grid: Grid, terms: Sequence[str], fitted: NDArray[np.bool_], held: NDArray[np.bool_]) -> Point:
    """Fit a model to some blocks, and try it on the others.

    Parameters
    ----------
    grid : Grid
        The products.
    terms : sequence of str
        Linear terms, and ``friction_lag`` or ``LEAD``; at most one of them is bent.
    fitted, held : ndarray of bool, shape (blocks,)
        Blocks that are fitted, and those that are tried.
    """
    bent = [term for term in terms if term in BENT]
    straight = [grid.names.index(term) for term in terms if term in grid.names]
    ends = [[]] if not bent else [[grid.names.index(f"{bent[0]} {k}")] for k in range(grid.speeds[bent[0]].size)]
    chosen = np.array([[*straight, *end, len(grid.names) - 1] for end in ends])
    zero = grid.without_lag
    lags = slice(0 if LEAD in terms else zero, None if "friction_lag" in terms else zero + 1)
    gathered = grid.products[:, lags][:, :, chosen[:, :, np.newaxis], chosen[:, np.newaxis, :]]
    train, test = (np.tensordot(part.astype(np.float64), gathered, axes=1) for part in (fitted, held))
    size = chosen.shape[1] - 1
    matrix, vector = train[..., :size, :size] + RIDGE * np.eye(size), train[..., :size, size]
    values = np.linalg.solve(matrix, vector[..., np.newaxis])[..., 0]
    squares = train[..., size, size] - np.sum(values * vector, axis=-1)
    if bent:  # stiction is above Coulomb friction, and what saturates rises from it
        squares = np.where(values[..., -1] > 0.0, squares, np.inf)
    best = np.unravel_index(int(np.argmin(squares)), squares.shape)
    if not np.isfinite(squares[best]):
        return NOWHERE
    full = np.concatenate([values, np.full((*values.shape[:-1], 1), -1.0)], axis=-1)
    tried = np.einsum("...i,...ij,...j->...", full, test, full)
    here = tuple(int(place) for place in best)
    found, unseen = float(squares[here]), float(tried[here])
    shares = []
    for axis in (0, 1):  # beside the point of the grid, along lag and speed, the sums are parabolas
        line = tuple(slice(None) if other == axis else here[other] for other in (0, 1))
        share, weights = parabola_at(squares[line], here[axis])
        around = slice(max(0, here[axis] - 1), here[axis] + 2)
        if weights is not None:
            found += float(weights @ squares[line][around]) - float(squares[here])
            unseen += float(weights @ tried[line][around]) - float(tried[here])
        shares.append(share)
    lag = float(grid.lags[lags][here[0]] + shares[0] * (grid.lags[1] - grid.lags[0]))
    speed, at_end = 0.0, False
    if bent:
        speeds = grid.speeds[bent[0]]
        speed = float(speeds[here[1]] * (speeds[1] / speeds[0]) ** shares[1])
        at_end = here[1] in (0, speeds.size - 1)
    return Point(max(found, 0.0), max(unseen, 0.0), lag, speed, at_end)


def parabola_at(squares: Array, place: int) -> tuple[float, Array | None]:
    """Return how far beside a point of the grid a parabola has its minimum, in steps, and its weights."""
    if not 0 < place < squares.size - 1 or not np.all(np.isfinite(squares[place - 1 : place + 2])):
        return 0.0, None
    before, here, after = (float(value) for value in squares[place - 1 : place + 2])
    curvature = before - 2.0 * here + after
    share = min(max(0.5 * (before - after) / curvature, -0.5), 0.5) if curvature > 0.0 else 0.0
    return share, np.array([0.5 * share * (share - 1.0), 1.0 - share**2, 0.5 * share * (share + 1.0)])
