"""How large velocities and torques can be on any machine, generously."""

import math

from numba.extending import register_jitable

LARGEST_VELOCITY = 1e5
"""Largest plausible velocity, rad/s or m/s: a million revolutions a minute."""


@register_jitable
def largest_torque(proportional: float, integral: float) -> float:
    """Return the largest plausible torque, N m: what the feedback would answer to the largest velocity.

    Parameters
    ----------
    proportional, integral : float
        Gains, N m s/rad and N m/rad; without either there is no such torque, and it is infinite.
    """
    gain = proportional if proportional > 0.0 else integral
    return gain * LARGEST_VELOCITY if gain > 0.0 else math.inf
