"""Checks of the numbers that a joint is stepped with."""

import math
import reprlib
from typing import Any


def check_numbers(**values: Any) -> None:
    """Raise ``TypeError`` for the first value that is no number that a ``float`` can hold."""
    for name, value in values.items():
        try:
            math.isfinite(value)
        except (TypeError, OverflowError):
            raise TypeError(f"{name} = {reprlib.repr(value)} is not allowed: it must be a number") from None
