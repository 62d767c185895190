"""Default bounds on the maximum sensitivity ``max |1/(1 + L)|`` that designs keep."""

PI_SENSITIVITY = 1.7
"""Bound for a PI loop."""

OBSERVER_SENSITIVITY = 2.0
"""Bound for a loop with an observer, which needs more of it than PI alone."""
