"""Machines in MuJoCo at rest behind a position loop: ``python -m benchmarks.robot.holding``.

Hinges and a two-link arm with MuJoCo's own Coulomb or LuGre friction move from point to point, come to rest, and hold
their positions; gravity is learnt. Figures are root mean squares over the last 10 s and all seeds, joint by joint:

- *velocity*: true velocity, mrad/s;
- *torque steps*: differences of the torque between samples, N m.

Allowed is what :mod:`benchmarks.holding` allows: 1.2 times the figure of PI or, where PI is quieter than that, one
encoder count in a sampling period and 0.1 N m.
"""

import itertools
from pathlib import Path
from typing import Annotated, Any, NamedTuple

import numpy as np
import typer
from numpy.typing import NDArray
from rich.box import SIMPLE
from rich.table import Table

from adaptive_ff.files import write_json
from benchmarks.holding import HOLDING, RATES, SETTLING, allowed
from benchmarks.robot.in_turn import CORES, First, Only, Seeds, Workers, chosen_cases, run_in_turn
from benchmarks.robot.loops import MAKERS, Driven, Setup, drive
from benchmarks.robot.machines import make_machine
from benchmarks.robot.plans import moves, then_rest
from benchmarks.wide import wide_console

Squares = dict[str, NDArray[np.float64]]
"""Mean squares by name, for each joint."""

MACHINES = ("hinge", "two-link arm")
FRICTIONS = ("coulomb", "LuGre")
CONTROLLERS = ("pi", "adaptive")
UNITS = {"velocity": 1e3, "steps": 1.0}
"""What a figure is multiplied by in the table: mrad/s, N m."""


class Case(NamedTuple):
    """A machine and the rate at which it is driven, Hz."""

    machine: str
    friction: str
    rate: int

    @property
    def name(self) -> str:
        """Its name in the table."""
        return f"{self.machine}, {self.friction}, {self.rate} Hz"


def cases() -> list[Case]:
    """Return all of them."""
    return [Case(*choice) for choice in itertools.product(MACHINES, FRICTIONS, RATES)]


def squares(driven: Driven, rate: int) -> Squares:
    """Return the mean squares of a run over its last 10 s, where the plan rests, for each joint."""
    rest = round(HOLDING * rate)
    steps = np.diff(driven.torque[-rest:], axis=0)
    return {"velocity": np.mean(driven.velocity_error[-rest:] ** 2, axis=0), "steps": np.mean(steps**2, axis=0)}


def run_case(case: Case, seeds: range, duration: float) -> dict[str, Any]:
    """Return the figures of both controllers, what is allowed, and what is missed, joint by joint."""
    machine, setup = make_machine(case.machine, case.friction), Setup(case.rate, cascade=True, gravity_given=False)
    found: dict[str, list[Squares]] = {name: [] for name in CONTROLLERS}
    for seed in seeds:
        plan = then_rest(moves(machine.axes, seed, duration, 1.0 / case.rate), SETTLING + HOLDING, 1.0 / case.rate)
        for name, each in found.items():
            driven = drive(machine, MAKERS[name](machine, setup), plan, setup, seed)
            each.append(squares(driven, case.rate))
    joints = [judged(axis.name, place, found, case.rate) for place, axis in enumerate(machine.axes)]
    return {"case": case.name, "joints": joints}


def judged(joint: str, place: int, found: dict[str, list[Squares]], rate: int) -> dict[str, Any]:
    """Return the root mean squares of a joint over the seeds, what is allowed, and what is missed."""
    figures = {
        name: {key: float(np.sqrt(np.mean([one[key][place] for one in each]))) for key in UNITS}
        for name, each in found.items()
    }
    limits = allowed(figures["pi"], rate)
    missed = [key for key, limit in limits.items() if figures["adaptive"][key] > limit]
    return {"joint": joint, **figures, "allowed": limits, "missed": missed}


def table_of(rows: list[dict[str, Any]]) -> Table:
    """Return the table, a line for each joint; what is more than is allowed is bold and red."""
    title = f"at rest for {HOLDING:g} s: rms velocity (mrad/s) and torque steps (N m)"
    table = Table(title=title, box=SIMPLE, title_style="bold")
    table.add_column("case")
    table.add_column("joint")
    for heading in ("velocity, pi", "adaptive", "allowed", "steps, pi", "adaptive", "allowed", "missed"):
        table.add_column(heading, justify="right")
    for row in rows:
        for joint in row["joints"]:
            cells = []
            for key, unit in UNITS.items():
                values = [f"{unit * joint[name][key]:.3g}" for name in ("pi", "adaptive", "allowed")]
                if key in joint["missed"]:
                    values[1] = f"[bold red]{values[1]}[/]"
                cells += values
            table.add_row(row["case"], joint["joint"], *cells, ", ".join(joint["missed"]))
    return table


def main(
    only: Only = "",
    seeds: Seeds = 5,
    first: First = 1,
    duration: Annotated[float, typer.Option(min=12.0, help="Length of the moves before, s.")] = 30.0,
    workers: Workers = CORES,
    json: Annotated[Path | None, typer.Option(help="Write all figures there.")] = None,
) -> None:
    """Let machines in MuJoCo come to rest, and print how calm they hold still."""
    numbers = range(first, first + seeds)
    rows = run_in_turn(run_case, chosen_cases(cases(), only), numbers, duration, workers)
    console = wide_console()
    console.print(table_of(rows))
    calm = sum(not joint["missed"] for row in rows for joint in row["joints"])
    console.print(f"{calm} of {sum(len(row['joints']) for row in rows)} joints miss nothing", highlight=False)
    if json is not None:
        write_json(json, {"seeds": list(numbers), "duration": duration, "cases": rows})


if __name__ == "__main__":
    typer.run(main)
