"""Checks of what the estimators of a whole record are given."""

import numpy as np

from adaptive_ff.errors import InputError
from controllers.arrays import NDArray
from controllers.checks import check_numbers


def check_confidence(confidence: float) -> None:
    """Raise ``InputError`` for a confidence that does not lie between 0 and 1, ``TypeError`` for no number.

    It is the probability that an interval is meant to have.
    """
    check_numbers(confidence=confidence)
    if not 0.0 < confidence < 1.0:
        raise InputError(f"confidence = {confidence} is not allowed: it must lie between 0 and 1")


def check_all(
    name: str, values: NDArray[np.float64], holds: NDArray[np.bool_], rule: str = "all must be finite"
) -> None:
    """Raise ``ValueError`` for the first of some values of which a condition does not hold."""
    if not np.all(holds):
        place = tuple(int(index) for index in np.argwhere(~holds)[0])
        raise ValueError(f"{name}{list(place)} = {values[place]:g} is not allowed: {rule}")
