"""Units with a prefix, so that a table shows numbers that a person can read."""

import math
from collections.abc import Iterable

PREFIXES = {-3: "n", -2: "µ", -1: "m", 0: "", 1: "k", 2: "M"}
"""By power of a thousand."""

DEVIATIONS = 2.0
"""What is shown of an uncertainty, to either side, standard deviations."""


def scale_for(values: Iterable[float], unit: str) -> tuple[float, str]:
    """Return a factor, and the unit with its prefix, for which the middle one of some values is from 1 to 1000.

    Parameters
    ----------
    values : iterable of float
        Values in the unit; zeros and what is not finite do not count.
    unit : str
        The unit without a prefix.
    """
    sizes = sorted(abs(value) for value in values if math.isfinite(value) and value != 0.0)
    power = math.floor(math.log10(sizes[(len(sizes) - 1) // 2]) / 3.0 + 1e-12) if sizes else 0
    power = min(max(power, min(PREFIXES)), max(PREFIXES))
    return 1e3**-power, PREFIXES[power] + unit


def shown(value: float) -> str:
    """Return a number with three digits, without an exponent where it is not huge or tiny."""
    if 1e3 <= abs(value) < 1e7:
        return f"{value:.0f}"
    return f"{value:.3g}"
