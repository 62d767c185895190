"""Ringing: a loop that an unmodelled lag makes unstable with the observer, detected within a few half cycles.

The controller may lack a lag of the drive's current loop, or of a filter of the velocity, or a limit of how fast the
torque can rise. The torque that the observer feeds back then comes too late, and the loop oscillates with it. The error
crosses zero again and again. A crossing counts where the error is beyond three standard deviations of the noise. A half
cycle of length ``T_k``, with the largest error ``A_k``, is *sustained* where it is not much smaller than the last one:

    A_k > 0.7 A_{k-1},    1.6 J/Kp < T_k < 8 J/Kp

The loop is taken to ring after ``n`` sustained half cycles in a row, without a reversal of the plan between them, if

    n >= 2,    min(n, 8) A > 0.56 of the plan's largest speed,    A^2 > 25 variances of the noise

with ``A`` the largest error of the last one. So two are enough with 0.28 of the plan's largest speed, eight with 0.07.
The observer is then switched off (:func:`adaptive_ff.adaptive.supervision.observer_effect.restrain_ringing`).

- *Long half cycles.* A half cycle may last up to ``25 J/Kp`` if its error is larger than the friction at breakaway, and
  the observed torque, make at the proportional gain (:func:`far_error`).
- *What does not count.* A loop with a lag rings with 0.4 and more of the plan's largest speed at a start. What a
  reversal leaves is smaller, and dies out. The error of a slow loop turns with the plan, and the plan reverses between
  its half cycles.
- *Unequal lengths.* Where friction drives the joint one way, every other half cycle is two or three times as long, so
  the lengths are not compared with each other. Of 20 references (seeds 101 to 120) one has a first window above 1.2
  times PI's error with a drive that lags by 30 ms, and 4 with torque that rises by at most 2000 N m/s. If only half
  cycles counted whose length is within 1.7 times that of the last, there would be 7 and 7.
- *Stick-slip.* A joint whose friction falls steeply with the velocity sticks and slips like that without any lag. So
  where the identified friction falls by more than twice the proportional gain, ringing is no evidence of a lag, and the
  observer is used again.
- *Otherwise the observer stays off* until the controller is reset, since a drive stays as late as it is. (The exception
  is a joint that oscillates without the observer as well, :mod:`adaptive_ff.adaptive.supervision.acquittal`.) If the
  observer came back over 300 s, a drive whose torque rises by at most 2000 N m/s would settle at 0.46 and 0.67 over ten
  minutes.

Evidence, on the built-in joint with a drive whose lag is not specified (geometric means of seeds 101 to 104, and the
worst window). *Settles at* is PI's settled error over that of the controller: above 1 it is better than PI.

- With a lag of 13, 16 and 20 ms the first 5 s leave 0.6 to 0.8 of PI's error; without this rule 2.0, 2.5 and 3.6 times.
- With 30 ms no later window is above 1.1 times PI's error; without the rule some have 11 times.
- With a torque that rises by at most 2000 N m/s it settles at 2.7 to 3.9; without the rule at 0.43 to 0.69.
"""

import math
from typing import NamedTuple

from numba.extending import register_jitable

CLEAR = 9.0
"""Least square of an error beyond zero that counts as a crossing, in variances of the noise."""

KEEPS = 0.7
"""Least ratio of the largest error of a half cycle to that of the one before, for it to be sustained ..."""

SHORTEST, LONGEST = 1.6, 8.0
"""... where its length is between these, in time constants of the proportional loop.

Other values for the longest one, none of which is used:

- with 3.6 a drive that lags by 30 ms has first windows of 9.6 times PI's error;
- with 4.5 a drive whose torque rises slowly settles at half of PI's accuracy;
- with 12 torque that rises by at most 1500 N m/s has windows of 2.8 times PI's error instead of 7.3 (seeds 101 to 120).
  But joints with three times as much stiction as Coulomb friction are taken to ring where they break away, and settle
  1 to 4 % worse.
"""

FAR, LONGEST_FAR = 1.0, 25.0
"""Error from which on a half cycle may be long, over the larger of friction at breakaway and observed torque (rms)
divided by the proportional gain; and the longest one then, in time constants of the proportional loop.

A joint that only sticks and slips does not come so far: with three times as much stiction as Coulomb friction it comes
to two thirds. A torque that rises by at most 1500 N m/s takes a tenth of a second to reverse the friction. With this
rule 8 of 16 references (seeds 101 to 116, two draws) have a window above 1.2 times PI's error, the worst 3.2; without
it 10, the worst 7.3. With 0.75 instead of 1 the worst is 2.2, but of 16 joints behind a Kalman filter whose friction
triples two lose their observer, and settle at 1.2 and 1.9 instead of 6.4 and more.
"""

FEWEST, MOST = 2, 8
"""Least number of sustained half cycles in a row, and the largest number that counts in the product with the error."""

TOGETHER = 0.56
"""Least product of their number and the largest error of the last one, over the plan's largest speed ..."""

LOUD = 25.0
"""... and least square of that error, over the variance of the noise, for the loop to ring."""


class Ringing(NamedTuple):
    """Half cycles of the error.

    Attributes
    ----------
    sign : float
        Sign of the error in the present half cycle; zero before the first.
    extreme : float
        Largest error in the present half cycle, rad/s.
    length : float
        Length of the present half cycle so far, s.
    last_extreme : float
        Largest error in the half cycle before, rad/s.
    sustained : int
        Number of sustained half cycles in a row; the first one of all has none before it, and does not count.
    blamed : bool
        Whether the observer is switched off (in ``swift``: slowed) because the loop rang.
    """

    sign: float
    extreme: float
    length: float
    last_extreme: float
    sustained: int
    blamed: bool


def initial_ringing() -> Ringing:
    """Return the state before the first sample."""
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

    The half cycle that ends is sustained if its length is in range, and its largest error more than ``keeps`` times
    that of the one before it.
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
    """Return the largest error (rad/s) that a torque (N m), of friction or a load, makes at the proportional gain.

    It is infinite while an outer loop asks for a correction (rad/s): where a joint breaks loose that is as large.
    """
    return FAR * torque / proportional if correction == 0.0 else math.inf


@register_jitable
def loudest(peak: float, far: float) -> float:
    """Return the speed (rad/s) with which half cycles are compared where a drive has seemed to saturate.

    Two sustained half cycles beyond the far error are ringing then, however small they are beside the plan's largest
    speed. Of 200 machines that saturate without reporting it one settles at 0.37 of PI's accuracy, without this at
    0.01.
    """
    return min(peak, FEWEST * far / TOGETHER)


@register_jitable
def longest(extreme: float, far: float) -> float:
    """Return the longest half cycle that counts, in time constants, for its largest error and a far error, rad/s."""
    return LONGEST_FAR if extreme > far else LONGEST


@register_jitable
def beside_correction(error: float, correction: float) -> float:
    """Return an error less twice the correction of an outer loop (rad/s), or zero where that is larger.

    A loop that rings moves the velocity far more than the position, so its error is far larger than the correction. A
    noisy correction makes an error that crosses zero as often, and that is not the observer's doing.
    """
    return math.copysign(max(0.0, abs(error) - 2.0 * abs(correction)), error)


@register_jitable
def rings(state: Ringing, variance: float, peak: float) -> bool:
    """Tell whether the loop rings, for the variance of the noise (rad^2/s^2) and the plan's largest speed (rad/s)."""
    squared = state.last_extreme * state.last_extreme
    together = min(state.sustained, MOST) * state.last_extreme
    return state.sustained >= FEWEST and together > TOGETHER * peak and squared > LOUD * variance


@register_jitable
def without_half_cycles(blamed: bool) -> Ringing:
    """Return the state before the first half cycle; ``blamed`` as of :class:`Ringing`."""
    return Ringing(0.0, 0.0, 0.0, 0.0, 0, blamed)
