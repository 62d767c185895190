"""Acquittal: a trial for an observer that was switched off although the joint oscillates without it as well.

Cogging, teeth and an eccentric wheel make the error oscillate, at constant speed as steadily as a loop that a lag makes
unstable. The observer is then switched off without reason (:mod:`adaptive_ff.adaptive.supervision.observer_effect`,
:mod:`adaptive_ff.adaptive.supervision.ringing`). What tells the two apart is the error *without* the observer: an
oscillation that the observer made dies out with it. Stages:

1. *Waits.* While the observer is off, the time is counted in which the error oscillates steadily all the same, far
   beyond the noise (16 times its variance), and the drive has probably given all torque that was asked for. Pauses
   between do not reset it.
2. *Tried.* After 3 s the observer is used again, in full, for 10 s. Compared is

       rho = <e^2> / <ehat^2 + c^2>

   (means over 5 s; the squared error without noise over the square that the PI loop would make of the residual, with
   the correction ``c`` of an outer loop) with its value ``rho_0`` from the time without the observer. The ratio is used
   because the motion may be another one meanwhile.
3. *Guilty*, as soon as ``rho > 1.1 rho_0``, or if ``rho >= rho_0`` at the end of the trial: the observer is off again,
   for good if it was so before.
4. *Acquitted*, if ``rho < rho_0`` at the end of the trial: no steady oscillation and no ringing switches it off again.
"""

from typing import NamedTuple

from numba.extending import register_jitable

WAITS, TRIED, ACQUITTED, GUILTY = range(4)
"""Stages; ``ACQUITTED`` and ``GUILTY`` are final."""

ENOUGH = 3.0
"""Time for which the error must oscillate while the observer is out of use, s."""

CLEAR = 16.0
"""Least mean square of that oscillation, over the variance of the noise: the sensor does not make such a large one."""

UNUSED = 0.05
"""Gain of the observer up to which the error counts as the one without it."""

MEMORY = 5.0
"""Memory of the mean squared errors, s."""

WORSE = 1.1
"""Ratio ``rho`` with the observer over ``rho_0`` without it, beyond which it is guilty at once ..."""

BETTER = 1.0
"""... and below which it is acquitted at the end of the trial."""

LASTS = 10.0
"""How long a trial lasts, s."""

NONE = 1e-24
"""Added to what may be zero, rad^2/s^2."""


class Acquittal(NamedTuple):
    """Stage of the trial, and the errors that are compared.

    Attributes
    ----------
    stage : int
        ``WAITS``, ``TRIED``, ``ACQUITTED`` or ``GUILTY``.
    time : float
        Time for which the error has oscillated without the observer; in a trial, its length so far, s.
    squared, expected : float
        Mean squared error, and mean square of the error that is expected without the observer, rad^2/s^2.
    without : float
        Ratio ``rho_0`` of the first to the second without the observer.
    blamed : bool
        Whether the observer was off for good before the trial, because the loop rang.
    """

    stage: int
    time: float
    squared: float
    expected: float
    without: float
    blamed: bool


def initial_acquittal() -> Acquittal:
    """Return the state of an observer that has not been switched off."""
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
    """Return the state after a sample.

    Parameters
    ----------
    state : Acquittal
        The state.
    error, expected : float
        Squared error beyond noise, and square of the error that is expected without the observer, rad^2/s^2.
    oscillates : bool
        Whether the error is a steady oscillation that counts.
    let_go : bool
        Whether the observer is switched off because the error oscillated ...
    blamed : bool
        ... and for good, because the loop rang.
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
