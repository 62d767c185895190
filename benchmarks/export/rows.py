"""What a section of the benchmark has found: a figure, its target, and whether that is met."""

from typing import NamedTuple


class Row(NamedTuple):
    """One line of the table.

    Attributes
    ----------
    what : str
        What was measured.
    figure : str
        What was found.
    target : str
        What it should be; empty where there is no target.
    met : bool or None
        Whether the target is met; None where there is none or nothing could be measured.
    """

    what: str
    figure: str
    target: str = ""
    met: bool | None = None


def skipped(what: str, reason: str, target: str = "") -> Row:
    """Return the line of what could not be measured here."""
    return Row(what, f"skipped: {reason}", target)
