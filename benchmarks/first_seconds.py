"""Where the error of the first 5 s comes from: ``python -m benchmarks.first_seconds [--scenario NAME] [--seeds N]``.

Of the start of a motion, or of the first change of a scenario, three ratios to the error of PI over 5 s are printed:
that of ``adaptive``, that of ``oracle_tuned``, which knows the friction at every moment, and that of a controller which
is ``adaptive`` until some time and ``oracle_tuned`` from then on. The last one is what would be left if all were known
as soon as the joint has shown it for that time, and tells how much of the error is made before.
"""

from typing import Annotated

import numpy as np
import typer
from numpy.typing import NDArray
from rich.box import SIMPLE
from rich.table import Table

from adaptive_ff import Scenario, load_scenario, simulate
from adaptive_ff.comparison.matrix.cells import SCENARIOS
from benchmarks.wide import wide_console

SECONDS = 5.0
"""Time over which errors count, s."""

KNOWN_AFTER = (0.25, 0.5, 0.75, 1.0, 2.0)
"""Times after which all would be known, s."""

OWN, BASE, KNOWING = "adaptive", "pi", "oracle_tuned"
NAMES = ("paper_100hz", "delay", "friction_drops", "friction_triples")

Array = NDArray[np.float64]


def first_squares(scenario: Scenario, controller: str) -> Array:
    """Return the squared error of each solver step, rad^2/s^2, for 5 s from the first motion or change on."""
    run = simulate(scenario, controller, uncertain=False)
    square, period = np.square(run.reference - run.velocity), scenario.joint.solver_period
    first = round(scenario.change[0].time / period) if scenario.change else int(np.flatnonzero(run.reference)[0])
    return square[first : first + round(SECONDS / period)]


def ratios(scenario: Scenario) -> Array:
    """Return the ratios to PI of one reference: own, knowing, and knowing after each of the times."""
    own, base, knowing = (first_squares(scenario, name) for name in (OWN, BASE, KNOWING))
    cuts = [round(time / scenario.joint.solver_period) for time in KNOWN_AFTER]
    sums = [own.sum(), knowing.sum(), *(own[:cut].sum() + knowing[cut:].sum() for cut in cuts)]
    return np.sqrt(np.array(sums) / base.sum())


def main(
    scenario: Annotated[list[str] | None, typer.Option(help="Scenario; may be given several times.")] = None,
    first_seed: Annotated[int, typer.Option(min=0, help="First seed; 101 and more while tuning.")] = 1,
    seeds: Annotated[int, typer.Option(min=1, help="Number of references.")] = 30,
) -> None:
    """Print the error of the first 5 s over that of PI, and what of it is made before anything can be known."""
    table = Table(title=f"first {SECONDS:g} s over PI, median of {seeds} references, one draw each", box=SIMPLE)
    known = [f"known after {time:g} s" for time in KNOWN_AFTER]
    for heading in ("scenario", OWN, KNOWING, *known):
        table.add_column(heading, justify="left" if heading == "scenario" else "right")
    for name in scenario or NAMES:
        told = load_scenario(SCENARIOS / f"{name}.toml")
        begin = told.change[0].time if told.change else told.reference.fade_in
        short = told.modified(duration=min(told.duration, begin + 2.0 * SECONDS))
        found = np.array([ratios(short.modified(seed=seed)) for seed in range(first_seed, first_seed + seeds)])
        table.add_row(name, *(f"{ratio:.3f}" for ratio in np.median(found, axis=0)))
    wide_console().print(table)


if __name__ == "__main__":
    typer.run(main)
