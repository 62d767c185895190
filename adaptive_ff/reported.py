"""Pictures, tables and words that people ask a result for: the only way from a result to the report on it."""

from pathlib import Path
from typing import TYPE_CHECKING, Any, ClassVar

if TYPE_CHECKING:
    from matplotlib.figure import Figure

WORTH = 1.05
"""What is left without over what is left with the best, from which a verdict calls it worth it."""


class Reported:
    """A result that the report draws and words; the report is imported when it is first asked."""

    _drawn_by: ClassVar[str] = ""

    def plot(self, folder: str | Path | None = None) -> "dict[str, Figure]":
        """Draw all pictures, by name; write each as ``NAME.png`` where a folder is given."""
        pictures: dict[str, Figure] = self._report(self._drawn_by, folder)
        return pictures

    def _report(self, name: str, *arguments: Any) -> Any:
        """Return what a function of :mod:`adaptive_ff.report` makes of the result."""
        from adaptive_ff import report

        return getattr(report, name)(self, *arguments)
