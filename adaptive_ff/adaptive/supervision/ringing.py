"""Ringing: an observer that a lag makes unstable, noticed within a few half cycles.

A lag that nobody tells, of the drive's current loop or of a filter of the velocity, or a torque that may not rise as
fast as it is asked to, lets the loop ring with what the observer feeds back. The error then crosses zero again and
again, and no half cycle is much smaller than the last:

    A_k >= 0.7 A_{k-1},    1.6 J/Kp < T_k < 8 J/Kp

with the largest error ``A`` and the length ``T`` of each. A crossing is one by more than three standard deviations of
the noise. Of ``n`` such half cycles in a row, all in one motion,

    n >= 2,    n A > 0.56 of the plan's largest speed

are taken for ringing: two with 0.28 of it, and eight at most with 0.07. Longer ones count where their errors are more
than friction and what is observed make of the gain. A loop with a lag rings with 0.4 and more of the plan's speed at
a start; what reversals leave behind is less and dies out, and the error of a slow loop that turns with the plan is of
several motions.

Their lengths need not be alike: where friction drives the joint one way, every other half cycle is two or three times
as long. A drive that lags by 30 ms has a first window of more than 1.2 times the error of PI on one of 20 references
(seeds 101 to 120), torque that rises by at most 2000 N m/s on 4; on 7 and 7 if only those count whose length is within
1.7 times that of the last.

A joint whose friction falls steeply sticks and slips in the same way without any lag. So where the identified friction
is found to fall by more than twice the gain, ringing is no proof, and the observer is given back. Else it stays out of
use until the controller is reset: a drive stays as late as it is. Were it to come back over 300 s, a drive whose torque
rises by at most 2000 N m/s would settle at 0.46 and 0.67 over ten minutes.

With a drive that lags by 13, 16 and 20 ms, told nobody, the first 5 s of the built-in joint leave 0.6 to 0.8 of the
error of PI, without this rule 2.0, 2.5 and 3.6 times that; with 30 ms no later window is above 1.1, without it some are
of 11 times (geometric means, and the worst, of seeds 101 to 104). With a torque that rises by at most 2000 N m/s it
settles at 2.7 to 3.9, without it at 0.43 to 0.69.
"""

import math
from typing import NamedTuple

from numba.extending import register_jitable

CLEAR = 9.0
"""Square of an error from which on it has crossed zero, in variances of the noise."""

KEEPS = 0.7
"""Largest error of a half cycle over that of the one before, from which on it counts ..."""

SHORTEST, LONGEST = 1.6, 8.0
"""... where its length is between these, in time constants of the proportional loop.

Up to 3.6, a drive that lags by 30 ms has first windows of 9.6 times the error of PI, and up to 4.5 one that is limited
in how fast its torque rises settles at half of PI. Up to 12, torque that rises by 1500 N m/s at most has windows of 2.8
times and not 7.3 (seeds 101 to 120), but joints with three times as much stiction as Coulomb friction are blamed for
how they break away: they settle 1 to 4 % worse.
"""

FAR, LONGEST_FAR = 1.0, 25.0
"""A half cycle whose error is more than friction at breakaway, or the torque that is observed (in the mean square),
makes of the proportional gain, times the first, counts up to so many time constants.

No joint that only sticks and slips comes so far: with three times as much stiction as Coulomb friction that share is
two thirds. A torque that rises by at most 1500 N m/s takes a tenth of a second to turn the friction round; of 16
references (seeds 101 to 116, two draws) 8 instead of 10 have a window above 1.2 times the error of PI, the worst of 3.2
instead of 7.3. With a share of 0.75 the worst is 2.2, but two of 16 joints behind a Kalman filter whose friction
triples are let go of, and settle at 1.2 and 1.9 instead of 6.4 and more.
"""

FEWEST, MOST = 2, 8
"""Half cycles in a row, at least, and at most as many as count."""

TOGETHER = 0.56
"""Their number times the largest error of the last one, over the plan's largest speed, from which on it rings ..."""

LOUD = 25.0
"""... where the square of that error is so many times the variance of the noise."""


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
    last_extreme : float
        That of the half cycle before, rad/s.
    sustained : int
        How many in a row were hardly smaller than the one before.
    blamed : bool
        Whether the observer is out of use because the loop rang.
    """

    sign: float
    extreme: float
    length: float
    last_extreme: float
    sustained: int
    blamed: bool


def initial_ringing() -> Ringing:
    """Return the state of a loop of which nothing is known."""
    return Ringing(0.0, 0.0, 0.0, 0.0, 0, False)


@register_jitable
def crosses(state: Ringing, error: float, variance: float) -> bool:
    """Tell whether an error (rad/s) is clearly on the other side of zero, for noise of a variance (rad^2/s^2)."""
    return error * state.sign < 0.0 and error * error > CLEAR * variance


@register_jitable
def grown_half_cycle(state: Ringing, error: float, length: float) -> Ringing:
    """Return the state where the half cycle goes on with an error (rad/s), and is so long (s) by now."""
    sign = state.sign if state.sign != 0.0 else math.copysign(1.0, error)
    return state._replace(sign=sign, extreme=max(state.extreme, error * sign), length=length)


@register_jitable
def next_half_cycle(state: Ringing, error: float, keeps: float, in_range: bool) -> Ringing:
    """Return the state where the next half cycle begins with an error (rad/s).

    The one that ends counts where its length is in range, and its largest error more than a share of the last one's.
    """
    kept = 0.0 < keeps * state.last_extreme < state.extreme
    sustained = state.sustained + 1 if kept and in_range else 0
    return Ringing(math.copysign(1.0, error), abs(error), 0.0, state.extreme, sustained, state.blamed)


@register_jitable
def advance_ringing(
    state: Ringing, error: float, variance: float, far: float, time_constant: float, duration: float
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
    far : float
        Error of :func:`far_error`, rad/s.
    time_constant : float
        ``J/Kp``, s.
    duration : float
        Length of the period, s.
    """
    length = state.length + duration
    if not crosses(state, error, variance):
        grown = grown_half_cycle(state, error, length)
        return grown if length <= longest(grown.extreme, far) * time_constant else grown._replace(sustained=0)
    in_range = SHORTEST * time_constant < length < longest(state.extreme, far) * time_constant
    return next_half_cycle(state, error, KEEPS, in_range)


@register_jitable
def far_error(torque: float, proportional: float, correction: float) -> float:
    """Return an error (rad/s) that neither friction at breakaway nor a load makes, for the larger (N m) and the gain.

    There is none with an outer loop: where a joint breaks loose, what that asks for is as large.
    """
    return FAR * torque / proportional if correction == 0.0 else math.inf


@register_jitable
def loudest(peak: float, far: float) -> float:
    """Return the speed (rad/s) beside which half cycles are judged where a drive has seemed to saturate.

    Two of a far error ring then, small beside the plan's largest speed or not: of 200 machines that saturate untold one
    settles at 0.01 of PI without that, and at 0.37 with it.
    """
    return min(peak, FEWEST * far / TOGETHER)


@register_jitable
def longest(extreme: float, far: float) -> float:
    """Return the longest half cycle that counts, in time constants, for its largest error and a far one, rad/s."""
    return LONGEST_FAR if extreme > far else LONGEST


@register_jitable
def beside_correction(error: float, correction: float) -> float:
    """Return an error without twice what an outer loop asks for (rad/s), or zero where nothing is left of it.

    A loop that rings moves the velocity far more than the position. A correction that is noisy makes an error that
    crosses zero as often, which no observer has made.
    """
    return math.copysign(max(0.0, abs(error) - 2.0 * abs(correction)), error)


@register_jitable
def rings(state: Ringing, variance: float, peak: float) -> bool:
    """Tell whether the loop rings, for a variance of the noise (rad^2/s^2) and the plan's largest speed (rad/s)."""
    squared = state.last_extreme * state.last_extreme
    together = min(state.sustained, MOST) * state.last_extreme
    return state.sustained >= FEWEST and together > TOGETHER * peak and squared > LOUD * variance


@register_jitable
def without_half_cycles(blamed: bool) -> Ringing:
    """Return the state of no half cycle, with or without blame."""
    return Ringing(0.0, 0.0, 0.0, 0.0, 0, blamed)
