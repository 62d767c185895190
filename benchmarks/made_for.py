"""Each rival on the scenario that it was made for: ``python -m benchmarks.made_for [--only NAME] [--seeds N]``.

Printed are the settled errors of ``pi``, of the rival and of ``adaptive``, medians of the seeds from 1 on; behind a
position loop those of the position. ``pi / own`` is the median of the ratios of each seed, and in the least favourable
one; ``adaptive / own`` above one: the rival is the better one there. Scenarios are those of ``adaptive-ff matrix``.
"""

from concurrent.futures import ProcessPoolExecutor
from typing import Annotated

import numpy as np
import typer
from rich.box import SIMPLE
from rich.table import Table

from adaptive_ff import simulate
from adaptive_ff.comparison.matrix.cells import cell_scenario
from adaptive_ff.simulation.experiment import lay_course
from benchmarks.wide import wide_console

MADE_FOR = {
    "lugre_observer": "lugre",
    "lugre_gradient": "lugre",
    "maxwell_adaptive": "maxwell",
    "friction_observer": "elasto_plastic",
    "lee_tomizuka": "positioning",
    "canudas": "asymmetric",
    "canudas_measured": "asymmetric",
    "feedback_error": "paper_100hz",
    "radial_basis": "high_stiction_vs_quarter",
    "repetitive": "fast_sine",
    "super_twisting": "load_step_80",
    "disturbance_observer": "load_step_80",
    "extended_state": "load_step_80",
    "kalman_disturbance": "load_step_80",
    "observed_nominal": "friction_drops",
}
"""Scenario of the matrix by rival: the joint, motion or disturbance that its source has in mind."""

BESIDE = ("pi", "adaptive")


def settled_errors(name: str, seed: int) -> list[float]:
    """Return the settled errors of ``pi``, ``adaptive`` and a rival: rad/s, or rad behind a position loop."""
    scenario = cell_scenario(MADE_FOR[name], seed, False)
    course = lay_course(scenario)
    found = []
    for each in (*BESIDE, name):
        run = simulate(scenario, each, course=course, uncertain=False)
        position = run.position_metrics
        found.append(run.metrics.rms_error_settled if position is None else position.rms_position_error_settled)
    return found


def errors_of(name: str, seeds: int, pool: ProcessPoolExecutor) -> np.ndarray:
    """Return the settled errors, shape (seeds, 3), in the order of ``settled_errors``."""
    settled_errors(name, 1)  # here, so that workers find the controllers compiled
    return np.array(list(pool.map(settled_errors, [name] * seeds, range(1, seeds + 1))))


def add_row(table: Table, name: str, errors: np.ndarray) -> None:
    """Add the row of a rival; one that is not as good as ``pi`` is red."""
    pi, adaptive, own = errors.T
    scenario = cell_scenario(MADE_FOR[name], 1, False)
    scale, unit = (1e3, "mrad/s") if scenario.position is None else (1e6, "urad")
    gain = pi / own
    table.add_row(
        name,
        MADE_FOR[name],
        unit,
        *(f"{scale * np.median(values):.3g}" for values in (pi, own, adaptive)),
        f"{np.median(gain):.2f} ({np.min(gain):.2f})",
        f"{np.median(adaptive / own):.2f}",
        style="red" if np.median(gain) < 1.0 else None,
    )


def main(
    only: Annotated[list[str] | None, typer.Option(help="Rival to run; may be given several times.")] = None,
    seeds: Annotated[int, typer.Option(min=1, help="Number of seeds, from 1 on.")] = 20,
    processes: Annotated[int, typer.Option(min=1, help="Number of processes.")] = 2,
) -> None:
    """Print how each rival does on what it was made for."""
    names = only or list(MADE_FOR)
    for name in names:
        if name not in MADE_FOR:
            raise typer.BadParameter(f"{name!r} is not known; there are {', '.join(MADE_FOR)}", param_hint="--only")
    table = Table(title=f"Settled rms error, {seeds} seeds", box=SIMPLE)
    for heading in ("rival", "scenario", "unit", "pi", "own", "adaptive", "pi / own (least)", "adaptive / own"):
        table.add_column(heading, justify="left" if heading in ("rival", "scenario", "unit") else "right")
    with ProcessPoolExecutor(processes) as pool:
        for name in names:
            add_row(table, name, errors_of(name, seeds, pool))
    wide_console().print(table)


if __name__ == "__main__":
    typer.run(main)
