"""Is a reference one that the joint can follow and that shows its friction: a peak by default, and warnings."""

from collections.abc import Iterator

import numpy as np
from numpy.typing import NDArray

from adaptive_ff.scenario.axis_units import axis_unit
from adaptive_ff.scenario.series import largest_size
from plant import FrictionFields

PEAK_FACTOR = 7.0  # default peak of a multisine, in Stribeck velocities: well beyond the falling part of the curve
SLOW_FACTOR = 2.0
"""A reference that never exceeds this many Stribeck velocities does not show viscous and Coulomb friction apart."""

SHORTEST = 10.0  # shortest run that is warned of as too slow, s
OFTEN = 0.02  # fraction of the time in which the reference may need more than the torque limit without a warning
USED_FRACTION = 0.7  # fraction of the torque limit that a suggested or default peak needs


def largest_peak(joint: FrictionFields, limit: float, velocity: NDArray[np.float64], period: float) -> float:
    """Return the peak (rad/s) at which a motion needs 0.7 of the limit (N m); negative where stiction alone does.

    The motion may have any peak but zero, on a grid with a period (s).
    """
    peak = largest_size(velocity)
    steepest = largest_size(np.diff(velocity)) / period if velocity.size > 1 else 0.0
    return peak * (USED_FRACTION * limit - joint.stiction) / (joint.inertia * steepest + joint.viscous * peak)


def default_peak(joint: FrictionFields, limit: float | None, unit: NDArray[np.float64], period: float) -> float:
    """Return the peak (rad/s) that suits a joint: seven Stribeck velocities, less where the torque limit asks for it.

    ``unit`` is the motion with a peak of 1 rad/s on a grid with a period (s).
    """
    wanted = PEAK_FACTOR * joint.stribeck_velocity
    possible = wanted if limit is None else largest_peak(joint, limit, unit, period)
    return min(wanted, possible) if possible > 0.0 else wanted


def motion_cautions(
    joint: FrictionFields, limit: float | None, velocity: NDArray[np.float64], period: float
) -> Iterator[str]:
    """Yield a sentence where a reference (rad/s) is far too slow or too fast for a joint, with what would suit it."""
    peak = largest_size(velocity)
    speed, torque = axis_unit(joint.axis, "rad/s"), axis_unit(joint.axis, "N m")
    long_enough = period * velocity.size >= SHORTEST  # a shorter one has hardly begun to move
    if long_enough and 0.0 < peak < SLOW_FACTOR * joint.stribeck_velocity:
        yield (
            f"the reference never exceeds {peak:.3g} {speed}, {peak / joint.stribeck_velocity:.2g} times "
            f"joint.stribeck_velocity = {joint.stribeck_velocity:g} {speed}: it hardly shows the friction curve; a "
            f"peak of {PEAK_FACTOR * joint.stribeck_velocity:.3g} {speed} would"
        )
    if limit is None or limit < joint.stiction or velocity.size < 2:
        return
    sliding = joint.coulomb * np.sign(velocity) + joint.viscous * velocity
    needed = np.abs(joint.inertia * np.diff(velocity) / period + sliding[1:])
    often = float(np.mean(needed > limit))
    if often > OFTEN:
        suggested = largest_peak(joint, limit, velocity, period)
        advice = f"a peak of {suggested:.3g} {speed} would suit it" if suggested > 0.0 else "friction needs most of it"
        yield (
            f"the reference needs more than actuator.torque_limit = {limit:g} {torque} in {100.0 * often:.0f} % of the "
            f"time, up to {float(np.max(needed)):.3g} {torque}; {advice}"
        )
