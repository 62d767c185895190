"""Noise of the velocity measurement, from the error alone.

Noise is what changes from one sample to the next without memory: for white noise of variance ``s^2`` the second
difference of the error has the variance ``6 s^2``, while the smooth part of the error leaves hardly any. Motion adds
to it now and then (reversals, jumps of friction), noise always: so the level is a minimum of short means, which rises
slowly to follow noise that grows (minimum statistics, R. Martin, "Noise power spectral density estimation based on
optimal smoothing and minimum statistics", IEEE Trans. Speech and Audio Processing 9, 2001).

Where the short mean is suddenly 25 times that level, and more than the square of the plan's largest speed, it is no
noise: the loop hunts from sample to sample.
"""

import math
from typing import NamedTuple

from numba.extending import register_jitable

WINDOW = 0.3
"""Length of the short means, s."""

SETTLING = 3.0
"""Time of measurement after which the level is known, in lengths of the short means."""

RISE = 20.0
"""Time constant with which the minimum rises, s."""

SECOND_DIFFERENCE = 6.0
"""Variance of the second difference of white noise, in variances of the noise."""

FIRST = 5.0
"""Number of samples from which on the short mean is used at all: with fewer its minimum would be too low by chance."""

LUCK = 9.0
"""Variance that stands for that of the noise before it is known, over the least of its means so far.

With four times the least, 3 to 8 of 1000 starts on nothing but noise would be taken for swift ringing; with nine times
it is one, and 13 where the loop is forty samples slow.
"""

HUNTS = 25.0
"""Short mean over the level of the noise, beyond which a loop hunts.

It must exceed the square of the plan's largest speed as well. With 0.3 of that speed joints on steep curves, which
leap, are not tracked differently in the mean, with 0.1 worse.
"""


class NoiseState(NamedTuple):
    """State of the estimate.

    Attributes
    ----------
    last, before : float
        Error at the last sample and at the one before, rad/s.
    mean : float
        Short mean of the squared second difference over six, rad^2/s^2.
    measured : float
        Time for which samples have shown noise, s.
    variance : float
        Variance of the measured velocity, rad^2/s^2: the slowly rising minimum.
    least : float
        Least value of the short mean so far, corrected for its beginning at zero (:func:`filled_mean`), rad^2/s^2.
    usual : float
        Mean of the squared second difference over six, over all of the time and later over 20 s, rad^2/s^2.
    """

    last: float
    before: float
    mean: float
    measured: float
    variance: float
    least: float
    usual: float


def initial_noise() -> NoiseState:
    """Return the state before anything was measured."""
    return NoiseState(0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0)


@register_jitable
def noise_known(state: NoiseState) -> bool:
    """Tell whether the level of the noise is known: enough samples have shown it."""
    return state.measured > SETTLING * WINDOW


@register_jitable
def advance_noise(state: NoiseState, error: float, counts: bool, duration: float) -> NoiseState:
    """Return the state after an error.

    Parameters
    ----------
    state : NoiseState
        The state.
    error : float
        Reference less measured velocity, rad/s.
    counts : bool
        Whether the sample shows noise: a joint at rest, or a sensor that repeats a value, does not.
    duration : float
        Time since the last sample, s.
    """
    if not counts:
        return state._replace(last=error, before=state.last)
    difference = error - 2.0 * state.last + state.before
    squared = difference * difference / SECOND_DIFFERENCE
    mean = state.mean + duration / (WINDOW + duration) * (squared - state.mean)
    measured = state.measured + duration
    variance = state.variance
    if measured > SETTLING * WINDOW:
        # the first minimum is the first mean
        known = state.measured > SETTLING * WINDOW
        variance = min(mean, variance * (1.0 + duration / RISE)) if known else mean
    least = state.least
    if measured <= SETTLING * WINDOW:
        filled = filled_mean(mean, measured)
        least = min(least, filled) if measured > FIRST * duration else filled
    usual = state.usual + duration / (min(state.measured, RISE) + duration) * (squared - state.usual)
    return NoiseState(error, state.last, mean, measured, variance, least, usual)


@register_jitable
def filled_mean(mean: float, measured: float) -> float:
    """Return a short mean (rad^2/s^2) that began at zero a time ago (s), corrected for that beginning."""
    return mean / -math.expm1(-measured / WINDOW)


@register_jitable
def likely_variance(state: NoiseState) -> float:
    """Return the variance (rad^2/s^2) of the noise, or the mean so far before it is known."""
    if noise_known(state):
        return state.variance
    return filled_mean(state.mean, state.measured) if state.measured > 0.0 else 0.0


@register_jitable
def sure_variance(state: NoiseState) -> float:
    """Return the variance (rad^2/s^2) of the noise, or nine times the least so far before it is known."""
    return state.variance if noise_known(state) else LUCK * state.least


@register_jitable
def least_deviation(state: NoiseState) -> float:
    """Return the standard deviation (rad/s) of the noise, or that of the least so far before it is known."""
    return math.sqrt(state.variance if noise_known(state) else state.least)


@register_jitable
def usual_deviation(state: NoiseState) -> float:
    """Return the standard deviation (rad/s) that second differences have on average, motion included."""
    return math.sqrt(state.usual)


@register_jitable
def hunts(state: NoiseState, peak: float) -> bool:
    """Tell whether the loop hunts: changes from sample to sample exceed noise and the plan's largest speed (rad/s).

    Before the noise is known its least so far stands for it.
    """
    least = peak * peak
    if noise_known(state):
        return state.mean > max(least, HUNTS * state.variance)
    if state.measured <= 0.0:
        return False
    mean = filled_mean(state.mean, state.measured)
    return mean > max(least, HUNTS * state.least)
