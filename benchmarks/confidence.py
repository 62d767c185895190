"""How honest the uncertainties of the adaptive controller are: ``python -m benchmarks.confidence``.

On the built-in joint the truth is known. For each parameter: root of the mean square, over seeds, of its error in units
of the standard deviation that the controller states. One would be perfect, less is on the safe side. Last, the share of
all parameters within twice the uncertainty; normal errors would give 95 %.
"""

from typing import Annotated, NamedTuple

import numpy as np
import typer
from numpy.typing import NDArray
from rich.box import SIMPLE
from rich.table import Table

from adaptive_ff import load_scenario, simulate
from adaptive_ff.comparison.registry import make_controller
from adaptive_ff.model.friction import ESTIMATED
from adaptive_ff.scenario.truth import true_model
from benchmarks.wide import wide_console

WITHIN = 2.0


class Case(NamedTuple):
    """A case: sampling period (s), noise of the velocity (rad/s), and duration (s)."""

    period: float
    noise: float
    duration: float


CASES = (
    Case(0.01, 0.002, 5.0),
    Case(0.01, 0.002, 10.0),
    Case(0.01, 0.002, 20.0),
    Case(0.01, 0.002, 60.0),
    Case(0.01, 0.005, 60.0),
    Case(0.01, 0.0, 60.0),
    Case(0.001, 0.002, 10.0),
    Case(0.001, 0.002, 20.0),
    Case(0.001, 0.002, 60.0),
)


def errors_over_uncertainties(case: Case, seed: int) -> NDArray[np.float64]:
    """Return the error of each parameter at the end of a run, in units of its uncertainty."""
    scenario = load_scenario().modified(
        seed=seed,
        duration=case.duration,
        sampling={"period": case.period},
        sensor={"velocity_noise": case.noise},
    )
    controller = make_controller(scenario, "adaptive")
    simulate(scenario, controller)
    true, uncertainties = true_model(scenario), controller.uncertainties
    errors = [(controller.estimates[name] - getattr(true, name)) / uncertainties[name] for name in ESTIMATED]
    return np.array(errors)


def main(seeds: Annotated[int, typer.Option(min=1, help="Number of seeds.")] = 20) -> None:
    """Print errors in units of the uncertainty."""
    table = Table(title=f"Error over uncertainty, rms of {seeds} seeds", box=SIMPLE)
    for heading in ("period, s", "noise, mrad/s", "after, s", *ESTIMATED, f"within {WITHIN:g}"):
        table.add_column(heading, justify="right")
    for case in CASES:
        found = np.array([errors_over_uncertainties(case, seed) for seed in range(1, seeds + 1)])
        cells = (f"{value:.2g}" for value in np.sqrt(np.mean(found**2, axis=0)))
        settings = (f"{case.period:g}", f"{1e3 * case.noise:g}", f"{case.duration:g}")
        table.add_row(*settings, *cells, f"{100.0 * np.mean(np.abs(found) < WITHIN):.0f} %")
    wide_console().print(table)


if __name__ == "__main__":
    typer.run(main)
