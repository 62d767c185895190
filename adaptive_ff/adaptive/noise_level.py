"""Noise of the velocity measurement, from the error alone.

Noise is what changes from one sample to the next without memory: for white noise of variance ``s^2`` the second
difference of the error has the variance ``6 s^2``, while the smooth part of the error leaves hardly any. Motion adds
to it now and then (reversals, jumps of friction), noise always: so the level is a minimum of short means, which rises
slowly to follow noise that grows (minimum statistics, R. Martin, "Noise power spectral density estimation based on
optimal smoothing and minimum statistics", IEEE Trans. Speech and Audio Processing 9, 2001).
"""

from typing import NamedTuple

from numba.extending import register_jitable

WINDOW = 0.3
"""Length of the short means, s."""

SETTLING = 3.0
"""Time for which must have been measured before the level is known, in lengths of the short means."""

RISE = 20.0
"""Time constant with which the minimum rises, s."""

SECOND_DIFFERENCE = 6.0
"""Variance of the second difference of white noise, in variances of the noise."""


class NoiseState(NamedTuple):
    """State of the estimate.

    Attributes
    ----------
    last, before : float
        Error at the last sample and at the one before, rad/s.
    mean : float
        Short mean of the squared second difference over six, rad^2/s^2.
    measured : float
        For how long there has been something to measure, s.
    variance : float
        Variance of the measured velocity, rad^2/s^2: the slowly rising minimum.
    """

    last: float
    before: float
    mean: float
    measured: float
    variance: float


def initial_noise() -> NoiseState:
    """Return the state before anything was measured."""
    return NoiseState(0.0, 0.0, 0.0, 0.0, 0.0)


@register_jitable
def noise_known(state: NoiseState) -> bool:
    """Tell whether there has been enough to measure."""
    return state.measured > SETTLING * WINDOW


@register_jitable
def advance_noise(state: NoiseState, error: float, counts: bool, duration: float) -> NoiseState:
    """Take an error (rad/s) into account.

    Parameters
    ----------
    state : NoiseState
        The state.
    error : float
        Reference less measured velocity, rad/s.
    counts : bool
        Whether the sample tells of noise: a joint at rest, or a sensor that repeats a value, does not.
    duration : float
        Time since the last sample, s.
    """
    if not counts:
        return NoiseState(error, state.last, state.mean, state.measured, state.variance)
    difference = error - 2.0 * state.last + state.before
    squared = difference * difference / SECOND_DIFFERENCE
    mean = state.mean + duration / (WINDOW + duration) * (squared - state.mean)
    measured = state.measured + duration
    variance = state.variance
    if measured > SETTLING * WINDOW:
        # the first minimum is the first mean
        known = state.measured > SETTLING * WINDOW
        variance = min(mean, variance * (1.0 + duration / RISE)) if known else mean
    return NoiseState(error, state.last, mean, measured, variance)
