"""A push of 80 N m for 3 s on the built-in joint: what it teaches, and how long it is seen in the error.

``python -m benchmarks.push [--first-seed 1 --seeds 8 --load 80 --length 3]``

Someone leans on the joint when it has learnt for half a minute, and lets go. Shown for every seed is by how much the
estimates of inertia and friction differ from those just before the push, at most, from its begin to the end of the run,
as a share; and the error from 5 to 10 s after the push over that of the same seconds undisturbed. The push may be
followed by offset and observer only: 10 % and 1.2 times are allowed.
"""

from typing import Annotated

import numpy as np
import typer
from rich.box import SIMPLE
from rich.table import Table

from adaptive_ff import Run, load_scenario, simulate
from benchmarks.wide import wide_console

BEGIN, AFTER, WINDOW = 30.0, 5.0, 5.0  # s
DURATION = 60.0  # s
WATCHED = ("inertia", "coulomb", "stiction", "viscous")
MOST_MOVED, MOST_ERROR = 0.1, 1.2


def moved(run: Run) -> dict[str, float]:
    """Return by how much each estimate differs from the one before the push at most, as a share of it."""
    begin = int(np.searchsorted(run.time, BEGIN - 1e-6))
    shares = {}
    for name in WATCHED:
        series = run.estimates[name]
        shares[name] = float(np.max(np.abs(series[begin:] - series[begin - 1])) / series[begin - 1])
    return shares


def error_after(run: Run, end: float) -> float:
    """Return the rms error (rad/s) of the seconds after the push that ends at a time (s)."""
    time = run.solver_time
    judged = (time >= end + AFTER) & (time < end + AFTER + WINDOW)
    return float(np.sqrt(np.mean((run.reference - run.velocity)[judged] ** 2)))


def measure(seed: int, load: float, length: float, identify: str | None, begin: float = BEGIN) -> dict[str, float]:
    """Return how far the estimates move, and the ratio of the errors after the push, for one seed."""
    end = begin + length
    still = load_scenario().modified(
        seed=seed, duration=DURATION, controllers=["adaptive"], adaptation={"identify": identify} if identify else {}
    )
    pushed = still.modified(change=[{"time": begin, "load": load}, {"time": end, "load": 0.0}])
    run, calm = simulate(pushed, "adaptive"), simulate(still, "adaptive")
    return moved(run) | {"error after": error_after(run, end) / error_after(calm, end)}


def main(
    first_seed: Annotated[int, typer.Option(min=0, help="First seed; 101 and more while tuning.")] = 1,
    seeds: Annotated[int, typer.Option(min=1, help="Number of seeds.")] = 8,
    load: Annotated[float, typer.Option(help="Torque of the push, N m.")] = 80.0,
    length: Annotated[float, typer.Option(help="Length of the push, s.")] = 3.0,
    identify: Annotated[str | None, typer.Option(help="What is identified; by default as in every scenario.")] = None,
) -> None:
    """Print how far a push moves the estimates, and what it leaves of the tracking."""
    names = (*WATCHED, "error after")
    table = Table(title=f"push of {load:g} N m for {length:g} s", box=SIMPLE)
    for heading in ("seed", *names):
        table.add_column(heading, justify="right")
    found = {seed: measure(seed, load, length, identify) for seed in range(first_seed, first_seed + seeds)}
    worst = {name: max(one[name] for one in found.values()) for name in names}
    for label, row in [*((str(seed), row) for seed, row in found.items()), ("worst", worst)]:
        shares = [f"{100.0 * row[name]:.1f} %" for name in WATCHED]
        table.add_row(label, *shares, f"{row['error after']:.2f}")
    console = wide_console()
    console.print(table)
    missed = [name for name in names if worst[name] > (MOST_ERROR if name == "error after" else MOST_MOVED)]
    console.print(f"asked: at most {100 * MOST_MOVED:g} % and {MOST_ERROR:g}; missed: {', '.join(missed) or 'nothing'}")


if __name__ == "__main__":
    typer.run(main)
