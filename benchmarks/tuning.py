"""The search for what the rivals' sources leave open: ``python -m benchmarks.tuning [--only NAME] [--seeds N]``.

Every candidate runs on joints that no other benchmark reports, with seeds from 101 on: the built-in joint with other
friction, lag, noise and reference, at 100 Hz and at 1 kHz. Candidates with an observer take at most the bandwidth that
a maximum sensitivity of 2 allows. What is compared is the settled rms error (median of the seeds); the last column, its
ratio to the best candidate of the same controller, geometric mean over the scenarios, decides. The rule found is the
default in ``adaptive_ff/comparison``.
"""

import math
import os
from collections.abc import Callable
from concurrent.futures import Executor, ProcessPoolExecutor
from typing import Annotated

import numpy as np
import typer
from rich.box import SIMPLE
from rich.progress import track
from rich.table import Table

from adaptive_ff import Scenario, load_scenario, parse_scenario, simulate
from adaptive_ff.comparison.observer_bandwidth import balance
from adaptive_ff.comparison.registry import (
    Maker,
    make_disturbance_observer,
    make_extended_state,
    make_kalman_disturbance,
    make_observed_batch,
    make_observed_nominal,
)
from benchmarks.tuning_literature import BY_GRADIENT, MADE_FOR, literature_candidates
from benchmarks.tuning_rivals import candidates
from benchmarks.wide import wide_console

FIRST_SEED = 101

RATES = {"100 Hz": 0.01, "1 kHz": 0.001}

JOINTS = {
    "slow": {
        "joint": {"friction_lag": 0.01, "stribeck_velocity": 0.08},
        "reference": {
            "frequencies": [0.013, 0.06, 0.15, 0.3, 0.6],
            "amplitudes": [1.0, 0.8, 0.6, 0.5, 0.4],
            "peak": 0.2,
        },
    },
    "heavy": {
        "joint": {"coulomb": 90.0, "stiction": 120.0, "viscous": 60.0, "friction_lag": 0.03},
        "sensor": {"velocity_noise": 0.001},
        "reference": {"frequencies": [0.02, 0.09, 0.31, 0.8], "amplitudes": [1.0, 0.9, 0.5, 0.3], "peak": 0.5},
    },
    "light": {
        "joint": {"coulomb": 25.0, "stiction": 35.0, "viscous": 120.0},
        "sensor": {"velocity_noise": 0.004},
        "reference": {"frequencies": [0.017, 0.12, 0.5, 1.3], "amplitudes": [1.0, 1.0, 0.6, 0.3], "peak": 0.4},
    },
}
"""What differs from the built-in joint."""


HARD = {
    "slow, late": {**JOINTS["slow"], "actuator": {"delay": 0.01}, "feedback": {"bandwidth": 5.0}},
    "heavy, late": {**JOINTS["heavy"], "actuator": {"delay": 0.01}, "feedback": {"bandwidth": 5.0}},
    "heavy, short of torque": {**JOINTS["heavy"], "actuator": {"torque_limit": 122.0}},
    "light, soft bristles": {
        **JOINTS["light"],
        "joint": {
            **{"kind": "lugre", "stiffness": 5e3, "inertia": 20.0, "stribeck_velocity": 0.05},
            **{"coulomb": 25.0, "stiction": 35.0, "viscous": 120.0},
        },
    },
}
"""Further scenarios at 100 Hz for those that learn by a gradient: a fast one must not lose its stability there."""


def tuning_scenarios(name: str = "") -> dict[str, Scenario]:
    """Return the scenarios by name, those for a controller where one is named; none of them is reported."""
    common = {
        f"{joint}, {rate}": load_scenario().modified(sampling={"period": period}, **tables)
        for rate, period in RATES.items()
        for joint, tables in JOINTS.items()
    }
    if name not in BY_GRADIENT:
        return common
    return common | {label: load_scenario().modified(**tables) for label, tables in HARD.items()}


Rule = Callable[[Scenario, float], object]


def _by_balance(rule: Rule, shares: list[float], note: str = "") -> dict[str, Maker]:
    return {f"{share:g} x balance{note}": lambda scenario, share=share: rule(scenario, share) for share in shares}


def _by_crossover(rule: Rule, shares: list[float]) -> dict[str, Maker]:
    """Candidates with a share of the crossover of the feedback, whatever the noise."""

    def make(scenario: Scenario, share: float) -> object:
        crossover = scenario.feedback.gains[0] / (2.0 * math.pi * scenario.feedback.inertia)
        return rule(scenario, share * crossover / balance(scenario))

    return {f"{share:g} x crossover": lambda scenario, share=share: make(scenario, share) for share in shares}


def _without_integral(rule: Rule) -> Rule:
    def make(scenario: Scenario, share: float) -> object:
        gains = {"inertia": scenario.feedback.inertia, "proportional": scenario.feedback.gains[0], "integral": 0.0}
        return rule(parse_scenario({**scenario.model_dump(exclude_unset=True), "feedback": gains}, "P"), share)

    return make


CANDIDATES: dict[str, dict[str, Maker]] = {
    "disturbance_observer": {
        **_by_balance(make_disturbance_observer, [0.7, 1.0, 1.2, 1.4, 1.7, 2.0, 2.8]),
        **_by_balance(_without_integral(make_disturbance_observer), [1.4, 2.0], ", P"),
        **_by_crossover(make_disturbance_observer, [1.0, 3.0, 6.0, 8.0]),
    },
    "extended_state": {
        **_by_balance(make_extended_state, [1.0, 1.4, 2.0, 2.4, 2.8, 3.4, 4.0]),
        **_by_crossover(make_extended_state, [3.0, 5.0, 8.0, 12.0, 16.0]),
    },
    "kalman_disturbance": {
        **_by_balance(make_kalman_disturbance, [1.0, 1.4, 1.7, 2.0, 2.4, 2.8]),
        **_by_balance(_without_integral(make_kalman_disturbance), [2.0, 2.8], ", P"),
        **_by_crossover(make_kalman_disturbance, [1.0, 3.0, 6.0, 8.0]),
    },
    "observed_nominal": _by_balance(make_observed_nominal, [0.05, 0.1, 0.14, 0.2, 0.28, 0.35, 0.5, 1.0, 1.7]),
    "observed_batch": _by_balance(make_observed_batch, [0.05, 0.1, 0.14, 0.2, 0.28, 0.35, 0.5, 1.0, 1.7]),
    **candidates(),
    **literature_candidates(),
}
"""Makers by controller and label."""


def searched(name: str, scenario: Scenario) -> Scenario:
    """Return the scenario that a controller's candidates run on: what it was made for, see ``MADE_FOR``."""
    tables = MADE_FOR.get(name, {})
    if "kind" in tables.get("joint", {}):
        tables = {**tables, "joint": {**scenario.joint.model_dump(exclude_unset=True), **tables["joint"]}}
    return scenario.modified(**tables)


def settled_error(name: str, label: str, scenario: str, seed: int) -> float:
    """Return the settled rms error of a candidate: of the velocity (rad/s), behind a position loop of the position."""
    course = searched(name, tuning_scenarios(name)[scenario]).modified(seed=seed)
    run = simulate(course, CANDIDATES[name][label](course), name=name)
    if run.position_metrics is not None:
        return run.position_metrics.rms_position_error_settled
    return run.metrics.rms_error_settled


def search(name: str, seeds: int, pool: Executor) -> dict[str, list[float]]:
    """Return the median settled error (rad/s) of each candidate of a controller on each scenario."""
    jobs = [
        (name, label, scenario, FIRST_SEED + seed)
        for label in CANDIDATES[name]
        for scenario in tuning_scenarios(name)
        for seed in range(seeds)
    ]
    settled_error(*jobs[0])  # here, so that workers find the controller compiled
    done = pool.map(settled_error, *zip(*jobs, strict=True), chunksize=seeds)
    errors = np.array(list(track(done, name, total=len(jobs), transient=True)))
    medians = np.median(errors.reshape(len(CANDIDATES[name]), -1, seeds), axis=2)
    return dict(zip(CANDIDATES[name], medians.tolist(), strict=True))


def table_of(name: str, errors: dict[str, list[float]]) -> Table:
    """Return the errors of a controller's candidates, the best one marked."""
    table = Table(title=f"{name}: settled rms error, mrad/s", box=SIMPLE)
    table.add_column("candidate")
    for heading in (*tuning_scenarios(name), "to the best"):
        table.add_column(heading, justify="right")
    values = np.array(list(errors.values()))
    ratios = np.exp(np.mean(np.log(values / values.min(axis=0)), axis=1))
    for label, row, ratio in zip(errors, values, ratios, strict=True):
        style = "bold" if ratio == ratios.min() else None
        table.add_row(label, *(f"{1e3 * value:.3g}" for value in row), f"{ratio:.3f}", style=style)
    return table


def main(
    only: Annotated[str | None, typer.Option(help="Search for this controller only.")] = None,
    seeds: Annotated[int, typer.Option(min=1, help="Number of seeds, from 101 on.")] = 5,
) -> None:
    """Print how every candidate does on scenarios that are not reported."""
    if only is not None and only not in CANDIDATES:
        raise typer.BadParameter(f"{only!r} is not known; there are {', '.join(CANDIDATES)}", param_hint="--only")
    with ProcessPoolExecutor(os.cpu_count()) as pool:
        for name in CANDIDATES if only is None else [only]:
            wide_console().print(table_of(name, search(name, seeds, pool)))


if __name__ == "__main__":
    typer.run(main)
