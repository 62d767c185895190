"""Whether a torque of some rows, far outside the range of all others, was felt by the joint.

A drive may really give a torque for a row or two, as where a reference jumps and the controller differentiates it. The
velocity of the joint then changes by the impulse over the inertia. A torque that only the recorder saw changes nothing.
"""

import numpy as np
from numpy.typing import NDArray

from adaptive_ff.logs.log import Array

ROWS = 5
"""Rows before and after, over which the velocity is a mean: noise of an encoder falls, and a torque may be late."""

PLACES = 20_000
"""Most places of a log at which change of velocity and torque are compared."""

USUAL, FELT = 0.9, 3.0
"""Change of velocity that the usual torque does not explain, over that of nearly all other places, from which on a
torque was felt."""


def were_felt(
    motion: Array, torque: Array, rows: NDArray[np.int64], width: int, *, is_position: bool, range_: tuple[float, float]
) -> NDArray[np.bool_]:
    """Tell which of the torques that begin in some rows the joint felt; none where that cannot be told.

    The change of the velocity in the midst of ``2 ROWS`` rows is regressed on the sum of the torque over them, the
    direction and a constant, with the torque within its usual range; so a torque of the other sign is as good.

    Parameters
    ----------
    motion, torque : ndarray, shape (n,)
        Position or velocity, and torque.
    rows : ndarray of int
        First row of each torque that is far outside the range.
    width : int
        Rows that it takes.
    is_position : bool
        Whether the motion is a position.
    range_ : tuple of float
        The usual range of the torque.
    """
    size, span = motion.size, ROWS + 1 if is_position else ROWS
    usual = np.clip(torque, *range_)
    felt = np.zeros(rows.size, dtype=np.bool_)
    inside = (rows >= span) & (rows + width + span <= size)
    rows = rows[inside]
    places = np.arange(span, size - width - span, max(1, size // PLACES))
    if places.size < 4 or not rows.size:
        return felt
    columns, changes = _regressed(motion, usual, places, width, is_position=is_position)
    known = np.isfinite(changes) & np.all(np.isfinite(columns), axis=1)
    if np.count_nonzero(known) < 4:
        return felt
    coefficients = np.linalg.lstsq(columns[known], changes[known])[0]
    unexplained = float(np.quantile(np.abs(changes[known] - columns[known] @ coefficients), USUAL))
    columns, changes = _regressed(motion, usual, rows, width, is_position=is_position)
    along = np.sign(coefficients[0] * (torque[rows] - usual[rows]))
    felt[inside] = along * (changes - columns @ coefficients) > FELT * unexplained
    return felt


def _regressed(
    motion: Array, torque: Array, rows: NDArray[np.int64], width: int, *, is_position: bool
) -> tuple[Array, Array]:
    """Return what the change of the velocity depends on, and the change, at some rows."""
    behind = rows + width
    if is_position:
        before = (motion[rows - 1] - motion[rows - 1 - ROWS]) / ROWS
        after = (motion[behind + ROWS] - motion[behind]) / ROWS
    else:
        before = np.mean([motion[rows - 1 - place] for place in range(ROWS)], axis=0)
        after = np.mean([motion[behind + place] for place in range(ROWS)], axis=0)
    sums = np.sum([torque[rows + place] for place in range(-ROWS, width + ROWS)], axis=0)
    return np.column_stack([sums, np.sign(before + after), np.ones(rows.size)]), after - before
