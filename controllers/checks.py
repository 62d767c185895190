"""Checks of the numbers that a controller is made with, and is given."""

import math
import reprlib
from typing import Any

import numpy as np

from controllers.arrays import NDArray


def check_numbers(**values: Any) -> None:
    """Raise ``TypeError`` for the first value that is no number; a text of digits is none."""
    for name, value in values.items():
        try:
            math.isfinite(value)
        except TypeError:
            raise TypeError(f"{name} = {value!r} is not allowed: it must be a number") from None
        except OverflowError:  # a whole number of hundreds of digits
            raise ValueError(f"{name} = {reprlib.repr(value)} is not allowed: its size must be below 1e308") from None


def check_finite(**values: Any) -> None:
    """Raise ``ValueError`` for the first value that is not finite, ``TypeError`` for no number."""
    check_numbers(**values)
    for name, value in values.items():
        if not math.isfinite(value):
            raise ValueError(f"{name} = {value} is not allowed: it must be a finite number")


def checked_array(name: str, values: Any) -> NDArray[np.float64]:
    """Return numbers as an array of any shape; raise ``TypeError`` for what is none, such as texts of digits."""
    try:
        array = np.asarray(values)
        if array.dtype.kind in "biuf" or (
            array.dtype.kind == "O" and not any(isinstance(one, str | bytes | None) for one in array.flat)
        ):
            return array.astype(np.float64, copy=False)
    except (TypeError, ValueError, OverflowError):
        pass
    raise TypeError(f"{name} = {reprlib.repr(values)} is not allowed: it must be numbers")


def checked_switch(name: str, value: Any) -> bool:
    """Return a switch; raise ``ValueError`` for what is neither true nor false, such as the text ``"off"``."""
    if not (isinstance(value, int | float | np.generic) and value in (True, False)):
        raise ValueError(f"{name} = {value!r} is not allowed: it must be True or False")
    return bool(value)


def check_positive(**values: float) -> None:
    """Raise ``ValueError`` for the first value that is not a positive finite number, ``TypeError`` for no number."""
    check_numbers(**values)
    for name, value in values.items():
        if not (math.isfinite(value) and value > 0.0):
            raise ValueError(f"{name} = {value} is not allowed: it must be positive and finite")


PI_SENSITIVITY, OBSERVER_SENSITIVITY = 1.7, 2.0
"""Default bounds on the maximum sensitivity ``max |1/(1 + L)|`` of PI, and of a loop with an observer."""

MOST_PERIODS = 1000.0
"""Longest lag of a measured velocity that is accepted, sampling periods: longer ones are milliseconds."""


def check_velocity_lag(velocity_lag: float, period: float) -> None:
    """Raise ``ValueError`` for a lag (s) not from 0 to ``MOST_PERIODS`` periods, ``TypeError`` for no number."""
    check_numbers(velocity_lag=velocity_lag)
    longest = MOST_PERIODS * period
    if not 0.0 <= velocity_lag <= longest:
        raise ValueError(
            f"velocity_lag = {velocity_lag} s is not allowed: it must be from 0 to {longest:g} s, "
            f"{MOST_PERIODS:g} sampling periods"
        )


def check_period(period: float) -> None:
    """Raise ``ValueError`` for a sampling period that is not positive and finite, ``TypeError`` for no number."""
    check_numbers(period=period)
    if not (math.isfinite(period) and period > 0.0):
        raise ValueError(f"period = {period} is not allowed: it must be a positive number of seconds")
