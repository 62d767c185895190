"""Torque that a drive is proven to give: what the joint has followed its plan with.

See :mod:`adaptive_ff.adaptive.faults.drive_limit` for what is made of it.
"""

import math
from typing import NamedTuple

from numba.extending import register_jitable

from adaptive_ff.adaptive.faults.drive_limit_state import DriveLimit
from adaptive_ff.adaptive.faults.rising_resistance import RisingResistance, advance_rising_resistance, risen
from controllers import PIParameters

SMOOTH = 2.0
"""Time constant of the low-passes, in those of the proportional loop ``J/Kp``."""

TOLD_WRONG = 0.3
"""Share of the inertia's torque that may be missing for an inertia that is told wrong."""

QUICKEST = 0.07
"""Least integral time ``Kp/Ki`` that is reckoned with, s: a plan does not change faster because the loop is faster."""

PROVES = 3.0
"""Time for which a joint must follow for a torque to be proven, integral times."""

PROVES_AGAIN = 8.0
"""The same for a drive that has seemed to saturate."""

CLOSE = 0.1
"""Error ``e`` with which a joint follows before anything is proven, over the plan; ``Kp e`` is at most ``0.2 R``."""

CLOSER = 0.05
"""Both afterwards, but that ``R`` counts as ``2 R_p`` at most."""

CLOSEST = (0.02, 0.005)
"""Error over the plan for a drive that has saturated since the first motion; and for larger torques than are proven.

The latter is always allowed, and the largest one allowed to a drive that has seemed to saturate. Without that rule, one
of 100 machines that saturate wound up for ever, to 128 times the error of PI (seeds 301 and 401).
"""

LAGS = 0.05
"""Error with which it does, over the plan."""

NOISY = 2.0
"""Standard deviations of the noise that are no error, and no resistance."""

GROWS = 1.5
"""Largest factor by which a proven resistance grows at a time."""

SETTLES = 10.0
"""Time constant with which it falls to what is needed while the joint follows with less, s."""

BELIEVED, GIVEN = 1.3, 2.0
"""Resistance that is learnt from, and the largest that a drive is taken to overcome, over the proven one."""

MEAN = 4.0
"""Longest memory of the mean before anything is proven, integral times."""

MOVES = 0.2
"""Velocity along the torque, over the plan, with which a joint moves."""


class Motion(NamedTuple):
    """What the motion over a period tells of the torque.

    Attributes
    ----------
    asked, moved, error : float
        Torque that is asked for beyond what is known, that of the inertia (N m), and error (rad/s), all low-passed.
    accelerates : float
        Torque that the inertia takes at most, N m.
    resists : float
        What resists the torque beyond the inertia, ``R``, N m.
    moves, follows : bool
        Whether the joint moves along the torque, and whether it follows its plan.
    lags, close : bool
        Whether it is behind its plan, and whether it is near it, where nothing is proven.
    difference_noise, error_noise : float
        What noise makes of the torque of the inertia, and what the feedback makes of that of the error, N m.
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
    """Return the integral time that is reckoned with, s."""
    return max(QUICKEST, feedback.proportional / feedback.integral) if feedback.integral > 0.0 else QUICKEST


@register_jitable
def largest_lack(state: DriveLimit, proportional: float, resists: float, plan: float) -> float:
    """Return what the feedback may make of the error of a joint that follows its plan (rad/s), N m."""
    answer = proportional * abs(plan)
    if state.proven == 0.0:
        return min(2.0 * CLOSE * resists, (CLOSEST[0] if state.suspect else CLOSE) * answer)
    if state.established:
        return min(CLOSER * state.proven, CLOSEST[1] * answer)
    close = CLOSER * min(min(abs(resists), GIVEN * state.proven), answer)
    return max(close, CLOSEST[1] * answer)


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
    """Return what a period tells; parameters: :func:`adaptive_ff.adaptive.faults.drive_limit.advance_drive_limit`."""
    gain = feedback.proportional
    share = gain * duration / (gain * duration + SMOOTH * inertia)
    asked = smooth(state.torque, torque, share)
    moved = smooth(state.moved, inertia * (velocity - state.velocity) / duration, share)
    error = smooth(state.error, plan - velocity, share)
    direction = 1.0 if asked > 0.0 else -1.0
    resists = direction * (asked - moved) - TOLD_WRONG * abs(moved)
    error_noise = gain * (NOISY * math.sqrt(0.5 * share * variance))
    return Motion(
        asked=asked,
        moved=moved,
        error=error,
        accelerates=max(direction * moved, 0.0) + TOLD_WRONG * abs(moved),
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
    """Return the resistance at a speed (rad/s), N m: the proven one, or the mean before there is one."""
    is_proven = proof.proven > 0.0
    return risen(proof.rising, proof.proven if is_proven else proof.usual, speed, is_proven)
