"""Every controller at its own best bandwidth: ``python -m benchmarks.own_bandwidth [--only NAME] [--controller NAME]``.

On a common PI loop a good compensator is held to the bandwidth that suits the others, and a weak one is helped by a
loop that is slow. Here each controller takes the bandwidth at which its settled error is least, up to the fastest loop
that a maximum sensitivity of 1.7 allows. The bandwidth is chosen on seeds from 101 on, one for all of them; the errors
that are printed are those of seeds from 1 on. ``adaptive-ff tune`` does the same for any scenario. The spring and the
noise are part of the scenario: what suits them is found, not assumed. A best bandwidth at either end of the range is
marked, because the true optimum may be beyond it.
"""

import os
from concurrent.futures import Executor, ProcessPoolExecutor
from pathlib import Path
from typing import Annotated, Any, NamedTuple

import numpy as np
import typer
from rich.box import SIMPLE
from rich.console import Console
from rich.progress import track
from rich.table import Table

from adaptive_ff import load_scenario
from adaptive_ff.comparison import own_bandwidth
from adaptive_ff.comparison.comparison import BASELINE
from adaptive_ff.comparison.matrix.cells import SCENARIOS, scenario_names
from adaptive_ff.comparison.own_bandwidth import FIRST_TUNING_SEED, tried_bandwidths, with_bandwidth
from adaptive_ff.comparison.reference_lines import NOISE_FLOOR, noise_floor
from adaptive_ff.comparison.registry import CONTROLLERS
from adaptive_ff.files import write_json
from benchmarks.wide import wide_console

DEFAULT_SCENARIOS = ("paper_100hz", "noisy_1khz", "encoder", "delay", "elastic")
DEFAULT_CONTROLLERS = (BASELINE, "disturbance_observer", "observed_nominal", "oracle", "adaptive")


class Trial(NamedTuple):
    """One run.

    Attributes
    ----------
    scenario : str
        Name of the scenario.
    controller : str
        Name of the controller.
    bandwidth : float
        Bandwidth of the PI loop, Hz; not a number for that of the scenario.
    seed : int
        Seed.
    """

    scenario: str
    controller: str
    bandwidth: float
    seed: int


def settled_error(trial: Trial) -> float:
    """Return the settled error (rad/s) of a trial, infinite where the loop fails."""
    scenario = load_scenario(SCENARIOS / f"{trial.scenario}.toml").modified(seed=trial.seed)
    if np.isfinite(trial.bandwidth):
        scenario = with_bandwidth(scenario, trial.bandwidth)
    if trial.controller == NOISE_FLOOR:
        try:
            return noise_floor(scenario).metrics.rms_error_settled
        except (ArithmeticError, ValueError):
            return float("inf")
    return own_bandwidth.settled_error(scenario, CONTROLLERS[trial.controller])


def medians(trials: list[Trial], pool: Executor) -> dict[tuple[str, str, float], float]:
    """Return the median error over seeds by scenario, controller and bandwidth."""
    errors: dict[tuple[str, str, float], list[float]] = {}
    errors_found = pool.map(settled_error, trials)
    done = track(errors_found, "runs", total=len(trials), transient=True, console=Console(stderr=True))
    for trial, error in zip(trials, done, strict=True):
        errors.setdefault((trial.scenario, trial.controller, trial.bandwidth), []).append(error)
    return {key: float(np.median(values)) for key, values in errors.items()}


def choose(scenario: str, controllers: list[str], seeds: int, pool: Executor) -> dict[str, tuple[float, bool]]:
    """Return the bandwidth (Hz) that suits each controller on a scenario, and whether it is at an end of the range."""
    tried = tried_bandwidths(load_scenario(SCENARIOS / f"{scenario}.toml"))
    seeds_of = range(FIRST_TUNING_SEED, FIRST_TUNING_SEED + seeds)
    found = medians(
        [Trial(scenario, name, value, seed) for name in controllers for value in tried for seed in seeds_of], pool
    )
    best = {name: min(tried, key=lambda value, name=name: found[scenario, name, value]) for name in controllers}
    return {name: (value, value in (tried[0], tried[-1])) for name, value in best.items()}


def rows_of(scenario: str, controllers: list[str], seeds: int, tuning: int, pool: Executor) -> list[dict[str, Any]]:
    """Return a row for each controller: errors in the common loop and in its own, and the bandwidths."""
    chosen = choose(scenario, controllers, tuning, pool)
    reported = range(1, seeds + 1)
    trials = [
        Trial(scenario, name, value, seed)
        for name in controllers
        for value in (chosen[name][0], float("nan"))
        for seed in reported
    ]
    errors: dict[tuple[str, bool], list[float]] = {}
    for trial, error in zip(trials, pool.map(settled_error, trials), strict=True):
        errors.setdefault((trial.controller, bool(np.isfinite(trial.bandwidth))), []).append(error)
    common = load_scenario(SCENARIOS / f"{scenario}.toml").feedback.bandwidth
    return [
        {
            "scenario": scenario,
            "controller": name,
            "common_bandwidth": common,
            "common_error": float(np.median(errors[name, False])),
            "own_bandwidth": chosen[name][0],
            "at_an_end": chosen[name][1],
            "own_error": float(np.median(errors[name, True])),
        }
        for name in controllers
    ]


def table_of(rows: list[dict[str, Any]]) -> Table:
    """Return the rows of all scenarios as a table; gains are over PI in the same column."""
    table = Table(title="Settled rms error, mrad/s: common loop and own best bandwidth", box=SIMPLE, title_style="bold")
    for heading in ("scenario", "controller", "common, Hz", "error", "gain", "own, Hz", "error", "gain"):
        table.add_column(heading, justify="left" if heading in ("scenario", "controller") else "right")
    for row in rows:
        base = next((r for r in rows if r["scenario"] == row["scenario"] and r["controller"] == BASELINE), None)
        gains = ["-" if base is None else f"{base[key] / row[key]:.2f}" for key in ("common_error", "own_error")]
        table.add_row(
            row["scenario"],
            row["controller"],
            "gains" if row["common_bandwidth"] is None else f"{row['common_bandwidth']:g}",
            f"{1e3 * row['common_error']:.3g}",
            gains[0],
            f"{row['own_bandwidth']:.1f}" + (" (end)" if row["at_an_end"] else ""),
            f"{1e3 * row['own_error']:.3g}",
            gains[1],
            style="bold" if row["controller"] == "adaptive" else None,
        )
    return table


def main(
    only: Annotated[list[str] | None, typer.Option(help="Scenario; may be repeated.")] = None,
    controller: Annotated[list[str] | None, typer.Option(help="Controller; may be repeated.")] = None,
    seeds: Annotated[int, typer.Option(min=1, help="Number of reported seeds, from 1 on.")] = 10,
    tuning_seeds: Annotated[int, typer.Option(min=1, help="Number of seeds to choose on, from 101 on.")] = 3,
    workers: Annotated[int, typer.Option(min=1, help="Processes.")] = os.cpu_count() or 1,
    json: Annotated[Path | None, typer.Option(help="Write the rows there.")] = None,
) -> None:
    """Print what each controller reaches in the common loop and at its own best bandwidth."""
    for option, given, known in (
        ("--only", only or [], scenario_names()),
        ("--controller", controller or [], [*CONTROLLERS, NOISE_FLOOR]),
    ):
        for name in given:
            if name not in known:
                raise typer.BadParameter(f"{name!r} is not known; there are {', '.join(known)}", param_hint=option)
    names = list(dict.fromkeys([BASELINE, *(controller or DEFAULT_CONTROLLERS)]))
    scenarios = only or list(DEFAULT_SCENARIOS)
    settled_error(Trial(scenarios[0], names[-1], float("nan"), FIRST_TUNING_SEED))  # compiled here, for all workers
    with ProcessPoolExecutor(workers) as pool:
        rows = [row for scenario in scenarios for row in rows_of(scenario, names, seeds, tuning_seeds, pool)]
    wide_console().print(table_of(rows))
    if json is not None:
        write_json(json, {"rows": rows})


if __name__ == "__main__":
    typer.run(main)
