"""Checks of the numbers that a controller is made with."""

import math


def check_positive(**values: float) -> None:
    """Raise ``ValueError`` for the first value that is not a positive finite number."""
    for name, value in values.items():
        if not (math.isfinite(value) and value > 0.0):
            raise ValueError(f"{name} = {value} is not allowed: it must be positive and finite")
