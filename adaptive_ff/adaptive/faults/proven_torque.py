"""Torque that a drive is proven to give: the largest resistance with which the joint has followed its plan.

:mod:`adaptive_ff.adaptive.faults.drive_limit` defines the resistance ``R`` and the proven one ``R_p``, and says what
they are used for. The joint *follows* its plan ``r`` while the proportional torque ``Kp |e|`` of its low-passed error
is within the noise, or less than

    min(0.2 R, 0.1 Kp |r|)                                  before anything is proven (0.02 Kp |r| once fully doubted);
    max(min(0.05 |R|, 0.1 R_p, 0.05 Kp |r|), 0.005 Kp |r|)  afterwards;
    min(0.05 R_p, 0.005 Kp |r|)                             of a drive that has seemed to saturate beyond ``R_p``.

What moves ``R_p``, while the joint moves along the torque:

- *More is proven* once the joint has followed with ``R > R_p`` for three integral times, or for eight if the drive has
  seemed to saturate. Time in which it does not follow is subtracted. ``R_p`` grows by a factor of 1.5 at most at once.
- *Less is needed*: while the joint follows with ``0 < R <= R_p``, ``R_p`` falls to ``R`` with a time constant of 10 s.
"""

import math
from typing import NamedTuple

from numba.extending import register_jitable

from adaptive_ff.adaptive.faults.drive_limit_state import DriveLimit
from adaptive_ff.adaptive.faults.rising_resistance import RisingResistance, advance_rising_resistance, risen
from controllers import PIParameters

SMOOTH = 2.0
"""Time constant of the low-passes, in those of the proportional loop ``J/Kp``."""

WRONG_INERTIA = 0.3
"""Share of the inertia's torque that may be missing because the given inertia is wrong."""

QUICKEST = 0.07
"""Least integral time ``Kp/Ki`` that is used, s: a plan does not change faster because the loop is faster."""

PROVES = 3.0
"""Time for which a joint must follow for a torque to be proven, integral times."""

PROVES_AGAIN = 8.0
"""The same for a drive that has seemed to saturate."""

CLOSE = 0.1
"""Largest error over the plan, and half of ``Kp |e|`` over ``R``, of a joint that follows before anything is proven."""

CLOSE_DOUBTED = 0.02
"""Largest error over the plan before anything is proven, of a drive that has been fully doubted."""

CLOSER = 0.05
"""Largest error over the plan, and ``Kp |e|`` over ``R`` (or ``2 R_p`` if less), after something is proven."""

CLOSEST = 0.005
"""Error over the plan that is always allowed then, and the largest one for a drive that has seemed to saturate.

Without the latter, one of 100 machines that saturate winds up for ever, to 128 times PI's error (seeds 301 and 401).
"""

LAGS = 0.05
"""Error over the plan beyond which a joint lags behind it."""

NOISY = 2.0
"""Standard deviations of the noise that count neither as error nor as resistance."""

GROWS = 1.5
"""Largest factor by which a proven resistance grows at once."""

SETTLES = 10.0
"""Time constant with which the proven resistance falls while the joint follows with less, s."""

BELIEVED, GIVEN = 1.3, 2.0
"""Largest resistance that is learnt from, and largest that a drive is assumed to overcome, over the proven one."""

MEAN = 4.0
"""Longest memory of the mean before anything is proven, integral times."""

MOVES = 0.2
"""Least velocity along the torque, over the plan, of a joint that moves."""


class Motion(NamedTuple):
    """What the motion over a period shows of the torque.

    Attributes
    ----------
    asked, moved, error : float
        Torque asked for less the known torque, torque of the inertia (both N m), and error (rad/s), all low-passed.
    accelerates : float
        Torque that the inertia takes at most, N m.
    resists : float
        Resistance ``R``, N m: what resists the torque beyond the inertia.
    moves, follows : bool
        Whether the joint moves along the torque, and whether it follows its plan.
    lags, close : bool
        Whether it lags behind its plan, and whether it is close to it.
    difference_noise, error_noise : float
        Noise in the torque of the inertia, and in the proportional torque of the error, N m.
    """

    asked: float
    moved: float
    error: float
    accelerates: float
    resists: float
    moves: bool
    follows: bool
    lags: bool
    close: bool
    difference_noise: float
    error_noise: float


class Proof(NamedTuple):
    """What has been proven; fields as of :class:`~adaptive_ff.adaptive.faults.drive_limit_state.DriveLimit`."""

    proven: float
    usual: float
    moving: float
    follows: float
    shown: float
    rising: RisingResistance


@register_jitable
def smooth(before: float, now: float, share: float) -> float:
    """Return a low-passed value that takes a share of each new one."""
    return before + share * (now - before)


@register_jitable
def answers_in(feedback: PIParameters) -> float:
    """Return the integral time of the loop, s, or the least one that is used."""
    return max(QUICKEST, feedback.proportional / feedback.integral) if feedback.integral > 0.0 else QUICKEST


@register_jitable
def largest_lack(state: DriveLimit, proportional: float, resists: float, plan: float) -> float:
    """Return the largest ``Kp |e|`` (N m) of a joint that follows its plan (rad/s) against a resistance (N m)."""
    answer = proportional * abs(plan)
    if state.proven == 0.0:
        return min(2.0 * CLOSE * resists, (CLOSE_DOUBTED if state.suspect else CLOSE) * answer)
    if state.established:
        return min(CLOSER * state.proven, CLOSEST * answer)
    close = CLOSER * min(min(abs(resists), GIVEN * state.proven), answer)
    return max(close, CLOSEST * answer)


@register_jitable
def motion_over(
    state: DriveLimit,
    feedback: PIParameters,
    inertia: float,
    torque: float,
    plan: float,
    velocity: float,
    slowest: float,
    variance: float,
    duration: float,
) -> Motion:
    """Return the motion; parameters as of :func:`~adaptive_ff.adaptive.faults.drive_limit.advance_drive_limit`."""
    gain = feedback.proportional
    share = gain * duration / (gain * duration + SMOOTH * inertia)
    asked = smooth(state.torque, torque, share)
    moved = smooth(state.moved, inertia * (velocity - state.velocity) / duration, share)
    error = smooth(state.error, plan - velocity, share)
    direction = 1.0 if asked > 0.0 else -1.0
    resists = direction * (asked - moved) - WRONG_INERTIA * abs(moved)
    error_noise = gain * (NOISY * math.sqrt(0.5 * share * variance))
    return Motion(
        asked=asked,
        moved=moved,
        error=error,
        accelerates=max(direction * moved, 0.0) + WRONG_INERTIA * abs(moved),
        resists=resists,
        moves=direction * velocity > max(MOVES * abs(plan), slowest),
        follows=gain * abs(error) < max(error_noise, largest_lack(state, gain, resists, plan)),
        lags=direction * error > LAGS * abs(plan),
        close=abs(error) < CLOSE * abs(plan),
        difference_noise=NOISY * inertia / duration * share * math.sqrt(2.0 * variance / (2.0 - share)),
        error_noise=error_noise,
    )


@register_jitable
def advance_proof(state: DriveLimit, motion: Motion, speed: float, integral_time: float, duration: float) -> Proof:
    """Return what is proven after a period (s) of motion at a speed (rad/s), for an integral time (s)."""
    proven, usual, moving, follows = state.proven, state.usual, state.moving, state.follows
    shown, rising, resists = state.shown, state.rising, motion.resists
    if motion.moves and (proven == 0.0 or (motion.follows and resists > 0.0)):
        rising = advance_rising_resistance(rising, speed, resists, integral_time, duration)
    if motion.moves:
        if proven == 0.0:
            usual = smooth(usual, resists, duration / (duration + min(moving, MEAN * integral_time)))
            moving += duration
        if not motion.follows:
            follows = max(0.0, follows - duration)
        elif resists > proven:
            follows += duration
            shown = smooth(shown, resists, duration / follows)
        elif resists > 0.0:
            proven = smooth(proven, resists, duration / SETTLES)
    if follows > (PROVES_AGAIN if state.established else PROVES) * integral_time:
        shown = max(shown, resists)
        proven = shown if proven == 0.0 else min(shown, GROWS * proven)
        follows = 0.0
    return Proof(proven, usual, moving, follows, shown, rising)


@register_jitable
def known_resistance(proof: Proof, speed: float) -> float:
    """Return the resistance ``R_p`` at a speed (rad/s), N m: the proven one, or the mean before there is one."""
    is_proven = proof.proven > 0.0
    return risen(proof.rising, proof.proven if is_proven else proof.usual, speed, is_proven)
