"""Inputs that no machine can give: found before a step, taken for not measured, counted.

One finite number that is absurd, such as the 1e306 of a corrupted word, poisons filters and sums as surely as one that
is not finite. The bounds are so generous that no machine comes near them: a speed of ``LARGEST_VELOCITY``, a torque
that the feedback would answer to an error of that size, a time between samples of a thousandth to ten thousand times
the nominal period. Within them every kernel stays finite; what is merely wrong is for the estimator to doubt.

What stands in for a value that is not plausible: for a measurement "not a number", as where it is lost; for a plan and
for the torque known from elsewhere the last plausible one; for the time since the last sample the nominal period.
"""

import math
from typing import NamedTuple

from controllers.registry import Inputs

LARGEST_VELOCITY = 1e5
"""Largest plausible velocity, rad/s or m/s: a million revolutions a minute."""

LEAST_RESPONSE, LONGEST_RESPONSE = 1e-6, 1e3
"""Least and largest plausible inertia, in ``Kp`` times a second: the time constant of the loop that it would make."""

BRIDGED = 2.0
"""Time for which a controller goes on without a measurement, s: on its feedforward and on what its integral holds."""

FADING = 1.0
"""Time in which the torque then fades to zero, s."""

LARGEST_POSITION = 1e12
"""Largest plausible position, rad or m: beyond it not even its period of 2 pi is resolved to four digits."""

LARGEST_OBSERVED = 1e30
"""What an observer holds beyond this is no torque and no velocity, in any unit: it begins anew."""

LEAST_TIME, MOST_TIME = 1e-3, 1e4
"""Least and largest plausible time between two samples, in nominal periods."""


def inertia_bounds(gain: float) -> tuple[float, float]:
    """Return the bounds between which an inertia is plausible, kg m^2, beside a gain of the feedback."""
    return gain * LEAST_RESPONSE, gain * LONGEST_RESPONSE if gain > 0.0 else math.inf


def largest_torque(proportional: float, integral: float) -> float:
    """Return the largest plausible torque, N m: what the feedback would answer to the largest velocity."""
    gain = proportional if proportional > 0.0 else integral
    return gain * LARGEST_VELOCITY if gain > 0.0 else math.inf


class Guard(NamedTuple):
    """What the check of the inputs remembers; by default of having met nothing."""

    reference: float = 0.0  # last plausible plan, rad/s
    feedforward: float = 0.0  # last plausible torque known from elsewhere, N m
    lost: float = 0.0  # for how long there has been no measurement, s; zero where there is one
    # samples at which another value than the measured velocity was not plausible, or the torque was not finite
    faults: int = 0


def within(value: float, bound: float) -> bool:
    """Tell whether a value is a finite number and at most as large as a bound."""
    return math.isfinite(value) and abs(value) <= bound


def absurd(value: float, bound: float) -> bool:
    """Tell whether a value that may be unknown, then not a number, is infinite or beyond a bound."""
    return not math.isnan(value) and not within(value, bound)


def kept(value: float) -> float:
    """Return what an observer holds, or zero where that cannot be."""
    return value if abs(value) < LARGEST_OBSERVED else 0.0


def checked_inputs(
    inputs: Inputs, guard: Guard, proportional: float, integral: float, period: float
) -> tuple[Inputs, Guard]:
    """Return the inputs with what is not plausible replaced, and what the check remembers."""
    gain = proportional if proportional > 0.0 else integral
    torque = largest_torque(proportional, integral)
    least, most = inertia_bounds(gain)
    faults = 0
    reference, following, correction = inputs.reference, inputs.next_reference, inputs.correction
    known, realised = inputs.feedforward, inputs.realised_torque
    position, given, duration = inputs.position, inputs.inertia, inputs.dt
    if not within(reference, LARGEST_VELOCITY):
        reference, faults = guard.reference, 1
    if absurd(following, LARGEST_VELOCITY):
        following, faults = math.nan, 1
    start, end = inputs.acting_reference, inputs.next_acting_reference
    if absurd(start, LARGEST_VELOCITY) or absurd(end, LARGEST_VELOCITY):
        start, end, faults = math.nan, math.nan, 1
    if not within(correction, LARGEST_VELOCITY):
        correction, faults = 0.0, 1
    if not within(known, torque):
        known, faults = guard.feedforward, 1
    if absurd(realised, torque):
        realised, faults = math.nan, 1
    if absurd(position, LARGEST_POSITION):
        position, faults = math.nan, 1
    if given <= least or absurd(given, most):
        given, faults = math.nan, 1
    if not LEAST_TIME * period <= duration <= MOST_TIME * period:
        duration, faults = period, 1
    velocity, lost = inputs.velocity, 0.0
    if not within(velocity, LARGEST_VELOCITY):
        velocity, lost = math.nan, guard.lost + duration
    plain = Inputs(reference, velocity, following, correction, position, realised, known, given, duration, start, end)
    return plain, Guard(reference, known, lost, guard.faults + faults)


def bridging_gain(lost: float) -> float:
    """Return the gain, from 1 to 0, of the torque that is still given after a time (s) without a measurement."""
    return min(1.0, max(0.0, 1.0 - (lost - BRIDGED) / FADING))
