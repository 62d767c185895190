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


def check_finite(name: str, value: float, unit: str) -> None:
    """Raise ``ValueError`` for a value that is not finite, ``TypeError`` for no number."""
    check_numbers(**{name: value})
    if not math.isfinite(value):
        raise ValueError(f"{name} = {value} is not allowed: it must be a finite number of {unit}")


def check_period(name: str, value: float) -> None:
    """Raise ``ValueError`` for a period that is not positive and finite, ``TypeError`` for no number."""
    check_numbers(**{name: value})
    if not 0.0 < value < math.inf:
        raise ValueError(f"{name} = {value} is not allowed: it must be positive and finite")
