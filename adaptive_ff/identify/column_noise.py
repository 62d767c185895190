"""Noise of the regressors: what the noise of a measured motion leaves in acceleration and velocity, in the band.

Noise in a regressor draws its coefficient towards zero (errors in variables: W. Fuller, "Measurement Error Models",
Wiley, 1987, chapter 2). Its variance follows from that of the samples and the known filters, so the estimates are
corrected to first order.
"""

from typing import NamedTuple

import numpy as np

from adaptive_ff.identify.filtering import WITHIN, uniform
from adaptive_ff.identify.preparation import Prepared
from adaptive_ff.logs.bandwidth import DERIVATIVE_TIMES, rounding_noise
from adaptive_ff.logs.derivatives import ORDER

POINTS = 2000
"""Frequencies of the integral over the filters."""


class ColumnNoise(NamedTuple):
    """Variances of the noise of acceleration and velocity in the band."""

    acceleration: float
    velocity: float


def column_noise(prepared: Prepared) -> ColumnNoise:
    """Return the noise of the regressors, estimated on the longest piece."""
    piece = max(prepared.pieces, key=lambda one: one.size)
    period, band = prepared.period, prepared.bandwidth
    is_position = prepared.log.position is not None
    motion = uniform(prepared.log, piece, period)[1]
    white = max(_white_noise(motion, is_position=is_position), rounding_noise(motion, period, is_position=is_position))
    frequency = (np.arange(POINTS) + 0.5) * (0.5 / period / POINTS)
    gain = np.ones_like(frequency)
    for corner in (DERIVATIVE_TIMES * band * WITHIN, band):
        gain /= (1.0 + (frequency / corner) ** (2 * ORDER)) ** 2  # forward and backward, squared
    omega = 2.0 * np.pi * frequency
    density = 2.0 * period * white * (0.5 / period / POINTS)
    order = 2 if is_position else 0
    return ColumnNoise(
        float(density * np.sum(gain * omega ** (order + 2))), float(density * np.sum(gain * omega**order))
    )


def _white_noise(motion: np.ndarray[tuple[int], np.dtype[np.float64]], *, is_position: bool) -> float:
    """Return the variance of white noise, from the upper half of the spectrum of what is differenced."""
    series = np.diff(motion) if is_position else motion - np.mean(motion)
    window = np.hanning(series.size)
    power = np.abs(np.fft.rfft(series * window)) ** 2 / float(np.sum(window**2))
    share = np.arange(power.size) / max(1, power.size - 1)  # of half the sampling frequency
    gain = (2.0 * np.sin(0.5 * np.pi * share)) ** 2 if is_position else np.ones_like(share)
    upper = share > 0.5
    return float(np.mean(power[upper]) / np.mean(gain[upper]))
