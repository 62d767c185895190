"""Command of ``benchmarks.never_worse``."""

import os
from collections.abc import Iterable
from concurrent.futures import ProcessPoolExecutor
from pathlib import Path
from typing import Annotated, Any

import typer
from rich.console import Console
from rich.progress import track

from adaptive_ff.comparison.comparison import BASELINE
from adaptive_ff.comparison.drawn_joints import CLASSES
from adaptive_ff.comparison.matrix.cells import scenario_names
from adaptive_ff.comparison.registry import CONTROLLERS
from adaptive_ff.comparison.windows import DRAWS, Judgement
from adaptive_ff.files import write_json
from benchmarks.never_worse.cases import (
    cascade_cases,
    drawn_cases,
    elastic_cases,
    machine_cases,
    named_cases,
    resting_cases,
    saturating_cases,
)
from benchmarks.never_worse.pages import write_tables
from benchmarks.never_worse.rows import as_json, judge_case, rows_of, table_of
from benchmarks.never_worse.situations import MADE, SITUATIONS
from benchmarks.wide import wide_console

REFERENCES = 30
"""References of each situation."""


def main(
    scenario: Annotated[
        list[str] | None, typer.Option(help="Scenario of the matrix, or another row; may be repeated.")
    ] = None,
    every: Annotated[bool, typer.Option("--every", help="All scenarios of the matrix, and all other rows.")] = False,
    joints: Annotated[int, typer.Option(min=0, help="Number of joints to draw as well.")] = 0,
    machines: Annotated[int, typer.Option(min=0, help="Number of machines to draw over decades as well.")] = 0,
    cascades: Annotated[int, typer.Option(min=0, help="Number of them behind a position loop, with a weight.")] = 0,
    resting: Annotated[int, typer.Option(min=0, help="Number of these with rests of seconds between moves.")] = 0,
    saturating: Annotated[int, typer.Option(min=0, help="Number of joints and machines that saturate untold.")] = 0,
    elastic: Annotated[int, typer.Option(min=0, help="Number of machines with elastic gears, or with play.")] = 0,
    controller: Annotated[str, typer.Option(help="Controller that is judged.")] = "adaptive",
    references: Annotated[int, typer.Option(min=1, help="Number of references of each scenario.")] = REFERENCES,
    first_seed: Annotated[int, typer.Option(min=0, help="Seed of the first reference, and of the draws.")] = 1,
    draws: Annotated[int, typer.Option(min=1, help="Draws of the noise for each reference.")] = DRAWS,
    workers: Annotated[int, typer.Option(min=1, help="Processes.")] = os.cpu_count() or 1,
    json: Annotated[Path | None, typer.Option(help="Write the rows there.")] = None,
    pages: Annotated[bool, typer.Option("--pages", help="Write the figures into README and the pages.")] = False,
) -> None:
    """Print how a controller fares against PI, and where what is asked is missed."""
    known = [*scenario_names(), *(name for table in MADE for name in table)]
    for option, given, allowed in (("--scenario", scenario or [], known), ("--controller", [controller], CONTROLLERS)):
        for name in given:
            if name not in allowed:
                raise typer.BadParameter(f"{name!r} is not known; there are {', '.join(allowed)}", param_hint=option)
    drawn = joints or machines or cascades or resting or saturating or elastic
    names = known if every else scenario or ([] if drawn else list(SITUATIONS))
    as_printed = controller, references, first_seed, draws, set(names)
    if pages and as_printed != ("adaptive", REFERENCES, 1, DRAWS, set(SITUATIONS)):
        raise typer.BadParameter("the pages have the situations, seeds and draws of the defaults", param_hint="--pages")
    console = wide_console()
    rows: list[dict[str, Any]] = []
    pair = "pi under other noise against pi" if controller == BASELINE else f"{controller} against pi"
    parts = {
        f"{pair}, {references} references of {draws} draws of the noise": named_cases(names, first_seed, references),
        f"{pair} on drawn joints, by fall of friction over Kp": drawn_cases(joints, first_seed),
        f"{pair} on machines drawn over decades, by their friction": machine_cases(machines, first_seed),
        f"position error of {pair} on machines with a weight, behind a position loop": cascade_cases(
            cascades, first_seed
        ),
        f"position error of {pair} on these with rests of 1 to 20 s between moves": resting_cases(resting, first_seed),
        f"{pair} where the drive saturates and tells nothing of it": saturating_cases(saturating, first_seed),
        f"{pair} on machines whose gear is elastic and not told of": elastic_cases(elastic, first_seed),
    }
    with ProcessPoolExecutor(workers) as pool:
        for title, cases in parts.items():
            if not cases:
                continue
            if not rows:
                judge_case(cases[0], controller, 1)  # here, so that workers find the controllers compiled

            def watch(results: Iterable[Judgement], total: int) -> Iterable[Judgement]:
                return track(results, "references", total=total, transient=True, console=Console(stderr=True))

            part = rows_of(cases, controller, draws, pool, watch)
            order = list(CLASSES)
            part.sort(key=lambda row: order.index(row["situation"]) if row["situation"] in CLASSES else -1)
            rows += part
            console.print(table_of(part, title))
    if json is not None:
        write_json(json, {"controller": controller, "rows": [as_json(row) for row in rows]})
    if pages:
        write_tables(rows)


if __name__ == "__main__":
    typer.run(main)
