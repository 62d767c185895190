"""``python -m benchmarks.export``: every target of the export, measured and printed."""

import sys
from collections.abc import Callable
from pathlib import Path
from typing import Annotated

import typer
from rich.box import SIMPLE
from rich.console import Console
from rich.table import Table

from adaptive_ff.files import write_json
from benchmarks.export.identity import closed_loops, random_runs
from benchmarks.export.machines import emulated, objects, sanitized
from benchmarks.export.rows import Row
from benchmarks.export.speed import behind_python, exporting, steps

VERDICTS = {True: "yes", False: "NO", None: ""}


def as_table(title: str, rows: list[Row]) -> Table:
    """Return the rows of a section as they are printed."""
    table = Table(title=title, box=SIMPLE, title_justify="left")
    for heading in ("", "found", "target", "met"):
        table.add_column(heading, overflow="fold")
    for row in rows:
        table.add_row(row.what, row.figure, row.target, VERDICTS[row.met])
    return table


def main(
    only: Annotated[
        str | None, typer.Option(help="One section: random, closed, machines, objects, sanitizers, speed, python.")
    ] = None,
    samples: Annotated[int, typer.Option(help="Samples of random inputs.")] = 1500,
    seconds: Annotated[float | None, typer.Option(help="Longest closed-loop run, s; all of it if not given.")] = None,
    json: Annotated[Path | None, typer.Option(help="Write all numbers there.")] = None,
) -> None:
    """Measure the exported controllers."""
    console, errors = Console(), Console(stderr=True, highlight=False)

    def loops() -> dict[str, list[Row]]:
        identity, single = closed_loops(seconds, errors.print)
        return {"Closed loop: bits of torque and state": identity, "Single precision over the matrix": single}

    sections: dict[str, Callable[[], dict[str, list[Row]]]] = {
        "python": lambda: {"Export, and the step behind Python": [*exporting(), *behind_python(5000)]},
        "objects": lambda: {"Objects for drives": objects()},
        "machines": lambda: {"Other machines": emulated(samples)},
        "sanitizers": lambda: {"Sanitizers": sanitized(samples)},
        "speed": lambda: {"Time of a step": steps(20_000, 15)},
        "random": lambda: {"Random inputs: bits of torque and state": random_runs(samples)},
        "closed": loops,
    }
    if only is not None and only not in sections:
        print(f"benchmarks.export: --only = {only!r} is not known; there are {', '.join(sections)}", file=sys.stderr)
        raise typer.Exit(2)
    measured: dict[str, list[Row]] = {}
    for name, measure in sections.items():
        if only in (None, name):
            for title, rows in measure().items():
                measured[title] = rows
                console.print(as_table(title, rows))
    verdicts = [row.met for rows in measured.values() for row in rows if row.met is not None]
    console.print(f"{sum(verdicts)} of {len(verdicts)} targets are met", highlight=False)
    if json is not None:
        write_json(json, {title: [row._asdict() for row in rows] for title, rows in measured.items()})


if __name__ == "__main__":
    typer.run(main)
