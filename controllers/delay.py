"""Computation delay of a drive: which of the values computed so far belongs to the period that ends now.

A drive with a delay of ``d`` sampling periods applies the torque computed at sample ``k`` from ``d`` periods later on,
for a period. With ``d = m + r``, ``m`` whole and ``0 <= r < 1``, the period that ends at sample ``k`` began with the
torque of ``k - 2 - m``, for the share ``r`` of it, and went on with that of ``k - 1 - m``. What is known of a period is
the mean over it.

What has been computed is kept in a tuple, the newest first. Its length is part of the type, so without a delay it costs
no more than a number, and kernels are compiled anew for a length: there are few.
"""

import math

from controllers.checks import check_numbers
from controllers.kernels.language import natural

LENGTHS = (1, 3, 11)
"""Lengths of lines: for no delay, for delays that drives have, and for the longest that is accepted."""

LONGEST_DELAY = LENGTHS[-1] - 1.0
"""Longest computation delay that is accepted, sampling periods."""


def check_delay(delay: float) -> None:
    """Raise ``ValueError`` for a delay that is not from 0 to ``LONGEST_DELAY`` periods, ``TypeError`` for no number."""
    check_numbers(delay=delay)
    if not 0.0 <= delay <= LONGEST_DELAY:
        raise ValueError(f"delay = {delay} is not allowed: it must be from 0 to {LONGEST_DELAY:g} sampling periods")


def delay_line(delay: float) -> tuple[float, ...]:
    """Return a line for a delay in periods, as if zero had been computed before the first sample.

    Raises
    ------
    ValueError
        The delay is not from 0 to ``LONGEST_DELAY``.
    """
    check_delay(delay)
    needed = math.ceil(delay) + 1
    return (0.0,) * min(length for length in LENGTHS if length >= needed)


def delayed(line: tuple[float, ...], delay: float) -> float:
    """Return the mean over the period that ends now of what the line held back, computed at earlier samples."""
    whole = natural(int(delay))
    mean = line[whole]
    if whole < delay:
        rest = delay - whole
        mean = (1.0 - rest) * mean + rest * line[whole + 1]
    return mean


def remember(line: tuple[float, ...], value: float) -> tuple[float, ...]:
    """Return the line with what has been computed at this sample."""
    return (value, *line[:-1])
