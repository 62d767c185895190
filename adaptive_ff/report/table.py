"""One table for every command: built once from numbers with units, written for a terminal, as Markdown, CSV or HTML."""

import csv
import io
import math
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, field
from html import escape
from textwrap import wrap
from typing import Any

from rich.console import Console, ConsoleOptions, RenderResult
from rich.text import Text

PREFIXES = ("", "m", "µ", "n")  # by how many thousandths a unit is; a table has no larger units than those of the SI
FIXED_UNITS = ("%", "°", "Hz")  # units that have no prefix
DEVIATIONS = 2.0  # what is shown of an uncertainty, to either side, standard deviations
GAP = "  "  # between columns
MOST_LINES = 6  # lines that a heading may take

BOLD = ' style="font-weight: bold"'

Cell = str | float | tuple[float, float] | None
"""Text, a number, a number with its uncertainty, or nothing."""

Columns = Mapping[str, tuple[str, int] | None]
"""Columns by heading: unit and significant digits of a number; None of a text."""


def scale_for(values: Iterable[float], unit: str) -> tuple[float, str]:
    """Return a factor, and the unit with its prefix, for which the middle one of some values is at least 1."""
    sizes = sorted(abs(value) for value in values if math.isfinite(value) and value != 0.0)
    power = math.floor(math.log10(sizes[(len(sizes) - 1) // 2]) / 3.0 + 1e-12) if sizes else 0
    power = min(max(-power, 0), len(PREFIXES) - 1)
    return 1e3**power, PREFIXES[power] + unit


def shown(value: float, digits: int = 3) -> str:
    """Return a number with significant digits, without an exponent where it is not huge or tiny."""
    if not math.isfinite(value):
        return "-" if math.isnan(value) else "∞"
    if value == 0.0 or 10.0**digits <= abs(value) < 1e7:
        return f"{value:.0f}"
    text = f"{value:#.{digits}g}"
    return f"{value:.{digits}g}" if "e" in text else text.rstrip(".")


@dataclass(frozen=True)
class Table:
    """A table as it is shown."""

    title: str  # heading
    heads: tuple[str, ...]  # headings of the columns
    units: tuple[str, ...]  # their units with prefixes; empty without
    numbers: tuple[bool, ...]  # which columns hold numbers
    rows: list[tuple[str, ...]]  # cells; a row of one cell is the heading of those below
    styles: Mapping[str, str] = field(default_factory=dict)  # how rows stand out, by their first cell, as rich names it

    def column(self, head: str) -> list[str]:
        """Return the cells of a column."""
        place = self.heads.index(head)
        return [row[place] for row in self.rows if len(row) == len(self.heads)]

    def __rich_console__(self, console: Console, options: ConsoleOptions) -> RenderResult:
        """Yield the lines of the table for a terminal; headings take several lines where there is no room."""
        listed = [row for row in self.rows if len(row) == len(self.heads)]
        words = [[*head.split(), unit, *(row[i] for row in listed)] for i, (head, unit) in enumerate(self._both())]
        least = [max(1, *map(len, column)) for column in words]
        widths = least
        for lines in range(1, MOST_LINES):
            widths = [_width(head, width, lines) for head, width in zip(self.heads, least, strict=True)]
            if sum(widths) + len(GAP) * (len(widths) - 1) <= options.max_width:
                break
        heads = [[*wrap(head, width), unit] for (head, unit), width in zip(self._both(), widths, strict=True)]
        if not any(self.units):
            heads = [lines[:-1] for lines in heads]
        height = max(map(len, heads))
        upper = [[""] * (height - len(lines)) + lines for lines in heads]
        written = [(self.title, "bold")] if self.title else []
        written += [(self._line([column[place] for column in upper], widths), "bold") for place in range(height)]
        written.append(("─" * (sum(widths) + len(GAP) * (len(widths) - 1)), ""))
        for row in self.rows:
            style = "bold" if len(row) < len(self.heads) else self.styles.get(row[0].strip(), "")
            written.append((row[0] if len(row) < len(self.heads) else self._line(row, widths), style))
        for line, style in [*written, ("", "")]:
            yield Text(line, style=style, no_wrap=True, overflow="ignore")

    def _both(self) -> list[tuple[str, str]]:
        return list(zip(self.heads, self.units, strict=True))

    def _line(self, cells: Sequence[str], widths: Sequence[int]) -> str:
        padded = zip(cells, widths, self.numbers, strict=True)
        return GAP.join(cell.rjust(width) if number else cell.ljust(width) for cell, width, number in padded).rstrip()

    def markdown(self) -> str:
        """Return the table as Markdown, with an empty line after it."""
        rules = ["--:" if number else "---" for number in self.numbers]
        rows = [
            [f"**{row[0]}**", *[""] * (len(self.heads) - 1)] if len(row) < len(self.heads) else row for row in self.rows
        ]
        lines = [[cell.strip().replace("|", r"\|") for cell in row] for row in (self._headings(), rules, *rows)]
        body = "\n".join(f"| {' | '.join(line)} |" for line in lines)
        return f"**{self.title}**\n\n{body}\n" if self.title else f"{body}\n"

    def csv(self) -> str:
        """Return the table as CSV; its title is a comment."""
        stream = io.StringIO()
        csv.writer(stream, lineterminator="\n").writerows([self._headings(), *self.rows])
        return f"# {self.title}\n{stream.getvalue()}" if self.title else stream.getvalue()

    def html(self) -> str:
        """Return the table as HTML."""
        aligned = [f' style="text-align: {"right" if number else "left"}"' for number in self.numbers]
        heads = "".join(f"<th{a}>{escape(h)}</th>" for a, h in zip(aligned, self._headings(), strict=True))
        rows = ""
        for row in self.rows:
            bold = len(row) < len(self.heads) or "bold" in self.styles.get(row[0].strip(), "")
            cells = "".join(f"<td{a}>{escape(cell)}</td>" for a, cell in zip(aligned, row, strict=False))
            rows += f"<tr{BOLD if bold else ''}>{cells}</tr>"
        return f"<table><caption>{escape(self.title)}</caption><tr>{heads}</tr>{rows}</table>"

    def _headings(self) -> list[str]:
        return [f"{head}, {unit}" if unit else head for head, unit in self._both()]


def table(
    title: str, rows: Iterable[Sequence[Cell]], columns: Columns, *, styles: Mapping[str, str] | None = None
) -> Table:
    """Return a table of numbers in units that are fit to read: columns of one unit have one prefix.

    A row of one cell is the heading of those below. The columns have a unit and significant digits by their heading;
    None is a column of text. ``styles`` says how rows stand out, by their first cell.
    """
    cells = [tuple(row) for row in rows]
    specs = [("", 3) if spec is None else spec for spec in columns.values()]
    sizes: dict[str, list[float]] = {unit: [] for unit, _ in specs}
    for row in cells:
        for value, (unit, _) in zip(row, specs, strict=False):
            sizes[unit] += [value] if isinstance(value, float) else []
    plain = ("", *FIXED_UNITS)
    scales = {unit: (1.0, unit) if unit in plain else scale_for(found, unit) for unit, found in sizes.items()}
    written = [
        tuple(_written(cell, scales[unit][0], digits) for cell, (unit, digits) in zip(row, specs, strict=False))
        for row in cells
    ]
    units = tuple(scales[unit][1] for unit, _ in specs)
    numbers = tuple(spec is not None for spec in columns.values())
    return Table(title, tuple(columns), units, numbers, written, styles or {})


def _width(head: str, least: int, lines: int) -> int:
    """Return the least width of a column, at least one given, in which its heading takes no more than some lines."""
    return next(width for width in range(least, least + len(head) + 1) if len(wrap(head, width)) <= lines)


def _written(cell: Any, factor: float, digits: int) -> str:
    if isinstance(cell, str):
        return cell
    if cell is None:
        return "-"
    if isinstance(cell, tuple):
        value, spread = cell
        return f"{shown(factor * value, digits)} ± {factor * spread:.2g}"
    return str(cell) if isinstance(cell, int) else shown(factor * float(cell), digits)
