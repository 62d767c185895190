"""Acquittal: a joint that oscillates by itself, whose observer was let go of for nothing.

Cogging, teeth and an eccentric wheel make the error oscillate, at constant speed as steadily as a loop that a lag makes
unstable. What tells them apart is what the error does *without* the observer. An oscillation that the observer made
dies out with it. So while it is out of use, the time is counted in which the error oscillates all the same, and where
that is long enough the observer is tried: it is used again, in full, and the mean squared error over that of the one
which the loop would make of the residual,

    rho = <e^2> / <ehat^2>

is compared with what it was without the observer; the motion may be another one meanwhile. Where it becomes a tenth
more, the observer is guilty, and out of use as before; where it is less at the end of the trial, the observer is
acquitted, and what the error does is no reason to let go of it again.
"""

from typing import NamedTuple

from numba.extending import register_jitable

WAITS, TRIED, ACQUITTED, GUILTY = range(4)
"""Stages."""

ENOUGH = 3.0
"""Time for which the error must oscillate while the observer is out of use, s."""

CLEAR = 16.0
"""Mean square of that oscillation over the variance of the noise, at least: it is not one that the sensor makes."""

UNUSED = 0.05
"""Gain of the observer up to which the error is that without it."""

MEMORY = 5.0
"""Memory of the mean squared errors, s."""

WORSE = 1.1
"""Mean squared error with the observer over the one without it from which on it is guilty ..."""

BETTER = 1.0
"""... and below which, after a while, it is acquitted."""

LASTS = 10.0
"""How long a trial lasts, s."""

NONE = 1e-24
"""Added to what may be zero, rad^2/s^2."""


class Acquittal(NamedTuple):
    """What is known of the error without the observer.

    Attributes
    ----------
    stage : int
        ``WAITS``, ``TRIED``, ``ACQUITTED`` or ``GUILTY``.
    time : float
        Time for which the error has oscillated without the observer; in a trial, its length so far, s.
    squared, expected : float
        Mean squared error, and that of the one which the loop would make of the residual, rad^2/s^2.
    without : float
        The first over the second without the observer.
    blamed : bool
        Whether it was out of use for good before the trial.
    """

    stage: int
    time: float
    squared: float
    expected: float
    without: float
    blamed: bool


def initial_acquittal() -> Acquittal:
    """Return the state of an observer that nothing has been said against."""
    return Acquittal(WAITS, 0.0, 0.0, 0.0, 0.0, False)


@register_jitable
def advance_acquittal(
    state: Acquittal,
    error: float,
    expected: float,
    oscillates: bool,
    let_go: bool,
    blamed: bool,
    gain: float,
    duration: float,
) -> Acquittal:
    """Take the error of a sample into account.

    Parameters
    ----------
    state : Acquittal
        The state.
    error, expected : float
        Squared error beyond noise, and that of the one which the loop would make of the residual, rad^2/s^2.
    oscillates : bool
        Whether the error is a steady oscillation.
    let_go : bool
        Whether the observer is out of use because the error oscillated ...
    blamed : bool
        ... and for good.
    gain : float
        Gain with which the observer was fed back.
    duration : float
        Length of the period, s.
    """
    stage, time, squared, predicted = state.stage, state.time, state.squared, state.expected
    unused, weight = stage == WAITS and let_go and gain <= UNUSED, duration / (MEMORY + duration)
    if unused or stage == TRIED:
        squared, predicted = squared + weight * (error - squared), predicted + weight * (expected - predicted)
    if unused:
        time += duration if oscillates else 0.0
        if time >= ENOUGH:
            return Acquittal(TRIED, 0.0, squared, predicted, squared / (predicted + NONE), blamed)
    elif stage == TRIED:
        time += duration
        if squared > WORSE * state.without * predicted:
            stage = GUILTY
        elif time >= LASTS:
            stage = ACQUITTED if squared < BETTER * state.without * predicted else GUILTY
    return Acquittal(stage, time, squared, predicted, state.without, state.blamed)
