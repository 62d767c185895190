"""The motion of a log as a reference for a simulation, and the noise that its velocity has."""

import math
from typing import NamedTuple

import numpy as np

from adaptive_ff.identify.rows.band import uniform, wide_velocity
from adaptive_ff.logs.bandwidth import DERIVATIVE_TIMES_WITHIN
from adaptive_ff.logs.defects import Piece
from adaptive_ff.logs.derivatives import REACH, Array, differentiate, lowpass
from adaptive_ff.logs.log import Log

REFERENCE_ROWS = 10.0
"""Rows of the reference in a second, over the band; it is interpolated afterwards."""

NORMAL_MEDIAN = 0.6745
"""Median size of a normal deviate."""


class Reference(NamedTuple):
    """The motion of a log.

    Attributes
    ----------
    time, velocity : ndarray, shape (n,)
        Time from zero, s, and velocity, rad/s.
    noise : float
        Noise of a velocity that is not filtered, rad/s.
    start : float
        Position at the start, rad; zero where the log has none.
    """

    time: Array
    velocity: Array
    noise: float
    start: float


def reference_of(log: Log, piece: Piece, bandwidth: float, period: float) -> Reference:
    """Return the motion of a piece.

    Parameters
    ----------
    log : Log
        The log.
    piece : Piece
        Piece without a defect.
    bandwidth : float
        Band that the velocity is filtered to, Hz.
    period : float
        Sample time, s.
    """
    time, velocity = _band_velocity(log, piece, bandwidth, period)
    start = 0.0 if log.position is None else float(log.position[piece.start + REACH])
    return Reference(time, velocity, _noise(log, piece, bandwidth, period), start)


def _band_velocity(log: Log, piece: Piece, bandwidth: float, period: float) -> tuple[Array, Array]:
    """Return time from zero, s, and velocity in the band, rad/s."""
    time, motion, _ = uniform(log, piece, period)
    is_position = log.position is not None
    smooth = lowpass(motion - motion[0] if is_position else motion, (bandwidth,), period)
    velocity = differentiate(smooth, period) if is_position else smooth
    every = max(1, math.floor(1.0 / (REFERENCE_ROWS * bandwidth * period)))
    kept = slice(REACH, time.size - REACH, every)
    return time[kept] - time[REACH], velocity[kept]


def _noise(log: Log, piece: Piece, bandwidth: float, period: float) -> float:
    """Return the scatter of the velocity as a controller would see it: unfiltered, around the wide filter, rad/s.

    A position is differentiated by plain backward differences. The scatter is that of a normal distribution with the
    same median of its size, which fast motion at reversals does not touch.
    """
    _, motion, _ = uniform(log, piece, period)
    is_position = log.position is not None
    smooth = wide_velocity(motion, DERIVATIVE_TIMES_WITHIN * bandwidth, period, is_position=is_position)
    if is_position:
        seen, smooth = np.diff(motion) / period, 0.5 * (smooth[1:] + smooth[:-1])
    else:
        seen = motion
    inner = slice(REACH, seen.size - REACH)
    return float(np.median(np.abs(seen[inner] - smooth[inner]))) / NORMAL_MEDIAN
