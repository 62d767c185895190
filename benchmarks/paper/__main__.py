"""Every experiment of Ruderman 2013: ``python -m benchmarks.paper [--out DIR] [--json FILE]``."""

import sys
import time
from collections.abc import Callable, Iterator
from contextlib import ExitStack
from pathlib import Path
from typing import Annotated, Any

import typer

from adaptive_ff.cli.output import error_console, progress_bars
from adaptive_ff.errors import InputError
from adaptive_ff.files import staged, write_json
from adaptive_ff.report.style import stamp, write_figures
from benchmarks.paper import closed_loop, misprints, offline, online, reversal, rounding, stribeck
from benchmarks.paper.experiment import Experiment

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


def printed(experiment: Experiment) -> Iterator[str]:
    """Yield the lines that are printed of an experiment: its figures, then the notes."""
    yield f"\n{experiment.title}"
    for row in experiment.rows:
        value = row.value if isinstance(row.value, str) else f"{row.value:.4g}"
        asked = "" if row.met is None else f" (target {row.target}: {'met' if row.met else 'NOT MET'})"
        yield f"  {row.quantity}: {value}{asked}"
    yield from (f"- {note}" for note in experiment.notes)


def to_dict(experiments: list[Experiment]) -> dict[str, Any]:
    """Return the result as it goes into a JSON file."""
    found = [
        {**vars(experiment), "rows": list(map(vars, experiment.rows)), "figures": sorted(experiment.figures)}
        for experiment in experiments
    ]
    return {"experiments": found, **tally(experiments)}


def tally(experiments: list[Experiment]) -> dict[str, int]:
    """Return how many targets are met and missed."""
    verdicts = [row.met for experiment in experiments for row in experiment.rows]
    return {"targets_met": verdicts.count(True), "targets_missed": verdicts.count(False)}


def run_and_write(out: Path, json: Path | None) -> list[Experiment]:
    """Run every experiment; write figures and JSON, all or none, after a check that they can be written."""
    with ExitStack() as stack:
        beside = None if json is None else stack.enter_context(staged(json.parent))
        stage = stack.enter_context(staged(out))
        if json is not None and json.is_dir():
            raise InputError(f"{json}: cannot be written: it is a folder")
        bars = stack.enter_context(progress_bars(error_console()))
        experiments = [run() for run in bars.track(EXPERIMENTS.values(), description="experiments")]
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
    """Run every experiment of the paper in simulation, print what was found and draw its figures."""
    started = time.perf_counter()
    try:
        experiments = run_and_write(out, json)
    except InputError as error:
        print(f"benchmarks.paper: {error}", file=sys.stderr)
        raise typer.Exit(2) from error
    for experiment in experiments:
        print(*printed(experiment), sep="\n")
    counts, elapsed = tally(experiments), time.perf_counter() - started
    print(f"\nTargets met: {counts['targets_met']}, missed: {counts['targets_missed']}.")
    print(f"Figures are in {out}. Wall time {elapsed:.1f} s.")


if __name__ == "__main__":
    typer.run(main)
