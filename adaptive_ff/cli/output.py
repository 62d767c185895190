"""What a command prints and writes: its results whole or not at all, tables, warnings, progress."""

import os
import sys
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from contextlib import ExitStack, contextmanager
from dataclasses import dataclass, field
from functools import partial
from pathlib import Path
from tempfile import TemporaryDirectory
from textwrap import fill
from typing import TYPE_CHECKING, Any

from rich.console import Console
from rich.progress import BarColumn, Progress, TaskID, TextColumn, TimeElapsedColumn, TimeRemainingColumn

from adaptive_ff.cli.options import KNOWN_FORMATS, SETTINGS, STANDARD_OUTPUT, Output, TableForm, ViewerOutput
from adaptive_ff.errors import InputError

if TYPE_CHECKING:
    from matplotlib.figure import Figure

Shown = Iterable[Any]
"""Tables (:class:`adaptive_ff.report.table.Table`) and sentences in their order."""

COMPILES = "First run on this machine: the controllers are compiled, once (some ten seconds)."

LONGEST_LIST = 10  # most skipped segments of a log that are printed; the JSON holds all


@dataclass
class Results:
    """Results of a command on their way to their places."""

    output: Output  # what the user chose
    stage: Path  # temporary folder whose files are moved to the folder of the output when all are complete
    beside: dict[Path, Path]  # by single file, where to write it for the time being
    shown: list[Any] = field(default_factory=list)  # what is printed when all is written

    def write(
        self,
        name: str,
        result: Any,
        shown: Shown,
        figures: "Mapping[str, Figure]",
        *,
        title: str,
        details: Mapping[str, str] | None = None,
        source: str | None = None,
        further: Shown = (),
        series: Any = None,
    ) -> None:
        """Write JSON, pictures, and on demand the page and the series of a result for viewers.

        Without a name there is nothing but the copy that ``--json`` asks for. What is shown, tables and sentences in
        their order, is printed at the end; only the page has the title, the details (longer texts by heading) and what
        is further. The source is what the pictures say below that they are of, where they do not yet.
        """
        from adaptive_ff.files import write_result
        from adaptive_ff.report.page import NAME, write_report
        from adaptive_ff.report.style import stamp, write_figures

        self.shown += shown
        if source is not None:
            stamp(figures.values(), source)
        write_figures(figures, self.stage, self.output.drawn)
        if self.output.report:
            write_report(self.stage / NAME, title, [*self.shown, *further], figures, details)
        copy = [] if self.output.json is None else [self.beside[self.output.json]]
        for file in [*([self.stage / name] if name else []), *copy]:
            write_result(file, result)
        if files := series_files(self.output):
            from adaptive_ff.report.viewers import layout, write_mcap

            write_mcap(self.beside[files[0]], series)
            self.beside[files[1]].write_text(layout(series), encoding="utf-8")

    def left_behind(self, pictures: Iterable[str], files: Iterable[str]) -> None:
        """Say which of the command's pictures (without an ending) and files stay in its folder from earlier."""
        from adaptive_ff.report.page import NAME

        out = self.output.out
        names = [*(f"{name}.{ending}" for name in pictures for ending in KNOWN_FORMATS), *files, NAME]
        there = sorted(name for name in names if (out / name).is_file() and not (self.stage / name).exists())
        self.shown += [f"Of an earlier run, not of this one, in {out}: {', '.join(there)}"] if there else []


@contextmanager
def staged_results(output: Output, *further: Path | None) -> Iterator[Results]:
    """Stage a folder and single files elsewhere; move them to their places when all are complete, and print."""
    from adaptive_ff.files import staged

    wanted = [file for file in (output.json, *series_files(output), *further) if file is not None]
    with ExitStack() as stack:
        beside = {file: _staged_file(file, stack) for file in wanted}
        stage = stack.enter_context(staged(output.out))
        for file in wanted:
            if os.path.isdir(file) and file != STANDARD_OUTPUT:
                raise InputError(f"{file}: cannot be written: it is a folder")
        found = Results(output, stage, beside)
        yield found
        printed = beside[STANDARD_OUTPUT].read_text(encoding="utf-8") if STANDARD_OUTPUT in beside else ""
    sys.stdout.write(printed)
    Printer().show(found.shown)


def series_files(output: Output) -> list[Path]:
    """Return the file of the series for viewers, and its layout, where ``--mcap`` asks for them."""
    file = output.mcap if isinstance(output, ViewerOutput) else None
    return [] if file is None else [file, file.with_suffix(".xml")]


def _staged_file(file: Path, stack: ExitStack) -> Path:
    from adaptive_ff.files import staged

    if file == STANDARD_OUTPUT:
        return Path(stack.enter_context(TemporaryDirectory())) / "result.json"
    return stack.enter_context(staged(file.parent, file)) / file.name


class Printer(Console):
    """Standard output, in the form that was asked for; a reader that closes it early is no error."""

    def show(self, items: Shown) -> None:
        """Print tables and sentences in their order; Markdown and CSV without a sentence between, quiet nothing."""
        if SETTINGS.quiet:
            return
        form = SETTINGS.tables
        for item in items:
            if isinstance(item, str):
                if form is TableForm.TEXT:
                    text = fill(printable(item), self.width, break_long_words=False, break_on_hyphens=False)
                    self.print(text, highlight=False, markup=False, soft_wrap=True)
            elif form is TableForm.TEXT:
                self.print(item, soft_wrap=True)
            else:
                text = item.markdown() if form is TableForm.MARKDOWN else item.csv()
                self.print(text, markup=False, highlight=False, soft_wrap=True)

    def on_broken_pipe(self) -> None:
        """End the program quietly."""
        os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())
        raise SystemExit(0)

    def say(self, sentence: str) -> None:
        """Print a sentence as it is."""
        self.show([sentence])


def printable(text: str) -> str:
    """Return a text with what a terminal would obey written out: names of columns come from files."""
    return "".join(c if c.isprintable() or c == "\n" else repr(c)[1:-1] for c in text)


def error_console() -> Console:
    """Return the console for what is no result: warnings, notices, progress."""
    return Console(stderr=True, soft_wrap=True, highlight=False)


def warn(cautions: Iterable[str]) -> None:
    """Print warnings, one a line."""
    errors = error_console()
    for caution in cautions:
        errors.print(f"warning: {printable(caution)}", markup=False)


def warn_of_skips(skipped: Sequence[Any], file: str) -> None:
    """Print which segments of a log were skipped, where it was cut, and why, but no more than people read."""
    warn(f"{_place(skip)} of the cleaned log: {skip.reason}" for skip in skipped[:LONGEST_LIST])
    if len(skipped) > LONGEST_LIST:
        warn([f"skipped: {len(skipped) - LONGEST_LIST} more, listed in {file}"])


def _place(skip: Any) -> str:
    if skip.start == skip.stop:
        return f"cut before sample {skip.start}"
    last = skip.stop - 1
    return f"skipped: sample {last}" if skip.start == last else f"skipped: samples {skip.start} to {last}"


@contextmanager
def bars(*names: str, loop: Any = None) -> Iterator[dict[str, Callable[[float], None]]]:
    """Yield what moves each bar of progress to a fraction done; they show only on a terminal and go when it ends.

    A loop that has still to be compiled on this machine is announced; by default that of a run.
    """
    from adaptive_ff.simulation.loop import run_in_memory
    from controllers import is_cached

    errors = error_console()
    if not SETTINGS.quiet and not is_cached(run_in_memory if loop is None else loop):
        errors.print(COMPILES)
    with progress_bars(errors) as progress:
        yield {name: partial(_move, progress, progress.add_task(name, total=1.0)) for name in names}


def _move(progress: Progress, task: TaskID, fraction: float) -> None:
    progress.update(task, completed=fraction)


def progress_bars(errors: Console) -> Progress:
    """Return progress bars, which show only on a terminal and go when they are done."""
    columns = (TextColumn("{task.description}"), BarColumn(), TimeElapsedColumn(), TimeRemainingColumn())
    return Progress(*columns, console=errors, transient=True, disable=SETTINGS.quiet or not errors.is_terminal)
