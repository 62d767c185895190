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
from benchmarks.export.machines import emulated, objects, sanitized, sizes, unreached
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


SAMPLES = 1500
"""Samples of random inputs."""


def _loops() -> dict[str, list[Row]]:
    identity, single = closed_loops(2.0, print)
    return {"Closed loop: bits of torque and state": identity, "Single precision over the matrix": single}


SECTIONS: dict[str, Callable[[], dict[str, list[Row]]]] = {
    "python": lambda: {"Export, and the step behind Python": [*exporting(), *behind_python(5000)]},
    "objects": lambda: {"Objects for drives": objects()},
    "sizes": lambda: {"Sizes on a Cortex-M7, in double": sizes(), "What is never reached": unreached()},
    "machines": lambda: {"Other machines": emulated(SAMPLES)},
    "sanitizers": lambda: {"Sanitizers": sanitized(SAMPLES)},
    "speed": lambda: {"Time of a step": steps(20_000, 15)},
    "random": lambda: {"Random inputs: bits of torque and state": random_runs(SAMPLES)},
    "closed": _loops,
}
"""What is measured, by the name of a section."""


def main(
    only: Annotated[
        str | None,
        typer.Option(help="One section: random, closed, machines, objects, sizes, sanitizers, speed, python."),
    ] = None,
    json: Annotated[Path | None, typer.Option(help="Write all numbers there.")] = None,
) -> None:
    """Measure the exported controllers."""
    console = Console()
    if only is not None and only not in SECTIONS:
        print(f"benchmarks.export: --only = {only!r} is not known; there are {', '.join(SECTIONS)}", file=sys.stderr)
        raise typer.Exit(2)
    measured: dict[str, list[Row]] = {}
    for name, measure in SECTIONS.items():
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
