"""Encoders of few counts, on joints of another simulator: ``python -m benchmarks.coarse_encoders [--joints 100]``.

The joints, loops and motions are those of :mod:`benchmarks.other_joints`, but each has an encoder of which a given
number of counts pass in a sampling period at the largest speed of its plan. Its velocity is the difference of two
readings, or that behind a low-pass of half a period to three. With less than a count in a period most samples show a
joint that stands, and the others one that leaps.
"""

import itertools
from pathlib import Path
from typing import Annotated, Any

import numpy as np
import typer
from rich.box import SIMPLE
from rich.table import Table

from adaptive_ff.files import write_json
from benchmarks.other_joints import HEADINGS, draw, figures_of, judged
from benchmarks.robot.in_turn import CORES, Workers, run_seeds
from benchmarks.wide import wide_console

COUNTS = (0.1, 0.3, 1.0, 3.0, 10.0)
"""Counts in a period at the largest speed."""

SENSORS = {"encoder": "difference", "low-passed encoder": "behind a low-pass"}
"""What becomes of them, and how the table says it."""


def run_joint(seed: int) -> list[dict[str, Any]]:
    """Return the figures of a seed with every encoder."""
    joint, loop, plan = draw(seed)
    fastest, rows = float(np.abs(plan).max()), []
    for sensor, counts in itertools.product(SENSORS, COUNTS):
        coarse = loop._replace(sensor=sensor, resolution=fastest * loop.period / counts)
        rows.append({"counts": counts, **judged(joint, coarse, plan, seed)})
    return rows


def table_of(rows: list[dict[str, Any]]) -> Table:
    """Return the table."""
    table = Table(title="PI's error over that of adaptive, with few counts", box=SIMPLE, title_style="bold")
    table.add_column("velocity")
    table.add_column("counts in a period", justify="right")
    for heading in HEADINGS:
        table.add_column(heading, justify="right")
    for sensor, counts in itertools.product(SENSORS, COUNTS):
        found = [row for row in rows if row["sensor"] == sensor and row["counts"] == counts]
        table.add_row(SENSORS[sensor] if counts == COUNTS[0] else "", f"{counts:g}", *figures_of(found))
    return table


def main(
    joints: Annotated[int, typer.Option(min=1, help="How many joints are drawn.")] = 100,
    first: Annotated[int, typer.Option(min=0, help="First seed.")] = 1,
    workers: Workers = CORES,
    json: Annotated[Path | None, typer.Option(help="Write the figures there.")] = None,
) -> None:
    """Drive joints with encoders of few counts, with and without compensation, and print how they compare."""
    found = run_seeds(run_joint, range(first, first + joints), workers, "joints")
    rows = list(itertools.chain.from_iterable(found))
    wide_console().print(table_of(rows))
    if json is not None:
        write_json(json, {"joints": rows})


if __name__ == "__main__":
    typer.run(main)
