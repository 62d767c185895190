"""How large velocities, inertias and torques can be on any machine, generously."""

import math

LARGEST_VELOCITY = 1e5
"""Largest plausible velocity, rad/s or m/s: a million revolutions a minute."""

LEAST_RESPONSE, LONGEST_RESPONSE = 1e-6, 1e3
"""Least and largest plausible inertia, in ``Kp`` times a second: the time constant of the loop that it would make."""


def inertia_bounds(gain: float) -> tuple[float, float]:
    """Return the bounds between which an inertia is plausible, kg m^2, beside a gain of the feedback."""
    return gain * LEAST_RESPONSE, gain * LONGEST_RESPONSE if gain > 0.0 else math.inf


def largest_torque(proportional: float, integral: float) -> float:
    """Return the largest plausible torque, N m: what the feedback would answer to the largest velocity."""
    gain = proportional if proportional > 0.0 else integral
    return gain * LARGEST_VELOCITY if gain > 0.0 else math.inf
