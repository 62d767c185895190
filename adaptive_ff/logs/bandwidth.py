"""The band in which a log is compared with the model."""

import numpy as np

from adaptive_ff.errors import InputError
from adaptive_ff.logs.derivatives import Array
from controllers.checks import check_numbers

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

NOISE_SHARE = 0.02
"""Largest power of the noise of the acceleration in the band, over that of the acceleration: noise of a regressor draws
its coefficient towards zero by about that share."""

COARSE = 0.05
"""Velocity of one step of a lattice in a sample, over the root mean square, from which a position counts as coarse."""

BULK_TIMES = 8.0
"""Frequency up to which power counts as that of the motion, over the one that has nearly all of its displacement."""

SMOOTHED = 15
"""Bins of the spectrum over which its power is averaged before it is compared with that of the noise."""

LATTICE = 1e-9
"""Smallest step of a lattice, over the largest difference between samples."""

LEAST_TIMES_MOTION = 2.0
"""Smallest band over the frequency of the motion that noise makes it choose."""

DERIVATIVE_TIMES_WITHIN = 0.98 * DERIVATIVE_TIMES
"""The same, below half the sampling frequency where the band is a tenth of it."""

SIGN_NOISE = 0.005
"""Noise of the velocity whose sign is taken, over its root mean square, from which on that filter is made narrower."""

LEAST_SHARE = 0.2
"""Smallest band that noise makes it choose, over the smallest otherwise."""

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
        frequency, Hz; less where noise of the acceleration would count, but at least twice that frequency. Noise is
        taken as white, its level read off from the upper half of the spectrum, and from the lattice of rounded values.
    """
    velocity = np.diff(motion) / period if is_position else motion - np.mean(motion)
    window = np.hanning(velocity.size)
    power = np.abs(np.fft.rfft(velocity * window)) ** 2
    frequency = np.fft.rfftfreq(velocity.size, period)
    gain = (2.0 * np.sin(np.pi * frequency * period) / period) ** 2 if is_position else np.ones_like(frequency)
    upper = frequency > 0.25 / period
    noise = np.mean(power[upper]) / np.mean(gain[upper])
    rounding = rounding_noise(motion, period, is_position=is_position)
    is_coarse = is_position and np.sqrt(12.0 * rounding) / period > COARSE * np.sqrt(np.mean(velocity**2))
    noise = max(noise, rounding * float(np.sum(window**2)))
    width = max(1, min(SMOOTHED, power.size // 20))
    smooth = np.convolve(power, np.ones(width) / width, "same")  # a single bin of noise may be many times its mean
    signal = np.maximum(np.where(smooth > 4.0 * noise * gain, power, 0.0) - noise * gain, 0.0)
    if is_coarse:  # noise of rounding is not white: lines of it far above the bulk of the motion would count as motion
        position = np.cumsum(signal / np.maximum(frequency, frequency[1]) ** 2)
        bulk = float(frequency[int(np.searchsorted(position, MOTION_SHARE * position[-1]))])
        signal[frequency > BULK_TIMES * bulk] = 0.0
    cumulated = np.cumsum(signal)
    moving = float(frequency[int(np.searchsorted(cumulated, MOTION_SHARE * cumulated[-1]))])
    inside = frequency <= TIMES_MOTION * moving
    accelerated = float(np.sum((signal * frequency**2)[inside]))
    loud = np.cumsum(noise * gain * frequency**2) > NOISE_SHARE * accelerated
    quiet = float(frequency[int(np.argmax(loud))]) if np.any(loud) else np.inf
    wanted = min(max(TIMES_MOTION * moving, SMALLEST), max(quiet, LEAST_TIMES_MOTION * moving, LEAST_SHARE * SMALLEST))
    return min(wanted, LARGEST_SHARE / period)


def rounding_noise(motion: Array, period: float, *, is_position: bool) -> float:
    """Return the variance that rounding to a lattice adds to each sample of a motion, as if it were white.

    A lattice of step ``q`` adds ``q^2/12``; where a position passes fewer steps in a second than half the sampling
    frequency, that lies at the lower frequencies, and counts for so much more there. Zero where there is no lattice.
    """
    steps = np.abs(np.diff(motion))
    peak = float(np.max(steps, initial=0.0))
    changing = steps[steps > LATTICE * peak]
    if changing.size == 0:
        return 0.0
    step = float(np.min(changing))
    counts = changing / step
    if np.mean(np.abs(counts - np.round(counts)) < 0.01) < 0.99:
        return 0.0
    rate = float(np.sqrt(np.mean(steps**2))) / (step * period) if is_position else np.inf
    return step**2 / 12.0 * max(1.0, 0.5 / (period * rate))


def white_noise(motion: Array, *, is_position: bool) -> float:
    """Return the variance of the white noise of a motion, from the upper half of its spectrum."""
    series = np.diff(motion) if is_position else motion - np.mean(motion)
    window = np.hanning(series.size)
    power = np.abs(np.fft.rfft(series * window)) ** 2 / float(np.sum(window**2))
    share = np.arange(power.size) / max(1, power.size - 1)  # of half the sampling frequency
    gain = (2.0 * np.sin(0.5 * np.pi * share)) ** 2 if is_position else np.ones_like(share)
    upper = share > 0.5
    return float(np.mean(power[upper]) / np.mean(gain[upper]))


def motion_noise(motion: Array, period: float, *, is_position: bool) -> float:
    """Return the variance of the noise of each sample of a motion: white noise, or that of a lattice."""
    white = white_noise(motion, is_position=is_position)
    return max(white, rounding_noise(motion, period, is_position=is_position))


def wide_corner(motion: Array, bandwidth: float, period: float, *, is_position: bool) -> float:
    """Return the corner of the filter behind which the sign of the velocity is taken, Hz.

    Five times the band; less, down to the band itself, where the noise of that velocity would be more than a small
    share of its size: noise around a reversal smears the sign.
    """
    size = np.diff(motion) / period if is_position else motion
    allowed = (SIGN_NOISE * float(np.sqrt(np.mean(size**2)))) ** 2
    density = 2.0 * period * motion_noise(motion, period, is_position=is_position)
    corner = np.inf
    if density > 0.0:
        corner = (3.0 * allowed / (4.0 * np.pi**2 * density)) ** (1.0 / 3.0) if is_position else allowed / density
    return (
        DERIVATIVE_TIMES_WITHIN * bandwidth if corner > DERIVATIVE_TIMES_WITHIN * bandwidth else max(bandwidth, corner)
    )


def check_bandwidth(bandwidth: float, period: float) -> None:
    """Refuse a band that the sampling does not allow.

    Raises
    ------
    InputError
        It is too wide or not positive.
    """
    check_numbers(bandwidth=bandwidth)
    highest = LARGEST_SHARE / period
    if not 0.0 < bandwidth <= highest * (1.0 + 1e-9):
        raise InputError(
            f"bandwidth = {bandwidth:g} Hz is not allowed: it must be positive and at most a tenth of the sampling "
            f"frequency, {highest:.4g} Hz"
        )
