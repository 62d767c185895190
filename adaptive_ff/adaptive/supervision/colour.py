"""Coloured noise: noise of the measured velocity that a filter has made slow, found from means over a few samples.

Of white noise of variance ``s^2`` a mean over ``n`` samples keeps ``s^2/n``. A Kalman filter behind an encoder makes
noise that changes little from one sample to the next, and means keep nearly all of it. So the standard deviation ``v``
of the noise of means is compared with ``s``, that of samples. The noise is **coloured** where

    n v^2 > (1.5 s)^2,    Kp v > 0.02 F

with the friction ``F`` at breakaway. The second condition leaves out joints with a good sensor, whose motion changes
slowly as well, but less than that at its slowest.

``v^2`` is found as ``s^2`` is in :mod:`adaptive_ff.adaptive.supervision.noise_level`: from the second differences of
the means, as the slowly rising minimum of a short mean of their squares, or before there is one, as the mean so far.
The means are over a quarter of the time constant of the observer, since that is what the observer sees.
"""

from typing import NamedTuple

from numba.extending import register_jitable

from adaptive_ff.adaptive.supervision.noise_level import (
    RISE,
    SECOND_DIFFERENCE,
    SETTLING,
    WINDOW,
    NoiseState,
    filled_mean,
    likely_variance,
)

SPAN = 0.25
"""Length of the means, in time constants of the observer."""

SLOW = 1.5
"""``sqrt(n) v/s`` beyond which noise is coloured.

Sensors whose noise is white have 0.5 to 1, an encoder behind a Kalman filter 1.5 to 13.
"""

FELT = 0.02
"""Proportional torque of the noise of means, over the friction, beyond which it counts.

Machines with sensors of little noise, whose motion alone changes slowly, have at most 0.008 (nine, and three behind a
position loop, of seed 401).
"""

EARLY = 0.05
"""Time of measurement from which on noise may be coloured, s."""


class Colour(NamedTuple):
    """State of the estimate.

    Attributes
    ----------
    total : float
        Sum of the errors since the last mean, rad/s.
    samples : int
        Number of these errors.
    time : float
        Time over which they came, s.
    last, before : float
        The last mean and the one before, rad/s.
    means : int
        Number of means so far, up to two.
    measured : float
        Time for which there have been second differences, s.
    squared : float
        Short mean of the squared second differences over six, rad^2/s^2.
    variance : float
        Slowly rising minimum of that, ``v^2``, rad^2/s^2.
    """

    total: float
    samples: int
    time: float
    last: float
    before: float
    means: int
    measured: float
    squared: float
    variance: float


def initial_colour() -> Colour:
    """Return the state before anything was measured."""
    return Colour(
        total=0.0, samples=0, time=0.0, last=0.0, before=0.0, means=0, measured=0.0, squared=0.0, variance=0.0
    )


@register_jitable
def mean_length(pole: float, period: float) -> int:
    """Return the number of samples of a mean, for an observer's pole (rad/s) and a period (s)."""
    return max(1, int(SPAN / (pole * period)))


@register_jitable
def advance_colour(state: Colour, error: float, tells: bool, length: int, duration: float) -> Colour:
    """Return the state after an error.

    Parameters
    ----------
    state : Colour
        The state.
    error : float
        Plan less measured velocity, rad/s.
    tells : bool
        Whether the sample shows noise, see :func:`adaptive_ff.adaptive.supervision.noise_level.advance_noise`; where it
        does not the means begin anew.
    length : int
        Number of samples of a mean.
    duration : float
        Length of the period, s.
    """
    if not tells:
        return state._replace(total=0.0, samples=0, time=0.0, last=0.0, before=0.0, means=0)
    measured, squared, variance = state.measured, state.squared, state.variance
    total, samples, time = state.total + error, state.samples + 1, state.time + duration
    last, before, means = state.last, state.before, state.means
    if samples >= length:
        mean = total / samples
        if means >= 2:
            difference = mean - 2.0 * last + before
            squared += time / (WINDOW + time) * (difference * difference / SECOND_DIFFERENCE - squared)
            measured += time
        last, before, means = mean, last, min(2, means + 1)
        total, samples, time = 0.0, 0, 0.0
    if measured > SETTLING * WINDOW:  # the first minimum is the first mean
        known = state.measured > SETTLING * WINDOW
        variance = min(squared, variance * (1.0 + duration / RISE)) if known else squared
    return Colour(
        total=total,
        samples=samples,
        time=time,
        last=last,
        before=before,
        means=means,
        measured=measured,
        squared=squared,
        variance=variance,
    )


@register_jitable
def is_coloured(state: Colour, noise: NoiseState, length: int, proportional: float, friction: float) -> bool:
    """Tell whether the noise is coloured, for means of a length, a gain (N m s/rad) and a friction (N m)."""
    if state.measured <= EARLY:
        return False
    known = state.measured > SETTLING * WINDOW
    means = state.variance if known else filled_mean(state.squared, state.measured)
    felt = FELT * friction
    slow = length * means > SLOW * SLOW * likely_variance(noise)
    return slow and proportional * proportional * means > felt * felt
