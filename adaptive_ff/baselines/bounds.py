"""Bounds and units of what the estimators of the literature find, in terms of the loop."""

INERTIA_RANGE = 10.0
"""The inertia is assumed to lie within this factor of the one that the feedback was designed for."""

LARGEST_LAG = 10.0
"""Largest possible friction lag, in time constants ``J/Kp`` of the feedback ..."""

LARGEST_LAG_AT_LEAST = 0.1
"""... but at least this, s: with a fast loop, even the lag of a common joint is many of its time constants."""

VISCOUS_UNIT = 0.2
"""Unit of the viscous coefficient, as a fraction of the proportional gain."""


def largest_lag(response: float) -> float:
    """Return the largest possible friction lag (s), for a time constant ``J/Kp`` (s) of the feedback."""
    return max(LARGEST_LAG * response, LARGEST_LAG_AT_LEAST)
