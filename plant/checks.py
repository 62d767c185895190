"""Checks of the numbers that a joint is stepped with."""

import math
import reprlib
from typing import Any


def check_numbers(**values: Any) -> None:
    """Raise ``TypeError`` for the first value that is no number, ``ValueError`` for one that no ``float`` can hold."""
    for name, value in values.items():
        try:
            math.isfinite(value)
        except TypeError:
            raise TypeError(f"{name} = {reprlib.repr(value)} is not allowed: it must be a number") from None
        except OverflowError:  # a whole number of hundreds of digits
            raise ValueError(f"{name} = {reprlib.repr(value)} is not allowed: its size must be below 1e308") from None
