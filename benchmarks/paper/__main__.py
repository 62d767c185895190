"""Every experiment of Ruderman 2013: ``python -m benchmarks.paper [--out DIR] [--json FILE]``."""

import sys
import time
from collections.abc import Callable
from contextlib import ExitStack
from pathlib import Path
from typing import Annotated, Any

import typer
from rich.box import SIMPLE
from rich.markup import escape
from rich.table import Table

from adaptive_ff.cli.output import error_console, progress_bars
from adaptive_ff.errors import InputError
from adaptive_ff.files import staged, write_json
from adaptive_ff.report.style import stamp, write_figures
from benchmarks.paper import closed_loop, misprints, offline, online, reversal, rounding, stribeck
from benchmarks.paper.experiment import Experiment
from benchmarks.wide import wide_console

EXPERIMENTS: dict[str, Callable[[], Experiment]] = {
    "misprints": misprints.run,
    "Fig. 3": reversal.run,
    "Fig. 4": offline.run,
    "Fig. 5": online.run,
    "rounding": rounding.run,
    "Fig. 8": stribeck.run,
    "Figs. 7, 9-12": closed_loop.run,
}
"""In the order of the table."""

SOURCE = "seed 1, python -m benchmarks.paper"  # what stands below each picture

BAD_INPUT = 2


def run_all() -> list[Experiment]:
    """Run every experiment and show progress on a terminal."""
    with progress_bars(error_console()) as bars:
        return [run() for run in bars.track(EXPERIMENTS.values(), description="experiments")]


def table_of(experiments: list[Experiment]) -> Table:
    """Return all figures in one table, experiment after experiment."""
    table = Table(title="Ruderman 2013 in simulation", box=SIMPLE, title_style="bold", expand=True)
    table.add_column("quantity", ratio=3, overflow="fold")
    table.add_column("value", ratio=2, justify="right", overflow="fold")
    table.add_column("target", min_width=9, justify="right")
    table.add_column("met", width=3)
    for experiment in experiments:
        table.add_section()
        table.add_row(escape(experiment.title), "", "", "", style="bold")
        for row in experiment.rows:
            value = row.value if isinstance(row.value, str) else f"{row.value:.4g}"
            cells = (f"  {row.quantity}", value, row.target, {None: "", True: "yes", False: "NO"}[row.met])
            table.add_row(*map(escape, cells), style="bold red" if row.met is False else None)
    return table


def to_dict(experiments: list[Experiment]) -> dict[str, Any]:
    """Return the result as it goes into a JSON file."""
    return {
        "experiments": [
            {
                "title": experiment.title,
                "rows": [vars(row) for row in experiment.rows],
                "notes": list(experiment.notes),
                "figures": sorted(experiment.figures),
            }
            for experiment in experiments
        ],
        **tally(experiments),
    }


def tally(experiments: list[Experiment]) -> dict[str, int]:
    """Return how many targets are met and missed."""
    verdicts = [row.met for experiment in experiments for row in experiment.rows if row.met is not None]
    return {"targets_met": verdicts.count(True), "targets_missed": verdicts.count(False)}


def run_and_write(out: Path, json: Path | None) -> list[Experiment]:
    """Run every experiment; write figures and JSON, all or none, after a check that they can be written."""
    with ExitStack() as stack:
        beside = None if json is None else stack.enter_context(staged(json.parent))
        stage = stack.enter_context(staged(out))
        if json is not None and json.is_dir():
            raise InputError(f"{json}: cannot be written: it is a folder")
        experiments = run_all()
        for experiment in experiments:
            stamp(experiment.figures.values(), SOURCE)
            write_figures(experiment.figures, stage, ["png"])
        if json is not None and beside is not None:
            write_json(beside / json.name, to_dict(experiments))
    return experiments


def main(
    out: Annotated[Path, typer.Option(help="Folder for the figures (PNG).")] = Path("results/paper"),
    json: Annotated[Path | None, typer.Option(help="Write table and notes there.")] = None,
) -> None:
    """Run every experiment of the paper in simulation, print one table and draw its figures."""
    started = time.perf_counter()
    console = wide_console()
    try:
        experiments = run_and_write(out, json)
    except InputError as error:
        print(f"benchmarks.paper: {error}", file=sys.stderr)
        raise typer.Exit(BAD_INPUT) from error
    console.print(table_of(experiments))
    for experiment in experiments:
        console.print("\n- ".join([experiment.title, *experiment.notes]), highlight=False, markup=False)
    counts = tally(experiments)
    console.print(f"Targets met: {counts['targets_met']}, missed: {counts['targets_missed']}.", highlight=False)
    elapsed = time.perf_counter() - started
    console.print(f"Figures are in {out}. Wall time {elapsed:.1f} s.", highlight=False, markup=False, soft_wrap=True)


if __name__ == "__main__":
    typer.run(main)
