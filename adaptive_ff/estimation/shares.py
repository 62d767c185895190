"""Shares between nothing and all."""

from numba.extending import register_jitable

TINY = 1e-30
"""Mean square or magnitude that is taken for none, in any unit: a simulation without noise must not divide by zero."""

ROUNDING = 1e-21
"""Variance of a velocity, rad^2/s^2, that is taken for none; times the square of the proportional gain, of a torque.

What a model leaves in a simulation without noise is rounding, and no reason to doubt it.
"""


@register_jitable
def saturated(value: float) -> float:
    """Return a value cut off at 0 and 1."""
    return min(1.0, max(0.0, value))
