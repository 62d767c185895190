"""The check of a confidence, the probability that an interval is meant to have."""

from adaptive_ff.errors import InputError
from controllers.checks import check_numbers


def check_confidence(confidence: float) -> None:
    """Raise ``InputError`` for a confidence that does not lie between 0 and 1, ``TypeError`` for no number."""
    check_numbers(confidence=confidence)
    if not 0.0 < confidence < 1.0:
        raise InputError(f"confidence = {confidence} is not allowed: it must lie between 0 and 1")
