"""Sensors of few counts: what they make the feedback answer, and what observer and friction are worth beside that.

An encoder whose joint moves by less than a count in a period shows a velocity of nought, and of one count in a period
now and then. The feedback answers each with a kick ``Kp s``, where ``s`` is the noise that this is, and where the kicks
are larger than the friction they shake the joint free of it: there is little left to feed. What observer and estimator
make of such counts in the first seconds is many times the friction. So what the feedback makes of the sensor is
compared with the friction ``F`` at breakaway, or with the integral of the feedback where that is more, where the noise
is more than a tenth or a fifth of the plan's largest speed ``w_p``:

    k = sat(s/(0.2 w_p) - 1) sat((Kp s - 0.2 F)/(0.3 F))        (0.1 w_p behind a low-pass)

The observer is used to a share ``1 - k``, and what it gives up the integral takes over only up to the friction: the
rest never acted on the joint as a load. Of the friction no more is fed than the balance of torques tells of
(:mod:`adaptive.supervision.balance`), then without a prior and without a margin: kicks average out along the plan,
whatever they teach the estimator.

``s`` is the noise once that is known, and where counts are told before, the least so far. Behind a low-pass every
sample tells of noise, also the many between two counts, and the least is that of slow motion: there ``s`` is the mean
once the noise is known. Counts are told

- by most samples' bringing no change, and changes near the least one;
- by being whole multiples of the least one;
- behind a low-pass by values that fall by the same factor, sample by sample, until the next count.

The first six changes of a sensor that has stood still may be such counts, unless what the feedback makes of the least
is no more than ``F``: then the joint has stuck, and breaks away. Of a first count nothing is observed.

``python -m benchmarks.coarse_encoders`` prints what comes of it: of 1000 runs with 0.1 to 10 counts in a period at the
largest speed, as differences and behind a low-pass, 56 have a window above 1.2 times PI's error, the worst of 4.29;
without these rules 205, the worst of 30.5. They were chosen on other joints (seeds 601 to 660). With a threshold of a
tenth for differences as well the first window is twice as bad with three counts. With all of what is observed handed
over to the integral a first window of 17 times PI's is left; with nothing of it as many joints have one as with the
part that is.
"""

import math

from numba.extending import register_jitable

from adaptive_ff.adaptive.faults.seen_velocity import SeenVelocity
from adaptive_ff.adaptive.supervision.noise_level import (
    FIRST,
    NoiseState,
    least_deviation,
    noise_known,
    usual_deviation,
)
from adaptive_ff.estimation.shares import TINY, saturated

COARSE, TOO_COARSE = 0.8, 1.6
"""Least change, over the plan's largest speed, from which on the observer is held back, and from which on in full."""

FEW = 3.0
"""Changes from which on counts are told by being whole multiples of the least one, or falls by being alike.

Otherwise the observer of a joint whose encoder changes with most samples feeds back counts for 50 changes: of 40 joints
of another simulator (seeds 501 to 540) with ten sampling periods to a count at the largest speed, one has 9.1 times
PI's error in the first 5 s, with this the worst has 1.9 times.
"""

COUNTS, SURE = 0.2, 50.0
"""Share of the changes near the least one from which on they are counts, and changes from which on that is sure ...

... before, most samples must have brought no change.
"""

ALIKE_SHARE = 0.01
"""Share of the changes that must have been such falls: of a fine sensor behind none 0.004 are, by chance."""

BEGUN = 6.0
"""Changes until which a sensor that repeats itself has shown nothing but the first counts."""

PLAIN, LOW_PASSED = 0.2, 0.1
"""Noise over the largest speed of the plan from which on kicks count, and with twice which in full; behind a low-pass.

The noise is told by second differences, of which a low-pass leaves little.
"""

KICKS, KICKS_MORE = 0.2, 0.3
"""Kicks over the friction from which on they count, and how many more from which on in full."""


@register_jitable
def is_counted(seen: SeenVelocity, samples: int) -> bool:
    """Tell whether a sensor has shown counts, after so many samples."""
    told = seen.changes > SURE or 2.0 * seen.changes < samples
    told = told or (seen.changes >= FEW and seen.multiples == seen.changes)
    return told and seen.changes > 0.0 and seen.fine >= COUNTS * seen.changes


@register_jitable
def fine_share(seen: SeenVelocity, samples: int, peak: float) -> float:
    """Return the share of what is observed that the sensor is fine enough for, after so many samples.

    Where a count in a period is more than the largest speed of the plan (rad/s), the observer sees counts, not torque.
    """
    if not is_counted(seen, samples) or seen.finest <= COARSE * peak:
        return 1.0
    return max(0.0, (TOO_COARSE * peak - seen.finest) / ((TOO_COARSE - COARSE) * peak)) if peak > 0.0 else 0.0


@register_jitable
def first_counts(seen: SeenVelocity, samples: int, kick: float, friction: float) -> bool:
    """Tell whether a sensor that has stood still shows its first changes, and each may be a count that is too coarse.

    Parameters
    ----------
    seen : SeenVelocity
        What is remembered of measured velocities.
    samples : int
        Samples so far.
    kick : float
        What the feedback makes of the least change, N m.
    friction : float
        Friction ``F``, N m.
    """
    few = 0.0 < seen.changes < BEGUN and 2.0 * seen.changes < samples
    return few and kick > friction


@register_jitable
def is_low_passed(seen: SeenVelocity) -> bool:
    """Tell whether a sensor has shown counts behind a low-pass."""
    return seen.decays >= FEW and seen.decays >= ALIKE_SHARE * seen.changes


@register_jitable
def shown_deviation(seen: SeenVelocity, noise: NoiseState) -> float:
    """Return the standard deviation ``s`` (rad/s) of what the sensor makes the feedback answer."""
    return usual_deviation(noise) if is_low_passed(seen) and noise_known(noise) else least_deviation(noise)


@register_jitable
def kicked_share(
    seen: SeenVelocity,
    samples: int,
    noise: NoiseState,
    proportional: float,
    friction: float,
    peak: float,
    duration: float,
) -> float:
    """Return the share ``k`` to which what the feedback makes of the sensor is more than the friction.

    Parameters
    ----------
    seen, samples, friction : SeenVelocity, int, float
        As of :func:`first_counts`.
    noise : NoiseState
        Noise of the measured velocity.
    proportional : float
        Proportional gain, N m s/rad.
    peak : float
        Largest speed of the plan of late, rad/s.
    duration : float
        Length of the period, s.
    """
    known, low_passed = noise_known(noise), is_low_passed(seen)
    if not known and (noise.measured < FIRST * duration or not (low_passed or is_counted(seen, samples))):
        return 0.0
    deviation = shown_deviation(seen, noise)
    least = (LOW_PASSED if low_passed else PLAIN) * peak
    kick = proportional * deviation
    return saturated(deviation / (least + TINY) - 1.0) * saturated(
        (kick - KICKS * friction) / (KICKS_MORE * friction + TINY)
    )


@register_jitable
def spurious_torque(observed: float, before: float, fine: float, kicked: float, friction: float) -> float:
    """Return the part of what is observed that is none (N m), of which the integral takes nothing.

    Parameters
    ----------
    observed, before : float
        What is observed now, and what was a sample ago, N m.
    fine, kicked : float
        Shares of :func:`fine_share` and :func:`kicked_share`.
    friction : float
        Friction at breakaway as it is identified, N m.
    """
    spurious = (1.0 - fine) * (observed - before)
    left = observed - spurious
    return spurious + math.copysign(kicked * max(0.0, abs(left) - friction), left)
