"""Rows of ``benchmarks.speed`` and ``benchmarks.scaling``: one measurement, beside a rival and against a target."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np
from rich.box import SIMPLE
from rich.table import Table


@dataclass(frozen=True)
class Row:
    """One measurement.

    Attributes
    ----------
    what : str
        What is measured.
    rival : str
        What it is measured beside; the reason where nothing is measured.
    ours, theirs : float, optional
        Our figure and the rival's, in ``unit``.
    ratio : float, optional
        Ours over the rival's.
    largest_ratio, largest : float, optional
        Targets for the ratio and for our figure.
    difference : float, optional
        Largest relative difference between the rival's series and ours.
    unit : str
        Seconds, ``s``, or bytes, ``B``.
    """

    what: str
    rival: str
    ours: float | None = None
    theirs: float | None = None
    ratio: float | None = None
    largest_ratio: float | None = None
    largest: float | None = None
    difference: float | None = None
    unit: str = "s"

    @property
    def met(self) -> bool | None:
        """Whether the targets are met; None without a target or a figure."""
        pairs = ((self.ratio, self.largest_ratio), (self.ours, self.largest))
        checked = [value <= limit for value, limit in pairs if value is not None and limit is not None]
        return all(checked) if checked else None

    def cells(self) -> tuple[str, ...]:
        """Return the row as it is printed."""
        ratio_target = "" if self.largest_ratio is None else f"<= {shown(self.largest_ratio, '')}"
        target = "" if self.largest is None else f"<= {shown(self.largest, self.unit)}"
        met = {True: "yes", False: "NO", None: ""}[self.met]
        figures = (shown(self.ours, self.unit), shown(self.theirs, self.unit), shown(self.ratio, ""))
        return self.what, *figures, f"{ratio_target}{target}", met


def shown(value: float | None, unit: str) -> str:
    """Return a figure with a prefix to its unit; a ratio, which has none, as it is or as one over a number."""
    if value is None:
        return ""
    if not unit:
        return f"{value:.2f}" if value > 0.1 else f"1/{1.0 / value:.0f}"
    for factor, prefix in ((1e6, "M"), (1e3, "k"), (1.0, ""), (1e-3, "m"), (1e-6, "u")):
        if abs(value) >= factor and (factor <= 1.0 or unit == "B"):
            return f"{value / factor:.3g} {prefix}{unit}"
    return f"{value / 1e-9:.3g} n{unit}"


def in_turn(repeats: int, *jobs: Callable[[], float]) -> tuple[list[float], list[float]]:
    """Return the median time of each job, s, and the median over the repeats of its ratio to the last one."""
    times = np.array([[job() for job in jobs] for _ in range(repeats)])
    return np.median(times, axis=0).tolist(), np.median(times / times[:, -1:], axis=0).tolist()


def as_table(title: str, rows: Sequence[Row]) -> Table:
    """Return the rows of a section as they are printed."""
    differences = [row.difference for row in rows if row.difference is not None]
    caption = f"largest relative difference between the series: {max(differences):.1g}" if differences else None
    table = Table(title=title, box=SIMPLE, caption=caption)
    for heading in ("", "ours", "rival", "ratio", "target", "met"):
        table.add_column(heading, justify="left" if heading in ("", "met") else "right", no_wrap=True)
    for row in rows:
        table.add_row(*row.cells())
    return table
