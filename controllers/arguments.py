"""What a step may be given of each input; the extension that calls kernels has the same rules, without the words."""

import math
from typing import Any

from controllers.checks import check_finite, check_numbers, check_positive
from controllers.registry import Inputs

COMMANDED, MEASURED, UNKNOWN, PREVIEW, INERTIA, TIME = "cmupit"
"""Finite; any number; the same or none; finite or none; positive or none; positive, or none for the nominal period."""

RULES = {
    "reference": COMMANDED,
    "velocity": MEASURED,
    "next_reference": PREVIEW,
    "correction": COMMANDED,
    "position": UNKNOWN,
    "realised_torque": UNKNOWN,
    "feedforward": COMMANDED,
    "inertia": INERTIA,
    "dt": TIME,
    "acting_reference": PREVIEW,
    "next_acting_reference": PREVIEW,
}
"""Rule of each input, in the order of ``Inputs``."""


def checked_step(given: tuple[Any, ...], period: float) -> Inputs:
    """Return the inputs of a step as floats, not a number where there is none."""
    numbers = []
    for (name, rule), value in zip(RULES.items(), given, strict=True):
        if value is None and rule not in (COMMANDED, MEASURED):
            numbers.append(period if rule == TIME else math.nan)
            continue
        if rule == INERTIA:
            check_positive(inertia=value)
        elif rule in (COMMANDED, PREVIEW):
            check_finite(**{name: value})
        check_numbers(**{name: value})
        if rule == TIME and not 0.0 < value < math.inf:
            raise ValueError(f"dt = {value} is not allowed: it must be a positive number of seconds")
        numbers.append(float(value))
    return Inputs(*numbers)
