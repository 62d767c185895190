"""The band in which a log is compared with the model."""

import numpy as np

from adaptive_ff.errors import InputError
from adaptive_ff.logs.derivatives import Array

MOTION_SHARE = 0.99
"""Share of the power of the velocity that makes the frequency of the motion."""

TIMES_MOTION = 5.0
"""The band over the frequency of the motion. Friction jumps at reversals, so its torque reaches further than the
motion; on the other side noise of the acceleration grows with the band."""

SMALLEST = 10.0
"""Smallest band chosen by itself, Hz: with less, little is left of reversals, and with it of lag and stiction."""

DERIVATIVE_TIMES = 5.0
"""Corner of the wide filter, behind which the sign of the velocity is taken, over the band: 100 Hz to 20 Hz in the
reference models of EMPS (A. Janot, M. Gautier, M. Brunot, 2019)."""

LARGEST_SHARE = 0.1
"""Largest band, over the sampling frequency: the filter of the derivatives stays at its half."""


def choose_bandwidth(motion: Array, period: float, *, is_position: bool) -> float:
    """Choose a band from the spectrum of the velocity, freed of noise.

    Parameters
    ----------
    motion : ndarray, shape (n,)
        Position or velocity on a uniform grid.
    period : float
        Sample time, s.
    is_position : bool
        Which of them.

    Returns
    -------
    float
        Five times the frequency below which 99 % of the velocity's power lies, from 10 Hz to a tenth of the sampling
        frequency, Hz. Noise is taken as white, its level read off from the upper half of the spectrum.
    """
    velocity = np.diff(motion) / period if is_position else motion - np.mean(motion)
    power = np.abs(np.fft.rfft(velocity * np.hanning(velocity.size))) ** 2
    frequency = np.fft.rfftfreq(velocity.size, period)
    shape = np.sin(np.pi * frequency * period) ** 2 if is_position else np.ones_like(frequency)
    upper = frequency > 0.25 / period
    noise = np.mean(power[upper]) / np.mean(shape[upper])
    cumulated = np.cumsum(np.maximum(power - 4.0 * noise * shape, 0.0))
    place = int(np.searchsorted(cumulated, MOTION_SHARE * cumulated[-1]))
    highest = LARGEST_SHARE / period
    return min(max(TIMES_MOTION * float(frequency[place]), SMALLEST), highest)


def check_bandwidth(bandwidth: float, period: float) -> None:
    """Refuse a band that the sampling does not allow.

    Raises
    ------
    InputError
        It is too wide or not positive.
    """
    highest = LARGEST_SHARE / period
    if not 0.0 < bandwidth <= highest * (1.0 + 1e-9):
        raise InputError(
            f"bandwidth = {bandwidth:g} Hz is not allowed: it must be positive and at most a tenth of the sampling "
            f"frequency, {highest:.4g} Hz"
        )
