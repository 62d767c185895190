"""Saturation of a drive that neither reports its torque nor has a known limit, detected from the motion.

A drive that saturates moves the joint with less torque than is asked for. The integral of the feedback winds up.
Friction learnt from torque that never acted would be fed on top of it, and so would the observed torque. A single
sample does not show a limit, since a growing load looks the same. But within its integral time the loop answers to a
load, and the joint follows its plan again; at a limit it does not. So **a torque is proven once the joint has followed
its plan with it** for three integral times of the loop (``proven_torque.py``). Compared is what resists the torque
beyond the inertia, low-passed,

    R = +-(u - u_known - J a) - 0.3 |J a|     (along the torque; 0.3 for a wrong inertia)

with the largest one ``R_p`` proven so far (the mean over the time in which the joint followed, or the last value if
that is larger):

    R > 1.3 R_p                 nothing is learnt from such torque;
    |u| > J a + 2 R_p           the drive is assumed to have given no more than that.

- *Doubt.* Where ``R > 1.3 R_p`` lasts and the joint does not follow, friction and observed torque fade: from two
  integral times on, and in full after four. That leaves the feedback alone. The integral takes over no more of what
  fades than has acted. A drive that was doubted in full must follow more closely, and for eight integral times, to
  prove more.
- *Before anything is proven* the mean of ``R`` stands for ``R_p``, and half as much again is believed while the joint
  does not lag. Unless a model was given, friction and observed torque are each fed up to 1.25 times what the feedback
  has asked for itself. Where doubt grows full all the same, everything learnt is forgotten once the joint follows.
- *Another chance.* After 60 integral times of motion with a drive that has seemed to saturate, the drive is believed
  again; the next time after twice as long, and so on. For what was proven may have been little, and the feedback alone
  never follows closely enough to prove more. With friction fed again the joint follows, and is not doubted while it
  does. Otherwise no chance would last long enough to prove anything; one of five hinges in MuJoCo (100 Hz, moves) would
  stay without compensation.
- *After a long rest* a joint takes more torque to break loose. That proves nothing, but it is believed for a while.
- *Friction that rises with the speed* raises ``R_p`` accordingly (``rising_resistance.py``).
"""

import math
from typing import Any, NamedTuple

from numba.extending import register_jitable

from adaptive_ff.adaptive.faults.drive_limit_state import DriveLimit
from adaptive_ff.adaptive.faults.proven_torque import (
    BELIEVED,
    GIVEN,
    Motion,
    Proof,
    advance_proof,
    answers_in,
    known_resistance,
    motion_over,
)
from adaptive_ff.adaptive.faults.rising_resistance import RisingResistance, can_be_judged, judged
from adaptive_ff.adaptive.learning.fed_model import gate_speed
from controllers import Inputs, PIParameters, asked_torque, delayed, with_realised_torque

IMPOSSIBLE = 4.0
"""Largest possible friction at breakaway, over the proven resistance: more was learnt from torque that never acted.

At the first proof such friction is forgotten; later only the possible part of it is fed. Without this, one machine of
210, which learns 430 times its friction before it follows, later throws itself to 180 times PI's error (seed 701).
"""

UNPROVEN = 1.5
"""Factor on both limits while nothing is proven and the joint does not lag."""

BEGINS = 2.0
"""Motion after which the mean resistance stands for a proven one, integral times."""

BROKEN = 4.0
"""Time constant with which the resistance at which a joint broke loose is forgotten, integral times."""

DOUBTED = 2.0
"""Integral times of doubt after which friction and observed torque begin to fade; after twice that none is fed."""

ANSWERED = 1.25
"""Largest friction, and largest observed torque, fed before anything is proven, over the torque of the feedback.

At a limit, what is fed winds up on top of the feedback, and the feedback on top of it. Of 1600 drives that saturate
(seeds 101, 201, 301 and 401) 18 settle below 0.95 of PI's accuracy, without this bound and :func:`without_never_given`
41. The cost: where drives do not saturate, the first seconds have 1.01 to 1.12 times the error (400 of them).
"""

LOOSENS = 60.0
"""Time constant with which that bound grows while nothing is doubted, integral times.

Otherwise a joint that the bound keeps from following would never prove anything: one of 400 that do not saturate (seeds
301 and 401) would be 4.2 times better than PI instead of 58.
"""


class Limit(NamedTuple):
    """Torque that a drive is assumed to give; fields as of :class:`DriveLimit`."""

    broke: float
    given: float
    unproven: bool


class Suspicion(NamedTuple):
    """How far a drive is doubted; fields as of :class:`DriveLimit`."""

    doubt: float
    suspect: bool
    unproven: bool
    rising: RisingResistance


@register_jitable
def believed_share(state: DriveLimit, friction: float) -> float:
    """Return the share of friction and observer that is fed, for a friction at breakaway (N m)."""
    share = min(1.0, 2.0 - state.doubt)
    if state.proven > 0.0 and friction > IMPOSSIBLE * state.proven:
        share *= IMPOSSIBLE * state.proven / friction
    return share


@register_jitable
def is_believed(state: DriveLimit) -> bool:
    """Tell whether all torque that was asked for so far is believed to have acted."""
    return state.largest == 0.0 or state.largest <= BELIEVED * state.proven


@register_jitable
def given_torque(state: DriveLimit, torque: float, known: float) -> float:
    """Return the torque that the drive is assumed to have given, N m, of one asked for and its known part (N m)."""
    if state.given == 0.0:
        return torque
    return known + min(max(torque - known, -state.given), state.given)


@register_jitable
def answered_share(state: DriveLimit, torque: float) -> float:
    """Return the share of a friction, or of an observed torque (N m), that is fed before anything is proven."""
    bound = ANSWERED * state.answered
    if state.bounded and state.proven == 0.0 and 0.0 < bound < abs(torque):
        return bound / abs(torque)
    return 1.0


@register_jitable
def without_never_given(state: DriveLimit, leaves: float, integral: float) -> float:
    """Return the torque (N m) that leaves the integral, which takes over nothing that has probably never acted."""
    if not state.unproven or leaves * integral >= 0.0:
        return leaves
    never_given = max(0.0, abs(state.torque) - BELIEVED / GIVEN * state.given)
    return math.copysign(max(0.0, abs(leaves) - never_given), leaves)


@register_jitable
def limit_of(
    state: DriveLimit, motion: Motion, proof: Proof, speed: float, slowest: float, integral_time: float, duration: float
) -> Limit:
    """Return the torque that the drive is assumed to give after a period.

    Parameters
    ----------
    state, motion, proof : DriveLimit, Motion, Proof
        State before the period, the motion in it, and what is proven after it.
    speed, slowest : float
        Measured speed, and the one below which the joint may stick, rad/s.
    integral_time, duration : float
        Integral time of the loop, and length of the period, s.
    """
    proven = proof.proven
    broke = state.broke * math.exp(-duration / (BROKEN * integral_time))
    if motion.moves and state.stuck > integral_time:
        broke = min(motion.resists, GIVEN * proven)
    known = known_resistance(proof, speed)
    begun = proven > 0.0 or (motion.moves and proof.moving > BEGINS * integral_time)
    if not (known > 0.0 and speed > slowest and begun):
        return Limit(broke, 0.0, False)
    factor = 1.0 if proven > 0.0 or motion.lags else UNPROVEN
    given = motion.accelerates + max(factor * GIVEN * known, broke)
    believed = max(factor * BELIEVED * known, broke) + motion.difference_noise + motion.error_noise
    return Limit(broke, given, motion.resists > believed)


@register_jitable
def suspicion_of(
    state: DriveLimit, motion: Motion, proof: Proof, unproven: bool, integral_time: float, duration: float
) -> Suspicion:
    """Return the doubt after a period.

    Parameters
    ----------
    state, motion, proof : DriveLimit, Motion, Proof
        As of :func:`limit_of`.
    unproven : bool
        Whether more torque was asked for than is believed.
    integral_time, duration : float
        As of :func:`limit_of`.
    """
    doubt, rising, proven = state.doubt, proof.rising, proof.proven
    if motion.moves and unproven:
        if proven == 0.0 or not motion.follows:  # a joint that follows is about to prove it
            doubt = min(2.0, doubt + duration / (DOUBTED * integral_time))
    elif motion.moves and (proven > 0.0 or motion.close):
        doubt = max(0.0, doubt - duration / (DOUBTED * integral_time))
    suspect = proven == 0.0 and (state.suspect or doubt == 2.0)
    if suspect and can_be_judged(rising, integral_time):
        rising = judged(rising)
        suspect, doubt = not rising.believed, 0.0
    if suspect:
        unproven, doubt = True, 2.0
    return Suspicion(doubt, suspect, unproven, rising)


@register_jitable
def has_waited(state: DriveLimit, moves: bool, established: bool, duration: float) -> float:
    """Return how long the joint has moved since its drive began to seem to saturate, s; zero if it does not seem so."""
    if not established:
        return 0.0
    return state.waited + duration if moves else state.waited


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
        Torque that was asked for over the period, less the known torque, N m.
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
    time, speed = answers_in(feedback), abs(velocity)
    motion = motion_over(state, feedback, inertia, torque, plan, velocity, slowest, variance, duration)
    proof = advance_proof(state, motion, speed, time, duration)
    limit = limit_of(state, motion, proof, speed, slowest, time, duration)
    suspicion = suspicion_of(state, motion, proof, limit.unproven, time, duration)
    doubt, follows, patience = suspicion.doubt, proof.follows, state.patience
    nothing_new = proof.proven > 0.0 and not proof.proven > state.proven
    established = nothing_new and (state.established or doubt == 2.0)
    waited = has_waited(state, motion.moves, established, duration)
    if waited > patience * time:  # another chance
        established, doubt, follows, waited, patience = False, 0.0, 0.0, 0.0, 2.0 * patience
    answered = max(state.answered, abs(answer))
    if motion.moves and doubt == 0.0:
        answered *= 1.0 + duration / (LOOSENS * time)
    disbelieved = motion.moves and suspicion.unproven
    return DriveLimit(
        torque=motion.asked,
        moved=motion.moved,
        error=motion.error,
        velocity=velocity,
        proven=proof.proven,
        usual=proof.usual,
        moving=proof.moving,
        follows=follows,
        stuck=state.stuck + duration if speed <= slowest else 0.0,
        broke=limit.broke,
        doubt=doubt,
        suspect=suspicion.suspect,
        unproven=suspicion.unproven,
        given=limit.given,
        largest=max(state.largest, abs(motion.asked)) if disbelieved else state.largest,
        anew=state.suspect and not suspicion.suspect,
        established=established,
        waited=waited,
        patience=patience,
        shown=proof.shown,
        answered=answered,
        bounded=state.bounded,
        rising=suspicion.rising,
    )


@register_jitable
def reassured(state: DriveLimit, feedback: PIParameters, duration: float) -> DriveLimit:
    """Return the state after a period (s) whose torque the drive reports: doubt fades, what is proven stays."""
    if state.doubt == 0.0 and not (state.unproven or state.bounded):
        return state
    doubt = max(0.0, state.doubt - duration / (DOUBTED * answers_in(feedback)))
    return state._replace(
        doubt=doubt, suspect=state.suspect and doubt > 0.0, unproven=False, given=0.0, anew=False, bounded=False
    )


@register_jitable
def watch_drive(block: Any, state: Any, inputs: Inputs) -> tuple[DriveLimit, Inputs]:
    """Return the state after a sample, and the inputs with the torque that the drive is assumed to have given."""
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
    """Tell whether, at the first proof, a friction at breakaway (N m) is far beyond the proven resistance."""
    return before.proven == 0.0 and now.proven > 0.0 and friction > IMPOSSIBLE * now.proven
