"""Friction over position and load, learnt online: ``python -m benchmarks.position_map [--first-seed 101]``.

Settled error of PI over that of ``adaptive``, median over references (least in brackets), 100 Hz, 60 s: without a map,
with the period known, with hats over the planned range of motion, and with friction over the known torque. Rows where
friction does not depend on position or load show what a map costs there. ``--seconds 180`` tells what a map is worth
in longer runs, in which the range grows as well. Reported are seeds from 1 on.
"""

import math
from typing import Annotated, Any, NamedTuple

import numpy as np
import typer
from rich.box import SIMPLE
from rich.table import Table

from adaptive_ff import Scenario, load_scenario
from adaptive_ff.comparison.matrix.cells import SCENARIOS
from adaptive_ff.comparison.run import simulate
from adaptive_ff.simulation.experiment import lay_course
from benchmarks.wide import wide_console


class Row(NamedTuple):
    """One joint, and the map that is tried on it.

    Attributes
    ----------
    key, name : str
        Short name, and what varies.
    scenario : Scenario
        What is run.
    periods : tuple of float
        Known periods, rad.
    hats, spacing : int, float
        Number of hats over the planned range, or the distance between them, rad, where the number is zero.
    load : bool
        Whether friction may depend on the known torque.
    asked : float
        Least settled error of PI over the controller's that is asked for; zero where none is.
    """

    key: str
    name: str
    scenario: Scenario
    periods: tuple[float, ...] = ()
    hats: int = 0
    spacing: float = 0.0
    load: bool = False
    asked: float = 0.0


def rows(seconds: float = 60.0) -> list[Row]:
    """Return the rows of the table, for runs of a duration (s); friction that drops has its own."""
    plain = load_scenario().modified(duration=seconds)

    def over(period: float) -> Scenario:
        return plain.modified(variation={"position_amplitude": 0.3, "position_period": period})

    short, long = over(0.3), over(2.0)
    gravity, drop = plain.modified(joint={"gravity": 40.0}), load_scenario(SCENARIOS / "friction_drops.toml")
    loaded = plain.modified(joint={"gravity": 100.0}, adaptation={"identify": "gravity"})
    shared = loaded.modified(variation={"load_share": 0.005})
    return [
        Row("map_short_period", "30 % over 0.3 rad, period known", short, (0.3,), asked=6.5),
        Row("map_short_hats", "30 % over 0.3 rad, hats of 0.06 rad", short, spacing=0.06, asked=4.4),
        Row("map_long_period", "30 % over 2 rad, period known", long, (2.0,)),
        Row("map_long_hats_13", "30 % over 2 rad, 13 hats", long, hats=13),
        Row("map_long_hats_25", "30 % over 2 rad, 25 hats", long, hats=25, asked=6.3),
        Row("map_no_need_period", "no variation, period of 0.3 rad", plain, (0.3,)),
        Row("map_no_need_hats_25", "no variation, 25 hats", plain, hats=25),
        Row("map_no_need_hats", "no variation, hats of 0.06 rad", plain, spacing=0.06),
        Row("map_gravity_40_hats_25", "gravity 40 sin q not modelled, 25 hats", gravity, hats=25),
        Row("map_friction_drops_hats_25", "friction drops by 40 %, 25 hats", drop, hats=25),
        Row("map_load", "0.5 % per N m of gravity 100 sin q", shared, load=True),
        Row("map_no_need_load", "gravity 100 sin q, no share", loaded, load=True),
    ]


def told(row: Row, seed: int) -> Scenario:
    """Return the scenario of a row and a seed in which ``adaptive`` has the map; its range is that of the plan."""
    scenario = row.scenario.modified(seed=seed)
    assumed: dict[str, Any] = {"position_periods": list(row.periods), "load_friction": row.load}
    if row.hats or row.spacing:
        position = np.cumsum(scenario.reference_velocity()) * scenario.joint.solver_period
        lowest, highest = float(np.min(position)), float(np.max(position))
        hats = row.hats or math.ceil((highest - lowest) / row.spacing) + 1
        assumed |= {"position_hats": hats, "position_range": [lowest, highest]}
    return scenario.modified(adaptation=assumed)


def errors(row: Row, seed: int) -> tuple[float, float, float]:
    """Return the settled errors of PI, of ``adaptive`` without a map and of that with one, rad/s."""
    plain, mapped = row.scenario.modified(seed=seed), told(row, seed)
    course = lay_course(plain)
    runs = ((plain, "pi"), (plain, "adaptive"), (mapped, "adaptive"))
    found = [simulate(scenario, name, course=course, uncertain=False) for scenario, name in runs]
    base, without, own = (run.metrics.rms_error_settled for run in found)
    return base, without, own


def main(
    references: Annotated[int, typer.Option(min=1, help="Number of references.")] = 100,
    first_seed: Annotated[int, typer.Option(min=0, help="Seed of the first reference.")] = 1,
    seconds: Annotated[float, typer.Option(min=40.0, help="Duration of a run, s.")] = 60.0,
) -> None:
    """Print what a map of friction over position and load gains, and what it costs."""
    title = f"pi / adaptive, settled, {references} references of {seconds:g} s from seed {first_seed}"
    table = Table(title=title, box=SIMPLE)
    for heading in ("friction", "without a map", "with (least)", "asked", "error with / without (worst)"):
        table.add_column(heading, justify="left" if heading == "friction" else "right", no_wrap=True)
    for row in rows(seconds):
        found = np.array([errors(row, seed) for seed in range(first_seed, first_seed + references)])
        without, own, cost = found[:, 0] / found[:, 1], found[:, 0] / found[:, 2], found[:, 2] / found[:, 1]
        ratio = float(np.median(own))
        table.add_row(
            row.name,
            f"{np.median(without):.2f}",
            f"{ratio:.2f} ({np.min(own):.2f})",
            f"{row.asked:g}" if row.asked else "",
            f"{np.median(cost):.3f} ({np.max(cost):.3f})",
            style="red" if ratio < row.asked else None,
        )
    wide_console().print(table)


if __name__ == "__main__":
    typer.run(main)
