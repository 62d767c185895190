"""Printing to a terminal: tables, warnings, progress."""

import csv
import io
import os
import sys
from collections.abc import Iterable, Sequence
from typing import Any

from rich.console import Console
from rich.progress import BarColumn, Progress, TextColumn, TimeRemainingColumn
from rich.table import Table
from rich.text import Text

from adaptive_ff.cli.common import SETTINGS, TableForm
from adaptive_ff.cli.printable import printable

COMPILES = "First run on this machine: the controllers are compiled, once (some ten seconds)."

LONGEST_LINE = 10_000
"""Characters of a line that no table comes to."""

LONGEST_LIST = 10
"""Most skipped pieces of a log that are printed; the JSON holds all."""


class Printer(Console):
    """Standard output, in the form that was asked for; a reader that has seen enough is no error."""

    def print(self, *objects: Any, **options: Any) -> None:
        """Print tables as text, Markdown or CSV; the latter two without anything between them; quiet, nothing."""
        if SETTINGS.quiet:
            return
        if SETTINGS.tables is TableForm.TEXT:
            before = self.width
            self.width = max([before, *(self._width_of(item) for item in objects if isinstance(item, Table))])
            super().print(*objects, **options)
            self.width = before
            return
        for item in objects:
            if isinstance(item, Table):
                super().print(plain_table(item, SETTINGS.tables), markup=False, highlight=False, soft_wrap=True)

    def _width_of(self, table: Table) -> int:
        """Return how wide a table is printed, so that nothing is cut; on a terminal headings may take several lines."""
        for column in table.columns:
            words = [word for cell in (column.header, *column.cells) for word in _plain(cell).split()]
            column.min_width = max(map(len, words), default=0)
            column.no_wrap = False
        least, most = self.measure(table, options=self.options.update(width=LONGEST_LINE))
        return least if self.is_terminal else most

    def show(self, items: Iterable[Table | str]) -> None:
        """Print tables and sentences in their order."""
        for item in items:
            if isinstance(item, str):
                self.say(item)
            else:
                self.print(item)

    def on_broken_pipe(self) -> None:
        """End the program quietly."""
        os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())
        raise SystemExit(0)

    def say(self, sentence: str) -> None:
        """Print a sentence as it is."""
        self.print(printable(sentence), highlight=False, markup=False, soft_wrap=True)


def plain_table(table: Table, form: TableForm) -> str:
    """Return a table as Markdown or CSV, with an empty line after it."""
    title = _plain(table.title or "")
    heads = [str(column.header) for column in table.columns]
    cells = zip(*(column.cells for column in table.columns), strict=True)
    rows = [[_plain(cell) for cell in row] for row in cells]
    if form is TableForm.CSV:
        stream = io.StringIO()
        csv.writer(stream, lineterminator="\n").writerows([heads, *rows])
        return f"# {title}\n{stream.getvalue()}" if title else stream.getvalue()
    rules = ["--:" if column.justify == "right" else "---" for column in table.columns]
    lines = [[cell.replace("|", r"\|") for cell in row] for row in (heads, rules, *rows)]
    body = "\n".join(f"| {' | '.join(line)} |" for line in lines)
    return f"**{title}**\n\n{body}\n" if title else f"{body}\n"


def _plain(cell: Any) -> str:
    return Text.from_markup(str(cell)).plain


def error_console() -> Console:
    """Return the console for what is no result: warnings, notices, progress."""
    return Console(stderr=True, soft_wrap=True, highlight=False)


def warn(errors: Console, cautions: Sequence[str]) -> None:
    """Print warnings, one a line."""
    for caution in cautions:
        errors.print(f"warning: {printable(caution)}", markup=False)


def warn_of_skips(errors: Console, skipped: Sequence[Any], file: str) -> None:
    """Print which pieces of a log were skipped, where it was cut, and why, but no more than people read."""
    warn(errors, [f"{_place(skip)}: {skip.reason}" for skip in skipped[:LONGEST_LIST]])
    if len(skipped) > LONGEST_LIST:
        warn(errors, [f"skipped: {len(skipped) - LONGEST_LIST} more, listed in {file}"])


def _place(skip: Any) -> str:
    if skip.start == skip.stop:
        return f"cut before sample {skip.start}"
    last = skip.stop - 1
    return f"skipped: sample {last}" if skip.start == last else f"skipped: samples {skip.start} to {last}"


def announce_compilation(errors: Console, loop: Any) -> None:
    """Say that a loop has to be compiled, where that has not been done on this machine."""
    from controllers import is_cached

    if not SETTINGS.quiet and not is_cached(loop):
        errors.print(COMPILES)


def progress_bars(errors: Console) -> Progress:
    """Return progress bars, which show only on a terminal and go when they are done."""
    columns = (TextColumn("{task.description}"), BarColumn(), TimeRemainingColumn())
    return Progress(*columns, console=errors, transient=True, disable=SETTINGS.quiet or not errors.is_terminal)
