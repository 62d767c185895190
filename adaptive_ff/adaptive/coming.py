"""Torque that acted over a period, and the reference over the period in which a torque computed now will act."""

import math

from controllers import Inputs, acts_on_plan, delayed


def without_rounding(inputs: Inputs, least: float) -> Inputs:
    """Return the inputs with references below a speed (rad/s) at zero: a plan's rounding errors are no motion."""
    return inputs._replace(
        reference=_or_zero(inputs.reference, least),
        next_reference=_or_zero(inputs.next_reference, least),
        acting_reference=_or_zero(inputs.acting_reference, least),
        next_acting_reference=_or_zero(inputs.next_acting_reference, least),
    )


def _or_zero(value: float, least: float) -> float:
    return 0.0 if abs(value) < least else value


def limited_mean(commands: tuple[float, ...], delay: float, limit: float) -> float:
    """Return the mean torque (N m) over the period that ends of a late drive that cuts off commands at a limit."""
    whole = float(int(delay))
    early = min(max(delayed(commands, whole), -limit), limit)
    if whole == delay:
        return early
    late = min(max(delayed(commands, whole + 1.0), -limit), limit)
    return early + (delay - whole) * (late - early)


def following_reference(last: float, earlier: float, samples: int, inputs: Inputs) -> float:
    """Return the reference at the next sample, rad/s: as given, or extrapolated by the lesser of the last two slopes.

    So a leap that was not announced is not taken for a slope that goes on (minmod); a reference of zero rests.
    """
    if math.isfinite(inputs.next_reference):
        return inputs.next_reference
    if samples < 2 or inputs.reference == 0.0:
        return inputs.reference
    slope, before = inputs.reference - last, last - earlier
    if slope * before <= 0.0:
        return inputs.reference
    return inputs.reference + math.copysign(min(abs(slope), abs(before)), slope)


def coming_reference(inputs: Inputs, following: float, delay: float) -> tuple[float, float]:
    """Return the reference at the start and the end of the period in which a torque computed now acts, rad/s.

    Parameters
    ----------
    inputs : Inputs
        Inputs of the sample.
    following : float
        Reference at the next sample, rad/s: where nothing else is given it is continued.
    delay : float
        Computation delay of the drive, periods.
    """
    if acts_on_plan(inputs):
        return inputs.acting_reference, inputs.next_acting_reference
    shift = delay * (following - inputs.reference)
    return inputs.reference + shift, following + shift
