"""Cases that are named in part, run by processes, and the options of the commands that do so."""

import os
from collections.abc import Callable, Sequence
from typing import Annotated, Any, Protocol, TypeVar

import typer

from adaptive_ff.cli.terminal import error_console, progress_bars
from adaptive_ff.workers import pool_of_workers

Only = Annotated[str, typer.Option(help="Cases whose name holds this text.")]
Seeds = Annotated[int, typer.Option(min=1, help="Number of seeds, from the first on.")]
First = Annotated[int, typer.Option(min=0, help="First seed.")]
Workers = Annotated[int, typer.Option(min=1, help="Processes.")]
CORES = os.cpu_count() or 1


class Named(Protocol):
    """A case with a name."""

    @property
    def name(self) -> str:
        """What distinguishes it."""


AnyCase = TypeVar("AnyCase", bound=Named)


def chosen_cases(cases: Sequence[AnyCase], only: str) -> list[AnyCase]:
    """Return the cases whose name holds a text, or raise ``typer.BadParameter`` where none does."""
    chosen = [case for case in cases if only in case.name]
    if not chosen:
        raise typer.BadParameter(f"{only!r} is in no case", param_hint="--only")
    return chosen


def run_seeds(run_seed: Callable[[int], dict[str, Any]], seeds: range, workers: int, what: str) -> list[dict[str, Any]]:
    """Return the row of each seed, in order; ``what`` is counted while they run."""
    rows = []
    with pool_of_workers(workers) as pool, progress_bars(error_console()) as progress:
        task = progress.add_task(what, total=len(seeds))
        for row in pool.map(run_seed, seeds):
            rows.append(row)
            progress.advance(task)
    return rows


def run_in_turn(
    run_case: Callable[[AnyCase, range, float], dict[str, Any]],
    chosen: Sequence[AnyCase],
    numbers: range,
    duration: float,
    workers: int,
) -> list[dict[str, Any]]:
    """Return the row of each case, in order, for seeds and a duration in s."""
    rows = []
    with pool_of_workers(workers) as pool, progress_bars(error_console()) as progress:
        task = progress.add_task("cases", total=len(chosen))
        # the first alone, so that the others find the controllers compiled
        rows.append(pool.submit(run_case, chosen[0], numbers, duration).result())
        progress.advance(task)
        for waiting in [pool.submit(run_case, case, numbers, duration) for case in chosen[1:]]:
            rows.append(waiting.result())
            progress.advance(task)
    return rows
