"""Shares between nothing and all."""

from numba.extending import register_jitable

TINY = 1e-15
"""Variance that is taken for none: a simulation without noise must not divide by zero."""


@register_jitable
def saturated(value: float) -> float:
    """Return a value cut off at 0 and 1."""
    return min(1.0, max(0.0, value))
