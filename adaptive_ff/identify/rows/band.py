"""The filters of a piece of a log: equal steps, the wide filter and the band, and how many rows are left of it."""

import math
from collections.abc import Callable
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray
from scipy.interpolate import make_interp_spline

from adaptive_ff.identify.rows.standing import Rest, at_rest, standing, with_signs_of_motion
from adaptive_ff.logs.defects import Piece, runs
from adaptive_ff.logs.derivatives import REACH, Array, differentiate, lowpass
from adaptive_ff.logs.log import Log

ROWS_PER_CYCLE = 5.0
"""Rows in a second, over the band: what passes the filters at half that frequency is below -60 dB."""

EDGE = 1.5
"""Cycles of the band that are dropped at either end of a piece."""

SHORTEST = 6.0
"""Cycles of the band that a piece must have."""

JITTER = 0.01
"""Largest deviation of the clock from a uniform one, in steps, up to which it counts as uniform."""

FINE = 1000.0
"""Rate at which columns that jump are averaged around the samples of a slower log, Hz."""


def shortest_piece(bandwidth: float, period: float) -> int:
    """Return the number of samples that a piece must have for rows to be left of it."""
    return math.ceil(SHORTEST / (bandwidth * period)) + 2 * REACH


def uniform(log: Log, piece: Piece, period: float) -> tuple[Array, Array, Array]:
    """Return time, motion and torque of a piece at equal steps; a jittered clock is undone by cubic splines."""
    part = slice(piece.start, piece.stop)
    time, motion, torque = log.time[part], log.motion[part], log.torque[part]
    start = float(time[0])
    count = round((float(time[-1]) - start) / period) + 1
    grid = start + (float(time[-1]) - start) * np.linspace(0.0, 1.0, count)
    if count == time.size and float(np.max(np.abs(time - grid))) <= JITTER * period:
        return grid, motion, torque
    elapsed = time - start
    return (
        grid,
        make_interp_spline(elapsed, motion, k=3)(grid - start),
        make_interp_spline(elapsed, torque, k=3)(grid - start),
    )


def wide_velocity(motion: Array, corner: float, period: float, *, is_position: bool) -> Array:
    """Return the velocity behind the wide filter alone, whose sign is taken; its corner is in Hz."""
    wide = lowpass(motion - motion[0] if is_position else motion, (corner,), period)
    return differentiate(wide, period) if is_position else wide


class Band(NamedTuple):
    """The filters of a piece of a log, for what is regressed: while the joint moves.

    Attributes
    ----------
    corner, bandwidth, period : float
        Corner of the wide filter and of that of the regression, Hz, and sample time, s.
    kept : slice
        Samples that become rows.
    resting : ndarray of bool, shape (n,)
        Where the joint rests.
    stands : ndarray of bool, shape (n,)
        The same with what the wide filter smears.
    stops : int
        How often it stands.
    velocity : ndarray, shape (n,)
        Velocity behind the wide filter, rad/s; next to nothing, with the sign of the motion, where it stands.
    """

    corner: float
    bandwidth: float
    period: float
    kept: slice
    resting: NDArray[np.bool_]
    stands: NDArray[np.bool_]
    stops: int
    velocity: Array

    def filtered(self, values: Array) -> Array:
        """Return a series in the band, of what it is while the joint moves."""
        if self.stops == 0:
            return lowpass(values, (self.corner, self.bandwidth), self.period)[self.kept]
        return self.narrowed(lowpass(values, (self.corner,), self.period))

    def narrowed(self, wide: Array) -> Array:
        """Return the same of a series that has passed the wide filter."""
        moving = wide if self.stops == 0 else np.where(self.stands, 0.0, wide)
        return lowpass(moving, (self.bandwidth,), self.period)[self.kept]

    def at_edges(self, values: Array) -> Array:
        """Return impulses of a series where motions begin, less those where they end, in the band."""
        change = -np.diff(self.stands.astype(np.float64))
        wide = lowpass(values, (self.corner,), self.period)
        edges = np.zeros_like(wide)
        edges[1:] += np.maximum(change, 0.0) * wide[1:]
        edges[:-1] += np.minimum(change, 0.0) * wide[:-1]
        return lowpass(edges / self.period, (self.bandwidth,), self.period)[self.kept]


def band_of_motion(velocity: Array, bandwidth: float, period: float, rest: Rest) -> Band:
    """Return the filters of a piece of a log, from its velocity (rad/s) behind the wide filter."""
    cycle = 1.0 / (bandwidth * period)
    resting = at_rest(
        velocity,
        rest.slowest,
        cycle,
        math.ceil(1.0 / (rest.corner * period)) if rest.dwells else None,
        sticks=rest.sticks,
    )
    stands = standing(resting, velocity, rest, cycle, period)
    moved = with_signs_of_motion(velocity, stands)
    kept = kept_rows(velocity.size, bandwidth, period)
    return Band(
        corner=rest.corner,
        bandwidth=bandwidth,
        period=period,
        kept=kept,
        resting=resting,
        stands=stands,
        stops=len(runs(stands)),
        velocity=moved,
    )


def transferred(values: Array, response: Callable[[Any], Any], period: float) -> Array:
    """Apply a transfer function to a series: exact where it is band-limited, and smooth in a lag of either sign.

    The series is continued by its mirror image, so that it does not jump where its end meets its start.
    """
    mirrored = np.concatenate([values, values[::-1]])
    s = 2j * math.pi * np.fft.rfftfreq(mirrored.size, period)
    changed: Array = np.fft.irfft(np.fft.rfft(mirrored) * response(s), mirrored.size)[: values.size]
    return changed


def kept_rows(size: int, bandwidth: float, period: float) -> slice:
    """Return which samples of a piece become rows: not those at its ends, and as many as the band needs."""
    edge = math.ceil(EDGE / (bandwidth * period)) + REACH
    return slice(edge, size - edge, max(1, math.floor(1.0 / (ROWS_PER_CYCLE * bandwidth * period))))


def velocity_between(fast: Array, period: float) -> Array | None:
    """Return velocities around each sample, shape (n, times); None for a fast log, which does without."""
    times = math.ceil(FINE * period - 1e-9)
    if times <= 1:
        return None
    place = np.arange(fast.size)
    offsets = (np.arange(times) + 0.5) / times - 0.5
    fine: Array = make_interp_spline(place, fast, k=3)((place[:, np.newaxis] + offsets).ravel())
    return fine.reshape(fast.size, times)
