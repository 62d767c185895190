"""Sensors of few counts: how far observer and friction are held back because the feedback answers counts, not motion.

An encoder whose joint moves by less than a count in a period shows a velocity of zero, and now and then one of a count
in a period. This is noise, of the standard deviation ``s``, and the feedback answers it with kicks ``Kp s``. Kicks that
are larger than the friction shake the joint free of it, and little friction is left to feed. What observer and
estimator make of such counts in the first seconds is many times the friction.

**Counts that kick harder than the friction.** With the friction ``F`` at breakaway, or the integral of the feedback
where that is larger, and the largest speed ``w_p`` of the plan, the share to which they do is

    k = sat(s/(0.2 w_p) - 1) sat((Kp s - 0.2 F)/(0.3 F))        (behind a low-pass 0.1 w_p)

- The observer is used with the share ``1 - k``. Of the torque that it gives up, the integral takes over no more than
  the friction: the rest never acted on the joint as a load.
- No more friction is fed than the balance of torques shows (:mod:`adaptive_ff.adaptive.supervision.balance`), as ``k``
  grows without a prior and without a margin: kicks average out along the plan, whatever they teach the estimator.
- ``s`` is the noise level once that is known; before, if counts are recognised, the least noise so far. Behind a
  low-pass every sample shows noise, also the many between two counts, and the least noise is that of slow motion. There
  ``s`` is the mean once the noise is known.

**Counts larger than the plan.** Where the least change is more than 0.8 to 1.6 ``w_p``, the observer sees counts, not
torque, and is held back (:func:`fine_share`).

**First counts.** The changes of a sensor that has mostly repeated itself may be counts. Nothing is observed from the
first one until the sixth, unless the kick of the least one is no more than ``F``: then the joint was stuck, and breaks
away.

How counts are recognised. Without a low-pass a fifth of the changes must be near the least one, and

- most samples bring no change, or there have been more than 50 changes, or
- three changes or more have all been whole multiples of the least one.

Behind a low-pass the velocity falls by the same factor, sample by sample, until the next count; that must have happened
three times, and at a hundredth of all changes.

Evidence: ``python -m benchmarks.coarse_encoders`` runs 1000 joints with 0.1 to 10 counts in a period at the largest
speed, as differences and behind a low-pass. 56 have a window above 1.2 times PI's error, the worst of 4.29; without
these rules 205, the worst of 30.5. The constants were chosen on other joints (seeds 601 to 660):

- with 0.1 ``w_p`` for differences as well, the first window is twice as bad with three counts;
- with all of the observed torque handed over to the integral, a first window of 17 times PI's error is left;
- with none of it handed over, as many joints have such a window as with the part that is.
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
"""Least change of the sensor, over the plan's largest speed, beyond which the observer is held back, and in full."""

FEW = 3.0
"""Number of changes (falls) from which on whole multiples of the least one (falls that are alike) are counts.

Without this the observer of a joint whose encoder changes at most samples feeds back counts for 50 changes. Of 40
joints of another simulator (seeds 501 to 540), with ten sampling periods to a count at the largest speed, the worst has
1.9 times PI's error in the first 5 s; without this one has 9.1 times.
"""

COUNTS, SURE = 0.2, 50.0
"""Least share of the changes near the least one, for them to be counts; and number of changes that makes this sure.

Up to that number, most samples must have brought no change.
"""

ALIKE_SHARE = 0.01
"""Least share of the changes that are such falls, for a low-pass: of a fine sensor without one 0.004 are, by chance."""

BEGUN = 6.0
"""Number of changes of a sensor that repeats itself, below which they may all be first counts."""

PLAIN, LOW_PASSED = 0.2, 0.1
"""Noise over the largest speed of the plan from which on kicks count (twice that: in full); the same behind a low-pass.

The noise is measured by second differences, of which a low-pass leaves little.
"""

KICKS, KICKS_MORE = 0.2, 0.3
"""Kick over the friction from which on kicks count, and how much more makes them count in full."""


@register_jitable
def is_counted(seen: SeenVelocity, samples: int) -> bool:
    """Tell whether a sensor has shown counts, after so many samples."""
    shown = seen.changes > SURE or 2.0 * seen.changes < samples
    shown = shown or (seen.changes >= FEW and seen.multiples == seen.changes)
    return shown and seen.changes > 0.0 and seen.fine >= COUNTS * seen.changes


@register_jitable
def fine_share(seen: SeenVelocity, samples: int, peak: float) -> float:
    """Return the share of the observer's gain for which the sensor is fine enough, after so many samples.

    Where a count in a period is more than the largest speed of the plan (rad/s), the observer sees counts, not torque.
    """
    if not is_counted(seen, samples) or seen.finest <= COARSE * peak:
        return 1.0
    return max(0.0, (TOO_COARSE * peak - seen.finest) / ((TOO_COARSE - COARSE) * peak)) if peak > 0.0 else 0.0


@register_jitable
def first_counts(seen: SeenVelocity, samples: int, kick: float, friction: float) -> bool:
    """Tell whether the changes so far may be the first counts, too coarse to observe, of a sensor that repeats itself.

    Parameters
    ----------
    seen : SeenVelocity
        What is remembered of measured velocities.
    samples : int
        Number of samples so far.
    kick : float
        Torque that the proportional gain makes of the least change, N m.
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
    """Return the standard deviation ``s`` (rad/s) of the sensor's noise, which the feedback answers with kicks."""
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
    """Return the share ``k`` to which counts make the feedback kick harder than the friction.

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
    """Return the part of the observed torque that counts have made (N m), of which the integral takes over nothing.

    Parameters
    ----------
    observed, before : float
        Observed torque now and a sample ago, N m.
    fine, kicked : float
        Shares of :func:`fine_share` and :func:`kicked_share`.
    friction : float
        Friction at breakaway as it is identified, N m.
    """
    spurious = (1.0 - fine) * (observed - before)
    left = observed - spurious
    return spurious + math.copysign(kicked * max(0.0, abs(left) - friction), left)
