"""The scenario matrix: ``python -m benchmarks.tracking [--only NAME] [--seeds N] [--out DIR] [--json FILE]``.

Every controller on every scenario of ``adaptive-ff matrix``, over seeds from 1 on; then again with the fastest PI
loop that a maximum sensitivity of 1.7 and the noise allow. Results are kept under ``--out`` as they come: an
interrupted call goes on where it stopped. Under ``--out`` are then, too: the tables (``matrix.md``), pictures of who
wins where, every run's figures (``runs.csv``) and every scenario with its seed, for ``adaptive-ff compare``. Printed
beside them is what the adaptive controller is asked to reach.
"""

import sys
from pathlib import Path
from typing import Annotated

import typer

from adaptive_ff.cli.matrix import ALL, run_and_print
from adaptive_ff.errors import InputError
from benchmarks.tracking.cost import cost_table
from benchmarks.tracking.targets import targets_table
from benchmarks.wide import wide_console


def main(
    only: Annotated[list[str] | None, typer.Option(help="Scenario to run; may be given several times.")] = None,
    controller: Annotated[list[str] | None, typer.Option(help="Controller to run; all by default.")] = None,
    seeds: Annotated[int, typer.Option(min=1, help="Number of seeds, from 1 on.")] = 20,
    out: Annotated[Path, typer.Option(help="Folder for results.")] = Path("results/tracking"),
    json: Annotated[Path | None, typer.Option(help="Write all figures there, too.")] = None,
    fastest: Annotated[bool, typer.Option(help="Also run everything with the fastest PI loop.")] = True,
) -> None:
    """Run the matrix and say who wins where."""
    try:
        results = run_and_print(None, only, controller or [ALL], seeds, fastest, out, json, wide_console())
    except InputError as error:
        print(f"benchmarks.tracking: {error}", file=sys.stderr)
        raise typer.Exit(2) from error
    for table in (targets_table(results), cost_table(results)):
        if table is not None:
            wide_console().print(table)


if __name__ == "__main__":
    typer.run(main)
