"""Measured machines: ``python -m benchmarks.measured [--out DIR] [--json FILE] [--long]``.

Each joint is identified from a log, its logs are replayed, and the identified joint runs in the closed loop of
``compare`` along the recorded reference. Data sets that are not there are left out, and it is said how to get them.
``--long`` measures time and memory of the replay of a long log instead.
"""

import re
from pathlib import Path
from typing import Annotated

import typer

from adaptive_ff.files import write_json
from benchmarks.measured.figures import draw_machine
from benchmarks.measured.identified_joint import ASSUMED
from benchmarks.measured.long_log import measure as measure_long
from benchmarks.measured.long_log import table as long_table
from benchmarks.measured.machines import DATA, JOBS
from benchmarks.measured.results import Result, measure, results_table, score_sentence
from benchmarks.wide import wide_console


def main(
    data: Annotated[Path, typer.Option(help="Folder of the data sets, one folder a machine.")] = DATA,
    out: Annotated[Path, typer.Option(help="Folder for a figure a machine.")] = Path("results"),
    json: Annotated[Path | None, typer.Option(help="Write all results there.")] = None,
    long: Annotated[bool, typer.Option("--long", help="Time and memory of the replay of a long log, instead.")] = False,
    samples: Annotated[int, typer.Option(min=1000, help="Samples of the long log.")] = 10_000_000,
) -> None:
    """Print one table, and draw one figure a machine."""
    console = wide_console()
    if long:
        console.print(long_table(measure_long(samples)))
        return
    results: list[Result] = []
    for machine in dict.fromkeys(job.data for job in JOBS):
        missing = machine.missing(data)
        if missing:
            files = ", ".join(str(data / machine.folder / file) for file in missing)
            console.print(
                f"{machine.name} is left out: {files} not there. Source: {machine.origin}.",
                highlight=False,
                soft_wrap=True,
            )
            continue
        done = [measure(job, data) for job in JOBS if job.data is machine]
        out.mkdir(parents=True, exist_ok=True)
        draw_machine(done, out / f"{re.sub('[^a-z0-9]+', '_', machine.name.lower())}.png")
        results += done
    if results:
        console.print(results_table(results))
        console.print(
            "Feedforwards: none; the machine's own; fixed, fitted to the first half of the log, so that only the "
            "second half tells how it fares on what it has not seen; adaptive from a cold start; from the state saved "
            "at the end of the first log.",
            highlight=False,
            soft_wrap=True,
        )
        for result in results:
            if result.score is not None:
                console.print(score_sentence(result), highlight=False, soft_wrap=True)
        console.print(ASSUMED, highlight=False, soft_wrap=True)
        console.print(f"Figures are in {out}", highlight=False, soft_wrap=True)
    if json is not None:
        write_json(json, {result.job.name: result.to_dict() for result in results})


if __name__ == "__main__":
    typer.run(main)
