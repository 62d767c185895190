"""The main job over many seeds: ``python -m benchmarks.main_job [--seeds N] [--memory S] [--json FILE]``.

The built-in scenario at 100 Hz and at 1 kHz; every seed has another multisine and other noise. Seeds start at 1; the
settings of the controllers were chosen on seeds from 101 on.
"""

from pathlib import Path
from typing import Annotated, Any

import numpy as np
import typer
from rich.box import SIMPLE
from rich.progress import track
from rich.table import Table

from adaptive_ff import Scenario, compare, load_scenario
from adaptive_ff.files import write_json
from benchmarks.wide import wide_console

RATES = {"100 Hz": 0.01, "1 kHz": 0.001}
TARGETS = {
    "100 Hz": {"pi / adaptive": 3.0, "adaptive / oracle": 1.5},
    "1 kHz": {"pi / adaptive": 10.0},
}


def run_seeds(scenario: Scenario, seeds: int, label: str) -> tuple[dict[str, np.ndarray], dict[str, np.ndarray]]:
    """Return the rms errors (rad/s) of each controller, settled and in the first 5 s, over seeds from 1 on."""
    settled: dict[str, list[float]] = {name: [] for name in scenario.controllers}
    start: dict[str, list[float]] = {name: [] for name in scenario.controllers}
    for seed in track(range(1, seeds + 1), description=label, transient=True):
        for name, run in compare(scenario.modified(seed=seed)).runs.items():
            settled[name].append(run.metrics.rms_error_settled)
            start[name].append(run.metrics.rms_error_start)
    return (
        {name: np.array(values) for name, values in settled.items()},
        {name: np.array(values) for name, values in start.items()},
    )


def ratios(settled: dict[str, np.ndarray], start: dict[str, np.ndarray]) -> dict[str, np.ndarray]:
    """Return the ratios of interest, a value a seed."""
    return {
        "pi / adaptive": settled["pi"] / settled["adaptive"],
        "adaptive / oracle": settled["adaptive"] / settled["oracle"],
        "adaptive / pi in the first 5 s": start["adaptive"] / start["pi"],
    }


def errors_table(errors: dict[str, np.ndarray], label: str, seeds: int) -> Table:
    """Return the settled errors of all controllers."""
    table = Table(title=f"{label}: settled rms error, mrad/s, over {seeds} seeds", box=SIMPLE)
    for heading in ("controller", "median", "best", "worst", "pi / own"):
        table.add_column(heading, justify="left" if heading == "controller" else "right")
    for name, values in errors.items():
        shown = [f"{1e3 * value:.3g}" for value in (np.median(values), values.min(), values.max())]
        table.add_row(name, *shown, f"{np.median(errors['pi'] / values):.2f}")
    return table


def ratios_table(values_by_name: dict[str, np.ndarray], label: str) -> Table:
    """Return the ratios beside their targets."""
    table = Table(title=f"{label}: ratios", box=SIMPLE)
    for heading in ("ratio", "median", "worst", "target", "met by the worst seed"):
        table.add_column(heading, justify="left" if heading == "ratio" else "right")
    for name, values in values_by_name.items():
        larger_is_better = name.startswith("pi")
        worst = values.min() if larger_is_better else values.max()
        target = TARGETS[label].get(name)
        met = "" if target is None else "yes" if (worst >= target if larger_is_better else worst <= target) else "no"
        sign = ">=" if larger_is_better else "<="
        goal = "" if target is None else f"{sign} {target:g}"
        table.add_row(name, f"{np.median(values):.2f}", f"{worst:.2f}", goal, met)
    return table


def main(
    seeds: Annotated[int, typer.Option(min=1, help="Number of seeds.")] = 20,
    memory: Annotated[
        float | None, typer.Option(min=0.1, help="Memory of both identifying controllers, s; by default their own.")
    ] = None,
    json: Annotated[Path | None, typer.Option(help="Write all errors there, rad/s.")] = None,
) -> None:
    """Print the errors of all controllers of the main job and how they stand to their targets."""
    console = wide_console()
    result: dict[str, Any] = {}
    for label, period in RATES.items():
        scenario = load_scenario().modified(sampling={"period": period})
        if memory is not None:
            scenario = scenario.modified(adaptation={"memory": memory})
        settled, start = run_seeds(scenario, seeds, label)
        console.print(errors_table(settled, label, seeds))
        console.print(ratios_table(ratios(settled, start), label))
        result[label] = {
            "rms_error_settled": {name: values.tolist() for name, values in settled.items()},
            "rms_error_start": {name: values.tolist() for name, values in start.items()},
        }
    if json is not None:
        write_json(json, result)


if __name__ == "__main__":
    typer.run(main)
