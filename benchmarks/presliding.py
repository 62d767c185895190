"""Friction with presliding, learnt online: ``python -m benchmarks.presliding [--first-seed 1 --references 30]``.

Joints whose bristles or elements bend before they slide, over ways between 0.75 and 75 mrad: settled error of PI over
that of ``adaptive``, each the root of the mean square over five draws of the noise
(:mod:`adaptive_ff.comparison.windows`), beside what is asked of it and beside the disturbance observer, and the error
of the first 5 s over PI's.
"""

import os
from concurrent.futures import ProcessPoolExecutor
from typing import Annotated, NamedTuple

import numpy as np
import typer
from rich.box import SIMPLE
from rich.table import Table

from adaptive_ff import Scenario, load_scenario
from adaptive_ff.comparison.matrix.cells import SCENARIOS
from adaptive_ff.comparison.windows import Judgement, judge
from benchmarks.wide import wide_console

OWN, RIVAL = "adaptive", "disturbance_observer"

SLIPS = np.array([0.3, 1.0, 2.0, 4.0])
"""Ways over which the four elements slip, one to another; their mean is what a row names."""


class Row(NamedTuple):
    """A joint and what is asked there.

    Attributes
    ----------
    name : str
        What it is.
    scenario : Scenario
        The scenario, for one seed.
    asked : float
        Least settled error of PI over the controller's.
    """

    name: str
    scenario: Scenario
    asked: float


def bristles(stiffness: float, period: float = 0.01) -> Scenario:
    """Return the built-in joint with bristles (N m/rad), sampled with a period (s)."""
    scenario = load_scenario(SCENARIOS / "lugre_1e4.toml")
    return scenario.modified(
        joint=scenario.joint.model_copy(update={"stiffness": stiffness}),
        sampling=scenario.sampling.model_copy(update={"period": period}),
    )


def elements(mean: float) -> Scenario:
    """Return the built-in joint with four Maxwell elements that slip after a way (rad) in the mean."""
    scenario = load_scenario(SCENARIOS / "maxwell.toml")
    displacements = (mean * SLIPS / np.mean(SLIPS)).tolist()
    return scenario.modified(joint=scenario.joint.model_copy(update={"displacements": displacements}))


def rows() -> list[Row]:
    """Return all rows."""
    soft = [(1e3, 2.1), (3e3, 2.9), (1e4, 4.5), (1e5, 5.4)]
    slips = [(75.0, 1.7), (25.0, 2.2), (7.5, 2.5), (0.75, 5.3)]
    return [
        *(Row(f"LuGre, {stiffness:g} N m/rad", bristles(stiffness), asked) for stiffness, asked in soft),
        Row("LuGre, 10000 N m/rad, 1 kHz", bristles(1e4, 0.001), 11.0),
        *(Row(f"four Maxwell elements, {slip:g} mrad", elements(1e-3 * slip), asked) for slip, asked in slips),
    ]


def judged(scenario: Scenario) -> tuple[Judgement, Judgement]:
    """Judge the controller and the disturbance observer on one reference."""
    own = judge(scenario, OWN)
    return own, judge(scenario, RIVAL, base=own.base)


def line_of(row: Row, found: list[tuple[Judgement, Judgement]]) -> tuple[list[str], bool]:
    """Return the cells of a row, and whether all that is asked is met."""
    settled = np.array([own.settled for own, _ in found])
    rival = np.array([other.settled for _, other in found])
    start = np.array([own.start for own, _ in found])
    missed = [
        name
        for name, met in (
            ("settled", np.median(settled) >= row.asked),
            ("observer", np.median(settled) >= np.median(rival)),
            ("start", np.max(start) <= 1.0),
        )
        if not met
    ]
    cells = [
        row.name,
        f"{np.median(settled):.2f} ({np.min(settled):.2f})",
        f"{row.asked:g}",
        f"{np.median(rival):.2f}",
        f"{np.median(start):.2f} ({np.max(start):.2f})",
        ", ".join(missed),
    ]
    return cells, not missed


def main(
    first_seed: Annotated[int, typer.Option(min=0, help="First seed; 101 and more while tuning.")] = 1,
    references: Annotated[int, typer.Option(min=1, help="Number of references.")] = 30,
    workers: Annotated[int, typer.Option(min=1, help="Processes.")] = os.cpu_count() or 1,
) -> None:
    """Print what is gained on joints whose friction bends before it slides."""
    table = Table(title=f"PI over own, {references} references of five draws of the noise", box=SIMPLE)
    for heading in ("joint", "pi / adaptive (least)", "asked", "pi / observer", "first 5 s (worst)", "missed"):
        table.add_column(heading, justify="left" if heading in ("joint", "missed") else "right", no_wrap=True)
    listed = rows()
    judged(listed[0].scenario.modified(duration=6.0))  # here, so that workers find the controllers compiled
    seeds = range(first_seed, first_seed + references)
    with ProcessPoolExecutor(workers) as pool:
        for row in listed:
            found = list(pool.map(judged, [row.scenario.modified(seed=seed) for seed in seeds]))
            cells, met = line_of(row, found)
            table.add_row(*cells, style=None if met else "red")
    wide_console().print(table)


if __name__ == "__main__":
    typer.run(main)
