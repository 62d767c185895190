"""Noise of the regressors: what the noise of a measured motion leaves in acceleration and velocity, in the band.

Noise in a regressor draws its coefficient towards zero (errors in variables: W. Fuller, "Measurement Error Models",
Wiley, 1987, chapter 2). Its variance follows from that of the samples and the known filters, so the estimates are
corrected to first order.
"""

from typing import NamedTuple

import numpy as np

from adaptive_ff.identify.rows.band import uniform
from adaptive_ff.logs.bandwidth import motion_noise
from adaptive_ff.logs.defects import Piece
from adaptive_ff.logs.derivatives import ORDER
from adaptive_ff.logs.log import Log

POINTS = 2000
"""Frequencies of the integral over the filters."""


class ColumnNoise(NamedTuple):
    """Variances of the noise of acceleration and velocity in the band."""

    acceleration: float
    velocity: float


def column_noise(log: Log, piece: Piece, period: float, corners: tuple[float, float]) -> ColumnNoise:
    """Return the noise of the regressors, estimated on a piece of a log.

    Parameters
    ----------
    log : Log
        The log.
    piece : Piece
        Piece without a defect, the longer the better.
    period : float
        Sample time, s.
    corners : tuple of float
        Corners of both filters, Hz.
    """
    is_position = log.position is not None
    motion = uniform(log, piece, period)[1]
    white = motion_noise(motion, period, is_position=is_position)
    frequency = (np.arange(POINTS) + 0.5) * (0.5 / period / POINTS)
    gain = np.ones_like(frequency)
    for corner in corners:
        gain /= (1.0 + (frequency / corner) ** (2 * ORDER)) ** 2  # forward and backward, squared
    omega = 2.0 * np.pi * frequency
    density = 2.0 * period * white * (0.5 / period / POINTS)
    order = 2 if is_position else 0
    return ColumnNoise(
        float(density * np.sum(gain * omega ** (order + 2))), float(density * np.sum(gain * omega**order))
    )
