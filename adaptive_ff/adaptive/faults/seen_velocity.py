"""Measured velocities that are finite and possible, and yet wrong: leaps, and values that are repeated to the bit.

**Leaps.** In a period the torque changes a velocity by ``u dt/J``, and friction and loads change it by a few times what
the largest torque that the motion has needed does. So a velocity is a *leap*, and counts as not measured, where it is
further than

    3 T dt/J + 8 s,      T = max(largest torque so far, 0.25 Kp w_p)

from all that the torque of the drive can have made, both of the last value and of the last accepted one. ``s`` is the
standard deviation of the noise, ``w_p`` the largest speed of the plan
(:func:`adaptive_ff.adaptive.faults.doubt.possible_speed`). The torque of the drive need not have acted, and the inertia
may be 2.5 times smaller than assumed: all between is explained. Without that, joints whose inertia varies by 60 % over
the position, which hunt where it is smallest, would lose up to half their accuracy. After three leaps in a row the
velocity is accepted, since what stays is true.

**Repeated values.** A sensor that loses a message often gives the last value once more; one that is slower than the
loop always does. A velocity that is repeated to the bit, of a joint that does not stand, is *held*, and counts as not
measured,

- if the sensor resolves velocities finely, that is, if less than a twentieth of its changes have been near the least
  one. (An encoder with few counts, whose changes are one count or two, repeats values as well.)
- otherwise once the plan has moved by four times the larger of noise and least change.

**What follows.**

- *The observer* bridges what is not measured, and takes the difference over the whole gap. A difference over one period
  would make thousands of newton metres of a leap; of a held value, that the joint does not answer to its torque.
- *The estimator* leaves such samples out as it does lost ones. Where they are more than 0.15 of all it uses them, since
  a sensor that is slower than the loop would leave nothing to learn from.
- *The feedback* follows every value, as PI alone does, but compares a value that is not accepted with the plan of the
  time of the last accepted one.

Evidence: on the built-in joint (six references, seeds 101 to 106), a leap of 3 rad/s in one of 1000 samples leaves 1.5
to 2.9 of PI's accuracy, if it is accepted 0.33 to 0.65; values held for ten samples leave 3.5 to 5.7, accepted 0.8 to
2.8. Of the rows of ``benchmarks.never_worse`` without such faults one differs, by 0.01 of 1.36.
"""

import math
from typing import Any, NamedTuple

from numba.extending import register_jitable

from adaptive_ff.adaptive.faults.doubt import possible_speed
from adaptive_ff.adaptive.supervision.noise_level import NoiseState, filled_mean, noise_known
from adaptive_ff.friction.bounds import INERTIA
from controllers import Inputs, acting_torque, asked_torque, with_velocity

LEAP = 3.0
"""Largest accepted change of the velocity, over that of the largest torque: with 2 and 5 hardly anything differs."""

LIGHTER = 2.5
"""Assumed inertia over the least one that the torque of the drive may move."""

LIKELY = 0.25
"""Least value of that torque, over the proportional torque for the largest speed of the plan."""

NOISY = 8.0
"""Standard deviations of the noise that are accepted beside that."""

ROUGHLY = 0.1
"""Time of measurement from which on the noise is known roughly, s."""

LONGEST = 3
"""Largest number of leaps in a row that are not accepted."""

FINE, NEAR = 0.05, 2.5
"""Share of the changes below which few are near the least one, and up to how many times that one is near it."""

STANDS = 1e-3
"""Velocity up to which a joint stands, so that its sensor may repeat itself, over the largest speed."""

ROUNDED = 1e-9
"""Change of a velocity, over the largest speed, up to which it is rounding: of a difference of positions.

If rounding counted, it would be the least change, with none of an encoder's steps near it, and every value that comes
twice would be held. Moves behind a position loop with an encoder of 6 urad at 500 Hz would settle at 4 to 14 times
better than PI, not at 23 to 94 times (``benchmarks.smooth_friction``, 2 kg m^2, seeds 105 and 106).
"""

MOVED = 4.0
"""Change of the plan beyond which a value that a coarse sensor repeats is held, in noise levels or least changes."""

OFTEN, LATELY = 0.15, 10.0
"""Share of such samples up to which the estimator leaves them out, and the time over which it is taken, s."""

WHOLE, MOST = 1e-3, 1e6
"""How closely changes are whole multiples of the least one, up to how many times it, if they are counts."""

ALIKE = 1e-6
"""How closely a velocity falls by the same factor as before, as behind a low-pass between two counts."""


class SeenVelocity(NamedTuple):
    """What is remembered of measured velocities.

    Attributes
    ----------
    last, believed : float
        The last velocity, and the last accepted one, rad/s.
    falls, rises : float
        Largest changes down and up since the latter that the torque of the drive can have made, rad/s.
    gap : float
        Time since the last accepted velocity, s.
    plan : float
        Plan when the present value came first, rad/s.
    finest : float
        Least change from one sample to the next so far, rad/s; zero before there was one.
    changes, fine : float
        Number of changes so far, and of those near the least one.
    leapt : int
        Number of leaps in a row.
    missing : bool
        Whether the present velocity counts as not measured.
    share : float
        Share of the samples of late whose velocity counts so.
    leaps : int
        Number of leaps so far.
    multiples : float
        Number of changes that have been whole multiples of the least one.
    ratio : float
        Velocity over the one before where it has fallen towards zero, and zero where it has not.
    decays : float
        Number of times that it has fallen by the same factor twice in a row.
    """

    last: float
    believed: float
    falls: float
    rises: float
    gap: float
    plan: float
    finest: float
    changes: float
    fine: float
    leapt: int
    missing: bool
    share: float
    leaps: int
    multiples: float
    ratio: float
    decays: float


class Resolution(NamedTuple):
    """Resolution of the sensor; fields as of :class:`SeenVelocity`."""

    finest: float
    changes: float
    fine: float
    multiples: float
    ratio: float
    decays: float


def initial_seen_velocity() -> SeenVelocity:
    """Return the state before anything was measured."""
    return SeenVelocity(
        last=0.0,
        believed=0.0,
        falls=0.0,
        rises=0.0,
        gap=0.0,
        plan=0.0,
        finest=0.0,
        changes=0.0,
        fine=0.0,
        leapt=0,
        missing=False,
        share=0.0,
        leaps=0,
        multiples=0.0,
        ratio=0.0,
        decays=0.0,
    )


@register_jitable
def distance(value: float, least: float, most: float) -> float:
    """Return how far a value lies outside a range."""
    return max(value - most, least - value, 0.0)


@register_jitable
def noise_level(noise: NoiseState) -> float:
    """Return the standard deviation of the noise (rad/s), a rough one before it is known; negative at the start."""
    if noise_known(noise):
        return math.sqrt(noise.variance)
    return math.sqrt(filled_mean(noise.mean, noise.measured)) if noise.measured > ROUGHLY else -1.0


@register_jitable
def is_held(seen: SeenVelocity, moved: float, deviation: float) -> bool:
    """Tell whether a velocity that is repeated is held, and so not measured.

    Parameters
    ----------
    seen : SeenVelocity
        What is remembered, with this sample.
    moved : float
        Change of the plan since the value came first, rad/s.
    deviation : float
        Standard deviation of the noise, rad/s; zero where it is not known.
    """
    few_are_near = seen.fine < FINE * seen.changes
    return few_are_near or (seen.finest > 0.0 and abs(moved) > MOVED * max(deviation, seen.finest))


@register_jitable
def is_whole(ratio: float) -> bool:
    """Tell whether a ratio is a whole number but for rounding, and not too large to tell."""
    return ratio < MOST and abs(ratio - int(ratio + 0.5)) < WHOLE


@register_jitable
def has_leapt(seen: SeenVelocity, before: float, change: float, rate: float, duration: float, noise: float) -> bool:
    """Tell whether the last velocity is a leap: one that the joint cannot have.

    Parameters
    ----------
    seen : SeenVelocity
        What is remembered, with this sample, as if it were not accepted.
    before : float
        The velocity before, rad/s.
    change : float
        Largest change that the torque of the drive makes in the period that has ended, rad/s.
    rate : float
        What else may change the velocity, rad/s^2.
    duration : float
        Length of the period, s.
    noise : float
        Change that noise may make, rad/s.
    """
    if distance(seen.last - before, min(0.0, change), max(0.0, change)) - noise <= rate * duration:
        return False
    return distance(seen.last - seen.believed, seen.falls, seen.rises) - noise > rate * seen.gap


@register_jitable
def resolution_after(old: SeenVelocity, velocity: float, possible: float) -> Resolution:
    """Return the resolution after a velocity, for a largest speed ``possible`` of the joint (both rad/s)."""
    difference = abs(velocity - old.last)
    finest, changes, fine, multiples = old.finest, old.changes, old.fine, old.multiples
    if difference > ROUNDED * possible:
        changes += 1.0
        if difference * NEAR < finest or finest == 0.0:
            fine = 0.0
        if finest == 0.0 or difference < (1.0 - WHOLE) * finest:
            multiples = multiples if is_whole(finest / difference) else 0.0
            finest = difference
        if difference < NEAR * finest:
            fine += 1.0
        if is_whole(difference / finest):
            multiples += 1.0
    ratio, decays = 0.0, old.decays
    if velocity * old.last > 0.0 and ROUNDED * possible < abs(velocity) < abs(old.last):
        ratio = velocity / old.last
        if abs(ratio - old.ratio) < ALIKE * ratio:
            decays += 1.0
    return Resolution(finest, changes, fine, multiples, ratio, decays)


@register_jitable
def without_velocity(old: SeenVelocity, falls: float, rises: float, gap: float, share: float) -> SeenVelocity:
    """Return what is remembered after a sample without a velocity; parameters as of :class:`SeenVelocity`."""
    return old._replace(falls=falls, rises=rises, gap=gap, leapt=0, missing=False, share=share)


@register_jitable
def believed(seen: SeenVelocity, leaps: int, share: float) -> SeenVelocity:
    """Return what is remembered if the present velocity is accepted, after so many leaps."""
    return seen._replace(
        believed=seen.last, falls=0.0, rises=0.0, gap=0.0, leapt=0, missing=False, share=share, leaps=leaps
    )


@register_jitable
def advance_seen_velocity(block: Any, state: Any, inputs: Inputs) -> SeenVelocity:
    """Return what is remembered after a sample.

    Parameters
    ----------
    block, state : NamedTuple
        Parameters and state of the supervised controller.
    inputs : Inputs
        Inputs of the sample, with the torque that the drive has probably given.
    """
    old, velocity, duration = state.seen, inputs.velocity, inputs.dt
    torque = acting_torque(inputs, asked_torque(block.feedback, state.feedback), 0.0)
    inertia = min(block.observer.inertia, state.estimator.recursion.estimate[INERTIA])
    change = LIGHTER * torque * duration / inertia
    falls, rises, gap = old.falls + min(0.0, change), old.rises + max(0.0, change), old.gap + duration
    weight = duration / (LATELY + duration)
    share = old.share - weight * old.share
    if not math.isfinite(velocity):
        return without_velocity(old, falls, rises, gap, share)
    level, possible = noise_level(state.observer.noise), possible_speed(block, state)
    shown = resolution_after(old, velocity, possible)
    repeated = velocity == old.last and abs(velocity) > STANDS * possible
    seen = SeenVelocity(
        last=velocity,
        believed=old.believed,
        falls=falls,
        rises=rises,
        gap=gap,
        plan=old.plan if repeated else inputs.reference,
        finest=shown.finest,
        changes=shown.changes,
        fine=shown.fine,
        leapt=0 if repeated else old.leapt + 1,
        missing=True,
        share=share + weight,
        leaps=old.leaps if repeated else old.leaps + 1,
        multiples=shown.multiples,
        ratio=shown.ratio,
        decays=shown.decays,
    )
    missing = False
    if repeated:
        missing = is_held(seen, inputs.reference - seen.plan, max(0.0, level))
    elif level >= 0.0 and seen.leapt <= LONGEST:
        largest = max(state.estimator.levels.torque, LIKELY * block.feedback.proportional * possible)
        missing = has_leapt(seen, old.last, change, LEAP * largest / inertia, duration, NOISY * level)
    return seen if missing else believed(seen, old.leaps, share)


@register_jitable
def seen_inputs(seen: SeenVelocity, inputs: Inputs) -> Inputs:
    """Return the inputs for the estimator: without a velocity that is not accepted, unless many are not."""
    return with_velocity(inputs, math.nan) if seen.missing and seen.share <= OFTEN else inputs
