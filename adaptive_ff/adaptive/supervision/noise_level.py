"""Noise of the velocity measurement, from the error alone.

Noise is what changes from one sample to the next without memory: for white noise of variance ``s^2`` the second
difference of the error has the variance ``6 s^2``, while the smooth part of the error leaves hardly any. Motion adds
to it now and then (reversals, jumps of friction), noise always: so the level is a minimum of short means, which rises
slowly to follow noise that grows (minimum statistics, R. Martin, "Noise power spectral density estimation based on
optimal smoothing and minimum statistics", IEEE Trans. Speech and Audio Processing 9, 2001).

What suddenly is 25 times that, and more than the plan itself, is no noise: a loop hunts from sample to sample.
"""

import math
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

FIRST = 5.0
"""Samples from which on the short mean tells of the noise at all; what is the least then is no lower for chance."""

LUCK = 9.0
"""Variance of the noise over the least of its means that chance is allowed before it is known.

With four times the least, 3 to 8 of 1000 starts on nothing but noise were taken for swift ringing; with nine times it
is one, and 13 where the loop is forty samples slow.
"""

HUNTS = 25.0
"""How many times the level of the noise the short mean is where a loop hunts.

It must be more than the plan's largest speed as well: with 0.3 of that joints on steep curves, which leap, are not
tracked differently in the mean, with 0.1 worse.
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
        For how long there has been something to measure, s.
    variance : float
        Variance of the measured velocity, rad^2/s^2: the slowly rising minimum.
    least : float
        The least of the short mean so far, which begins at zero, over the share of it that is filled, rad^2/s^2.
    usual : float
        Mean of the squared second difference over six, of all of the time and then of 20 s, rad^2/s^2.
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
    """Return a short mean (rad^2/s^2) that began at zero a time ago (s) over the share of it that is filled."""
    return mean / -math.expm1(-measured / WINDOW)


@register_jitable
def likely_variance(state: NoiseState) -> float:
    """Return the variance (rad^2/s^2) of the noise, or before it is known what there has been so far on average."""
    if noise_known(state):
        return state.variance
    return filled_mean(state.mean, state.measured) if state.measured > 0.0 else 0.0


@register_jitable
def sure_variance(state: NoiseState) -> float:
    """Return the variance (rad^2/s^2) of the noise, or before it is known a multiple of the least there has been."""
    return state.variance if noise_known(state) else LUCK * state.least


@register_jitable
def least_deviation(state: NoiseState) -> float:
    """Return the standard deviation (rad/s) of the noise, or before it is known of the least there has been so far."""
    return math.sqrt(state.variance if noise_known(state) else state.least)


@register_jitable
def usual_deviation(state: NoiseState) -> float:
    """Return the standard deviation (rad/s) that second differences have on average, motion included."""
    return math.sqrt(state.usual)


@register_jitable
def hunts(state: NoiseState, peak: float) -> bool:
    """Tell whether what changes from sample to sample is no noise, but more than the largest speed of the plan (rad/s).

    Before the noise is known its least so far stands for it.
    """
    least = peak * peak
    if noise_known(state):
        return state.mean > max(least, HUNTS * state.variance)
    if state.measured <= 0.0:
        return False
    mean = filled_mean(state.mean, state.measured)
    return mean > max(least, HUNTS * state.least)
