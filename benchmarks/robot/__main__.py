"""PI, fixed and adaptive feedforward on machines in MuJoCo: ``python -m benchmarks.robot``.

Hinges and arms with MuJoCo's own Coulomb or LuGre friction, along multisines (velocity loop, noise of 2 mrad/s) or from
point to point behind a position loop (encoder of 6 urad); gravity given to all controllers, or to none. ``fixed`` knows
the true friction and the inertia in the middle of the motion, ``adaptive`` knows that inertia and learns the rest.

Errors are roots of mean squares over the seeds for each joint; then the middle and the worst joint are printed: PI's
error over that of ``adaptive`` (above 1: better than PI), settled (second half) and in the first 5 s, and that of
``adaptive`` over that of ``fixed``; and the errors of the middle joint themselves.
"""

import itertools
from functools import partial
from pathlib import Path
from typing import Annotated, Any, NamedTuple

import numpy as np
import typer
from numpy.typing import NDArray
from rich.box import SIMPLE
from rich.table import Table

from adaptive_ff.files import write_json
from adaptive_ff.report.drawing import write_figures
from benchmarks.robot.circle import picture
from benchmarks.robot.in_turn import CORES, First, Only, Seeds, Workers, chosen_cases, run_in_turn
from benchmarks.robot.loops import MAKERS, Driven, Setup, drive
from benchmarks.robot.machines import CREEP, KINDS, PHYSICS, make_machine
from benchmarks.robot.plans import moves, multisines
from benchmarks.wide import wide_console

RATES = (100, 500, 1000)
FRICTIONS = ("coulomb", "LuGre")
START = 5.0  # s
LEAST_MEDIAN, LEAST, LARGEST_OVER_FIXED = 3.0, 1.0, 1.3
"""Asked where gravity is not given: of the middle joint and of each; and where it is, over fixed feedforward."""

QUANTITIES = ("velocity", "start", "position", "position_start")
HEADINGS = ("velocity, settled", "first 5 s", "position, settled", "first 5 s")


class Case(NamedTuple):
    """A machine and how it is driven."""

    machine: str
    friction: str
    setup: Setup

    @property
    def name(self) -> str:
        """Its name in the table."""
        loop = "moves, position loop" if self.setup.cascade else "multisine, velocity loop"
        gravity = "" if self.machine == "hinge" else f", gravity {'given' if self.setup.gravity_given else 'learnt'}"
        return f"{self.machine}, {self.friction}, {self.setup.rate} Hz, {loop}{gravity}"


def cases() -> list[Case]:
    """Return all of them."""
    found = []
    for machine, friction, rate, cascade in itertools.product(KINDS, FRICTIONS, RATES, (False, True)):
        for given in (False,) if machine == "hinge" else (False, True):
            found.append(Case(machine, friction, Setup(rate, cascade, given)))
    return found


def squares(driven: Driven, rate: int) -> NDArray[np.float64]:
    """Return mean squares of a run, shape (quantities, joints)."""
    half, start = driven.torque.shape[0] // 2, round(START * rate)
    parts = [part for error in (driven.velocity_error, driven.position_error) for part in (error[half:], error[:start])]
    return np.array([np.mean(part**2, axis=0) for part in parts])


def run_case(case: Case, seeds: range, duration: float, creep: float = CREEP) -> dict[str, Any]:
    """Return the errors of all controllers, and the figures that are printed."""
    machine, plans = make_machine(case.machine, case.friction, creep), moves if case.setup.cascade else multisines
    total = {name: np.zeros((len(QUANTITIES), len(machine.axes))) for name in MAKERS}
    for seed in seeds:
        plan = plans(machine.axes, seed, duration, 1.0 / case.setup.rate)
        for name, make in MAKERS.items():
            driven = drive(machine, make(machine, case.setup), plan, case.setup, seed)
            total[name] += squares(driven, case.setup.rate) / len(seeds)
    errors = {name: np.sqrt(value) for name, value in total.items()}
    gain, over_fixed = errors["pi"] / errors["adaptive"], errors["adaptive"] / errors["fixed"]
    row: dict[str, Any] = {
        "case": case.name,
        "cascade": case.setup.cascade,
        "joints": [axis.name for axis in machine.axes],
    }
    for place, quantity in enumerate(QUANTITIES):
        row |= {f"{quantity}_median": float(np.median(gain[place])), f"{quantity}_least": float(np.min(gain[place]))}
        row[f"{quantity}_over_fixed"] = float(np.max(over_fixed[place]))
    row["missed"] = missed(case, row)
    row["errors"] = {name: value.tolist() for name, value in errors.items()}
    return row


def judged_in(cascade: bool) -> tuple[str, ...]:
    """Return which quantities count: without a position loop nothing holds the position."""
    return QUANTITIES if cascade else QUANTITIES[:2]


def missed(case: Case, row: dict[str, Any]) -> list[str]:
    """Return which of the figures asked for a case does not reach."""
    judged = judged_in(case.setup.cascade)
    found = [quantity for quantity in judged if row[f"{quantity}_least"] < LEAST]
    outer = "position" if case.setup.cascade else "velocity"
    if case.machine != "hinge" and not case.setup.gravity_given and row[f"{outer}_median"] < LEAST_MEDIAN:
        found.append(f"median {outer}")
    if case.setup.gravity_given and row[f"{outer}_over_fixed"] > LARGEST_OVER_FIXED:
        found.append("over fixed")
    return found


def table_of(rows: list[dict[str, Any]]) -> Table:
    """Return the table of what is gained."""
    table = Table(title="PI's error over that of adaptive: middle joint (worst joint)", box=SIMPLE, title_style="bold")
    table.add_column("case")
    for heading in (*HEADINGS, "adaptive / fixed, velocity", "position", "missed"):
        table.add_column(heading, justify="right")
    for row in rows:
        judged = judged_in(row["cascade"])
        gains = {name: f"{row[f'{name}_median']:.2f} ({row[f'{name}_least']:.2f})" for name in judged}
        cells = [gains.get(name, "-") for name in QUANTITIES]
        cells += [f"{row[f'{name}_over_fixed']:.2f}" if name in judged else "-" for name in ("velocity", "position")]
        table.add_row(row["case"], *cells, ", ".join(row["missed"]))
    return table


def errors_table(rows: list[dict[str, Any]]) -> Table:
    """Return the table of the errors themselves."""
    title = "rms errors of pi / fixed / adaptive, middle joint: mrad/s, mrad"
    table = Table(title=title, box=SIMPLE, title_style="bold")
    table.add_column("case")
    for heading in HEADINGS:
        table.add_column(heading, justify="right")
    for row in rows:
        judged, cells = judged_in(row["cascade"]), []
        for place, name in enumerate(QUANTITIES):
            middle = [1e3 * float(np.median(row["errors"][own][place])) for own in ("pi", "fixed", "adaptive")]
            cells.append(" / ".join(f"{error:.3g}" for error in middle) if name in judged else "-")
        table.add_row(row["case"], *cells)
    return table


def main(
    only: Only = "",
    seeds: Seeds = 5,
    first: First = 1,
    duration: Annotated[float, typer.Option(min=12.0, help="Length of a run, s.")] = 60.0,
    creep: Annotated[
        float,
        typer.Option(min=2.0 * PHYSICS, help="Time constant of MuJoCo's Coulomb friction at rest, s."),
    ] = CREEP,
    workers: Workers = CORES,
    json: Annotated[Path | None, typer.Option(help="Write all errors there.")] = None,
    out: Annotated[Path | None, typer.Option(help="Folder for the picture of the arm's tip.")] = None,
) -> None:
    """Drive machines in MuJoCo, print how much is gained, and draw the tip of an arm on a circle."""
    numbers = range(first, first + seeds)
    rows = run_in_turn(partial(run_case, creep=creep), chosen_cases(cases(), only), numbers, duration, workers)
    console = wide_console()
    console.print(table_of(rows))
    console.print(errors_table(rows))
    console.print(f"{sum(not row['missed'] for row in rows)} of {len(rows)} cases miss nothing", highlight=False)
    if json is not None:
        write_json(json, {"seeds": list(numbers), "duration": duration, "creep": creep, "cases": rows})
    if out is not None:
        write_figures({"arm_on_a_circle": picture(first)}, out, ["png"])


if __name__ == "__main__":
    typer.run(main)
