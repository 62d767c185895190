"""Ringing: an observer that a lag makes unstable, noticed within two cycles.

A lag that nobody tells, of the drive's current loop or of a filter of the velocity, lets the loop ring with what the
observer feeds back, at a start, when all of the friction is still the observer's. The error then crosses zero again and
again, one half cycle like the last:

    A_k >= 0.7 A_{k-1},    1/1.7 < T_k/T_{k-1} < 1.7,    1.6 J/Kp < T_k < 4.5 J/Kp

with the largest error ``A`` and the length ``T`` of each. A crossing is one by more than three standard deviations of
the noise. Three half cycles alike in one motion, with an error of 0.28 of the plan's largest speed and more, are taken
for ringing: a loop with a lag rings with 0.4 and more of it, what reversals leave behind has less, and the error of a
slow loop that turns with the plan is none. That is looked for in the first 4 s in which the observer is used. A loop
that has not rung by then does not ring by itself, and half cycles that are alike by chance do not count any more.

A joint whose friction falls steeply sticks and slips in the same way without any lag. So where the identified friction
is found to fall by more than twice the gain, ringing is no proof, and the observer is given back.

With a drive that lags by 13, 16 and 20 ms, told nobody, the first 5 s of the built-in joint left 2.0, 2.5 and 3.6 times
the error of PI, and leave 0.6 to 0.8 of it; with 30 ms there were later windows of 11 times, and none of more than 1.1
now (geometric means, and the worst, of seeds 101 to 104).
"""

import math
from typing import NamedTuple

from numba.extending import register_jitable

CLEAR = 9.0
"""Square of an error from which on it has crossed zero, in variances of the noise."""

KEEPS = 0.7
"""Largest error of a half cycle over that of the one before, from which on it is alike ..."""

LIKE = 1.7
"""... where the longer one of the two is less than so many times as long ..."""

SHORTEST, LONGEST = 1.6, 4.5
"""... and its length between these, in time constants of the proportional loop.

Up to 3.6, a drive that lags by 30 ms still has first windows of 9.6 times the error of PI.
"""

ENOUGH = 2
"""Half cycles that are like the one before, from which on the loop rings: with three, first windows are a fifth worse."""

LARGE = 0.28
"""Largest error of a half cycle that counts, over the largest speed of the plan ..."""

LOUD = 36.0
"""... and its square over the variance of the noise, of which little is known at a start."""

LOOKED_FOR = 4.0
"""Time in use in which ringing is looked for, s: without an end drawn joints lose 4 % and more."""


class Ringing(NamedTuple):
    """Half cycles of the error.

    Attributes
    ----------
    sign : float
        Sign of the error in the present one; zero before the first.
    extreme : float
        Largest error in it, rad/s.
    length : float
        Its length so far, s.
    last_extreme, last_length : float
        Those of the half cycle before, rad/s and s.
    alike : int
        How many in a row were like the one before.
    used : float
        For how long the observer has been in use, s.
    blamed : bool
        Whether the observer is out of use because the loop rang.
    """

    sign: float
    extreme: float
    length: float
    last_extreme: float
    last_length: float
    alike: int
    used: float
    blamed: bool


def initial_ringing() -> Ringing:
    """Return the state of a loop of which nothing is known."""
    return Ringing(0.0, 0.0, 0.0, 0.0, 0.0, 0, 0.0, False)


@register_jitable
def advance_ringing(
    state: Ringing, error: float, variance: float, time_constant: float, used: bool, duration: float
) -> Ringing:
    """Take the error of a sample into account.

    Parameters
    ----------
    state : Ringing
        The state.
    error : float
        Error that the feedback sees, rad/s.
    variance : float
        Variance of the measured velocity, rad^2/s^2.
    time_constant : float
        ``J/Kp``, s.
    used : bool
        Whether the observer is in use.
    duration : float
        Length of the period, s.
    """
    length, time = state.length + duration, state.used + (duration if used else 0.0)
    if error * state.sign >= 0.0 or error * error <= CLEAR * variance:
        sign = state.sign if state.sign != 0.0 else math.copysign(1.0, error)
        extreme, alike = max(state.extreme, error * sign), state.alike
        if length > LONGEST * time_constant:
            alike = 0
        return Ringing(sign, extreme, length, state.last_extreme, state.last_length, alike, time, state.blamed)
    alike = 0
    if (
        state.extreme > KEEPS * state.last_extreme
        and length < LIKE * state.last_length
        and state.last_length < LIKE * length
        and SHORTEST * time_constant < length < LONGEST * time_constant
    ):
        alike = state.alike + 1
    return Ringing(math.copysign(1.0, error), abs(error), 0.0, state.extreme, length, alike, time, state.blamed)


@register_jitable
def rings(state: Ringing, variance: float, peak: float) -> bool:
    """Tell whether the loop rings, for a variance of the noise (rad^2/s^2) and the plan's largest speed (rad/s)."""
    clear = max(LARGE * LARGE * peak * peak, LOUD * variance)
    squared = state.last_extreme * state.last_extreme
    return state.alike >= ENOUGH and squared > clear and state.used < LOOKED_FOR and not state.blamed


@register_jitable
def with_blame(state: Ringing, blamed: bool) -> Ringing:
    """Return the state with or without blame, and no half cycle."""
    return Ringing(0.0, 0.0, 0.0, 0.0, 0.0, 0, state.used, blamed)
