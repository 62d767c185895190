"""Seeds that are run by processes."""

import os
from collections.abc import Callable
from typing import Annotated, Any

import typer

from adaptive_ff.cli.terminal import error_console, progress_bars
from adaptive_ff.workers import pool_of_workers

Workers = Annotated[int, typer.Option(min=1, help="Processes.")]
CORES = os.cpu_count() or 1


def run_seeds(run_seed: Callable[[int], dict[str, Any]], seeds: range, workers: int, what: str) -> list[dict[str, Any]]:
    """Return the row of each seed, in order; ``what`` is counted while they run."""
    rows = []
    with pool_of_workers(workers) as pool, progress_bars(error_console()) as progress:
        task = progress.add_task(what, total=len(seeds))
        for row in pool.map(run_seed, seeds):
            rows.append(row)
            progress.advance(task)
    return rows
