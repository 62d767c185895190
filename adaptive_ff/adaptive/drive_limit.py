"""Torque that a drive is asked for and does not give, found out where it neither reports nor is told a limit.

A drive that saturates moves the joint with less torque than is asked for. The integral of the feedback winds up, and
friction learnt from torque that never acted would be fed on top of it; so would the disturbance that is observed. A
limit is not seen from one sample: a load looks the same. But with a load the joint follows its plan again once the loop
has answered, beside a limit it does not. So **a torque is proven once the joint has followed its plan with it** for
three of the loop's integral times. What resists the torque beyond the inertia, low-passed,

    R = +-(u - u_known - J a) - 0.3 |J a|     (along the torque; 0.3 for an inertia that is told wrong)

is compared with the largest one ``R_p`` proven so far (of the time in which the joint followed the mean, or the last
if that is larger):

    R > 1.3 R_p                 nothing is learnt from such torque,
    |u| > J a + 2 R_p           and the drive is taken to have given no more than that;

where that lasts and the joint does not follow, friction and observer fade, so that the feedback is alone, and proof is
asked to be better. Of what fades the integral takes over no more than acted. Before anything is proven, the mean of
``R`` stands for ``R_p`` (half as much again is believed while the joint does not lag), and of friction and observer no
more is fed than a quarter above what the feedback has asked for itself; where even so the doubt lasts, all that was
learnt is forgotten once the joint follows. A drive that has been doubted for long is given another chance, after twice
the time the next: what was proven may have been little, and the feedback alone never follows closely enough to prove
more. With friction fed again it does, and is not doubted while it follows: else no chance would last long enough to
prove anything, and one of five hinges in MuJoCo (100 Hz, moves) stayed without compensation.

Not proven is what a joint on its way out of a long rest asks for: what broke it loose is believed for a while. And
``R_p`` is raised by what friction adds that goes on rising with the speed (``rising_resistance.py``).
"""

import math
from typing import Any, NamedTuple

from numba.extending import register_jitable

from adaptive_ff.adaptive.rising_resistance import (
    RisingResistance,
    advance_rising_resistance,
    can_be_judged,
    initial_rising_resistance,
    judged,
    risen,
)
from adaptive_ff.adaptive.step import gate_speed
from controllers import Inputs, PIParameters, asked_torque, delayed, with_realised_torque

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

IMPOSSIBLE = 4.0
"""Friction at breakaway over the proven resistance from which on it cannot be: it was learnt from other torque.

It is forgotten at the first proof, and later on as much of it is fed as can be. One machine of 210 that had learnt 430
times its friction before it followed threw itself by 180 times the error of PI later on (seed 701).
"""

NOISY = 2.0
"""Standard deviations of the noise that are no error, and no resistance."""

GROWS = 1.5
"""Largest factor by which a proven resistance grows at a time."""

SETTLES = 10.0
"""Time constant with which it falls to what is needed while the joint follows with less, s."""

BELIEVED, GIVEN = 1.3, 2.0
"""Resistance that is learnt from, and the largest that a drive is taken to overcome, over the proven one."""

UNPROVEN = 1.5
"""Factor on both while nothing is proven and the joint does not lag."""

LAGS = 0.05
"""Error with which it does, over the plan."""

MEAN, BEGINS = 4.0, 2.0
"""Longest memory of the mean before anything is proven, and the motion before it counts, integral times."""

MOVES = 0.2
"""Velocity along the torque, over the plan, with which a joint moves."""

BROKEN = 4.0
"""Time constant with which the torque is forgotten that broke a joint loose, integral times."""

DOUBTED = 2.0
"""Doubt lasts for so many integral times before what is fed begins to fade; after twice that nothing is fed."""

ANSWERED = 1.25
"""Friction, and observed torque, that are fed at most before anything is proven, over what the feedback has asked for.

What is fed beside a limit winds up on top of the feedback, and that on top of it. Of 1600 drives that saturate (seeds
101, 201, 301 and 401) 41 were below 0.95 of PI before this bound and :func:`without_never_given`, and 18 are with
them. Where drives do not saturate, the first seconds have 1.01 to 1.12 times the error that they had (400 of them).
"""

LOOSENS = 60.0
"""Time constant with which that bound grows while nothing is doubted, integral times.

A joint that it keeps from following would never prove anything: one of 400 that do not saturate (seeds 301 and 401) was
4.2 times better than PI instead of 58.
"""

PATIENCE = 60.0
"""Motion after which a drive that has seemed to saturate is given another chance, integral times; doubled each time.

An arm that had followed slowly at first was fed half of its friction for good, and was 3.0 times better than PI for the
9.2 times that it is now (``benchmarks.robot``, two links at 500 Hz). Of 400 drives that do saturate (seeds 101 and 201)
as many settle at 0.95 of PI as without it, with 30 integral times one less.
"""


class DriveLimit(NamedTuple):
    """What the motion has shown of the drive.

    Attributes
    ----------
    torque, moved, error : float
        Torque that is asked for beyond what is known, that of the inertia (N m), and error (rad/s), all low-passed.
    velocity : float
        Last measured velocity, rad/s.
    proven : float
        Largest resistance with which the joint has followed, N m; zero before there is one.
    usual : float
        Mean resistance in motion before anything is proven, N m.
    moving : float
        How long it has moved until then, s.
    follows : float
        For how long it has followed with a larger resistance than the proven one, s.
    stuck : float
        For how long it has stood, s.
    broke : float
        Resistance with which it broke loose, fading, N m.
    doubt : float
        How long the drive has been asked for more than is believed, in the time that is waited; 2 at most.
    suspect : bool
        Whether it has been for that long before anything was proven.
    unproven : bool
        Whether it is asked for more than is believed.
    given : float
        Torque that it is taken to give at most, N m beyond what is known; zero where there is no reason for a limit.
    largest : float
        Largest torque so far that was not believed, N m.
    anew : bool
        Whether what was learnt is to be forgotten now.
    established : bool
        Whether the drive has seemed to saturate with more than is proven, and no more has been proven since.
    waited : float
        How long the joint has moved since then, s.
    patience : float
        After how long it is given another chance, integral times.
    shown : float
        Mean resistance for the time that ``follows`` counts, N m.
    answered : float
        Largest torque that the feedback has asked for, growing slowly, N m.
    bounded : bool
        Whether that bounds what is fed: until the drive has reported its torque once, and where no model was given.
    rising : RisingResistance
        How the resistance rises with the speed.
    """

    torque: float
    moved: float
    error: float
    velocity: float
    proven: float
    usual: float
    moving: float
    follows: float
    stuck: float
    broke: float
    doubt: float
    suspect: bool
    unproven: bool
    given: float
    largest: float
    anew: bool
    established: bool
    waited: float
    patience: float
    shown: float
    answered: float
    bounded: bool
    rising: RisingResistance


def initial_drive_limit(*, model_given: bool = False) -> DriveLimit:
    """Return the state before any motion, where a model of the joint was given or not."""
    return DriveLimit(
        torque=0.0,
        moved=0.0,
        error=0.0,
        velocity=0.0,
        proven=0.0,
        usual=0.0,
        moving=0.0,
        follows=0.0,
        stuck=0.0,
        broke=0.0,
        doubt=0.0,
        suspect=False,
        unproven=False,
        given=0.0,
        largest=0.0,
        anew=False,
        established=False,
        waited=0.0,
        patience=PATIENCE,
        shown=0.0,
        answered=0.0,
        bounded=not model_given,
        rising=initial_rising_resistance(),
    )


@register_jitable
def smooth(before: float, now: float, share: float) -> float:
    """Return a low-passed value that takes a share of each new one."""
    return before + share * (now - before)


@register_jitable
def believed_share(state: DriveLimit, friction: float) -> float:
    """Return the share of friction and observer that is fed, for a friction at breakaway (N m)."""
    share = min(1.0, 2.0 - state.doubt)
    if state.proven > 0.0 and friction > IMPOSSIBLE * state.proven:
        share *= IMPOSSIBLE * state.proven / friction
    return share


@register_jitable
def is_believed(state: DriveLimit) -> bool:
    """Return whether no torque was asked for beyond what is learnt from."""
    return state.largest == 0.0 or state.largest <= BELIEVED * state.proven


@register_jitable
def given_torque(state: DriveLimit, torque: float, known: float) -> float:
    """Return what the drive is taken to have given of a torque, of which a part is known from elsewhere, N m."""
    if state.given == 0.0:
        return torque
    return known + min(max(torque - known, -state.given), state.given)


@register_jitable
def answered_share(state: DriveLimit, torque: float) -> float:
    """Return the share of friction, or of observed torque (N m), that is fed before anything is proven."""
    bound = ANSWERED * state.answered
    if state.bounded and state.proven == 0.0 and 0.0 < bound < abs(torque):
        return bound / abs(torque)
    return 1.0


@register_jitable
def without_never_given(state: DriveLimit, leaves: float, integral: float) -> float:
    """Return what leaves the integral (N m) when it takes over nothing that the drive is believed not to have given."""
    if not state.unproven or leaves * integral >= 0.0:
        return leaves
    never_given = max(0.0, abs(state.torque) - BELIEVED / GIVEN * state.given)
    return math.copysign(max(0.0, abs(leaves) - never_given), leaves)


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
def answers_in(feedback: PIParameters) -> float:
    """Return the integral time that is reckoned with, s."""
    return max(QUICKEST, feedback.proportional / feedback.integral) if feedback.integral > 0.0 else QUICKEST


@register_jitable
def advance_drive_limit(
    state: DriveLimit,
    feedback: PIParameters,
    inertia: float,
    torque: float,
    plan: float,
    velocity: float,
    slowest: float,
    variance: float,
    answer: float,
    duration: float,
) -> DriveLimit:
    """Return the state after a period.

    Parameters
    ----------
    state : DriveLimit
        The state.
    feedback : PIParameters
        The PI loop.
    inertia : float
        Inertia that it was designed for, kg m^2.
    torque : float
        Torque that was asked for over the period, without what is known from elsewhere, N m.
    plan, velocity : float
        What the feedback follows, and measured velocity, now, rad/s.
    slowest : float
        Speed below which the joint may stick, rad/s.
    variance : float
        Variance of the measured velocity, rad^2/s^2.
    answer : float
        Torque that the feedback asks for now, N m.
    duration : float
        Length of the period, s.
    """
    gain, time = feedback.proportional, answers_in(feedback)
    share = gain * duration / (gain * duration + SMOOTH * inertia)
    asked = smooth(state.torque, torque, share)
    moved = smooth(state.moved, inertia * (velocity - state.velocity) / duration, share)
    error = smooth(state.error, plan - velocity, share)
    direction = 1.0 if asked > 0.0 else -1.0
    resists = direction * (asked - moved) - TOLD_WRONG * abs(moved)
    noise = NOISY * math.sqrt(0.5 * share * variance)
    follows = gain * abs(error) < max(gain * noise, largest_lack(state, gain, resists, plan))
    moves = direction * velocity > max(MOVES * abs(plan), slowest)
    proven, usual, moving, following = state.proven, state.usual, state.moving, state.follows
    shown, rising = state.shown, state.rising
    if moves and (proven == 0.0 or (follows and resists > 0.0)):
        rising = advance_rising_resistance(rising, abs(velocity), resists, time, duration)
    if moves:
        if proven == 0.0:
            usual = smooth(usual, resists, duration / (duration + min(moving, MEAN * time)))
            moving += duration
        if not follows:
            following = max(0.0, following - duration)
        elif resists > proven:
            following += duration
            shown = smooth(shown, resists, duration / following)
        elif resists > 0.0:
            proven = smooth(proven, resists, duration / SETTLES)
    if following > (PROVES_AGAIN if state.established else PROVES) * time:
        shown = max(shown, resists)
        proven = shown if proven == 0.0 else min(shown, GROWS * proven)
        following = 0.0
    stuck = state.stuck + duration if abs(velocity) <= slowest else 0.0
    broke = state.broke * math.exp(-duration / (BROKEN * time))
    if moves and state.stuck > time:
        broke = min(resists, GIVEN * proven)
    known = risen(rising, proven if proven > 0.0 else usual, abs(velocity), proven > 0.0)
    factor = 1.0 if proven > 0.0 or direction * error > LAGS * abs(plan) else UNPROVEN
    given, unproven = 0.0, False
    if known > 0.0 and abs(velocity) > slowest and (proven > 0.0 or (moves and moving > BEGINS * time)):
        given = max(direction * moved, 0.0) + TOLD_WRONG * abs(moved) + max(factor * GIVEN * known, broke)
        differences = NOISY * inertia / duration * share * math.sqrt(2.0 * variance / (2.0 - share))
        unproven = resists > max(factor * BELIEVED * known, broke) + differences + gain * noise
    doubt = state.doubt
    if moves and unproven:
        if proven == 0.0 or not follows:  # a joint that follows is about to prove it
            doubt = min(2.0, doubt + duration / (DOUBTED * time))
    elif moves and (proven > 0.0 or abs(error) < CLOSE * abs(plan)):
        doubt = max(0.0, doubt - duration / (DOUBTED * time))
    suspect = proven == 0.0 and (state.suspect or doubt == 2.0)
    if suspect and can_be_judged(rising, time):
        rising = judged(rising)
        suspect, doubt = not rising.believed, 0.0
    if suspect:
        unproven, doubt = True, 2.0
    established = proven > 0.0 and not proven > state.proven and (state.established or doubt == 2.0)
    waited, patience = state.waited + duration if moves else state.waited, state.patience
    if not established:
        waited = 0.0
    if waited > patience * time:
        established, doubt, following, waited, patience = False, 0.0, 0.0, 0.0, 2.0 * patience
    answered = max(state.answered, abs(answer))
    if moves and doubt == 0.0:
        answered *= 1.0 + duration / (LOOSENS * time)
    largest = max(state.largest, abs(asked)) if moves and unproven else state.largest
    return DriveLimit(
        torque=asked,
        moved=moved,
        error=error,
        velocity=velocity,
        proven=proven,
        usual=usual,
        moving=moving,
        follows=following,
        stuck=stuck,
        broke=broke,
        doubt=doubt,
        suspect=suspect,
        unproven=unproven,
        given=given,
        largest=largest,
        anew=state.suspect and not suspect,
        established=established,
        waited=waited,
        patience=patience,
        shown=shown,
        answered=answered,
        bounded=state.bounded,
        rising=rising,
    )


@register_jitable
def reassured(state: DriveLimit, feedback: PIParameters, duration: float) -> DriveLimit:
    """Return the state after a period (s) whose torque the drive reports: doubt goes, what is proven stays."""
    if state.doubt == 0.0 and not (state.unproven or state.bounded):
        return state
    doubt = max(0.0, state.doubt - duration / (DOUBTED * answers_in(feedback)))
    return DriveLimit(
        torque=state.torque,
        moved=state.moved,
        error=state.error,
        velocity=state.velocity,
        proven=state.proven,
        usual=state.usual,
        moving=state.moving,
        follows=state.follows,
        stuck=state.stuck,
        broke=state.broke,
        doubt=doubt,
        suspect=state.suspect and doubt > 0.0,
        unproven=False,
        given=0.0,
        largest=state.largest,
        anew=False,
        established=state.established,
        waited=state.waited,
        patience=state.patience,
        shown=state.shown,
        answered=state.answered,
        bounded=False,
        rising=state.rising,
    )


@register_jitable
def watch_drive(block: Any, state: Any, inputs: Inputs) -> tuple[DriveLimit, Inputs]:
    """Return what is known of a drive that tells nothing of its torque, and the inputs with the torque it has given."""
    if math.isfinite(inputs.realised_torque):
        return reassured(state.drive, block.feedback, inputs.dt), inputs
    if state.feedback.samples == 0 or not math.isfinite(inputs.velocity):
        return state.drive, inputs
    asked, known = asked_torque(block.feedback, state.feedback), delayed(state.known_torques, block.feedback.delay)
    plan = inputs.reference + inputs.correction
    drive = advance_drive_limit(
        state.drive,
        block.feedback,
        block.observer.inertia,
        float(asked - known),
        plan,
        inputs.velocity,
        float(gate_speed(block, state.estimator)),
        state.observer.noise.variance,
        block.feedback.proportional * (plan - inputs.velocity) + state.feedback.integral,
        inputs.dt,
    )
    return drive, with_realised_torque(inputs, given_torque(drive, asked, known))


@register_jitable
def is_impossible(before: DriveLimit, now: DriveLimit, friction: float) -> bool:
    """Tell at the first proof whether a friction at breakaway (N m) is far beyond what a joint follows with."""
    return before.proven == 0.0 and now.proven > 0.0 and friction > IMPOSSIBLE * now.proven
