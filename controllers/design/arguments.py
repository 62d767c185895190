"""Checks of what designs are given, beside those of :mod:`controllers.checks`."""

import math

from controllers.checks import check_numbers

MOST_DELAY = 1000
"""Most periods of delay that a loop is designed for; each makes its polynomials longer."""


def check_whole_delay(delay: int) -> None:
    """Raise ``ValueError`` for a delay that is no whole number of periods, ``TypeError`` for no number."""
    check_numbers(delay=delay)
    if not (0 <= delay <= MOST_DELAY and delay % 1 == 0):
        raise ValueError(
            f"delay = {delay} is not allowed: it must be a whole number of periods, from zero to {MOST_DELAY}"
        )


def check_sensitivity(maximum_sensitivity: float) -> None:
    """Raise ``ValueError`` for a bound on the maximum sensitivity that is not above 1, ``TypeError`` for no number."""
    check_numbers(maximum_sensitivity=maximum_sensitivity)
    if not 1.0 < maximum_sensitivity < math.inf:
        raise ValueError(
            f"maximum_sensitivity = {maximum_sensitivity} is not allowed: it must be more than 1, and finite"
        )
