"""What the online choice of a model brings and costs: ``python -m benchmarks.model_choice [--references 10]``.

Two tables: settled error of PI over that of ``adaptive``, with its candidates for Stribeck velocity and presliding
distance and without any; and the error of its windows of 5 s on a joint with a weight, with gravity identified and with
an offset alone.
"""

import os
from collections.abc import Iterable
from concurrent.futures import Executor, ProcessPoolExecutor
from typing import Annotated, Any

import numpy as np
import typer
from rich.box import SIMPLE
from rich.table import Table

from adaptive_ff import Scenario, load_scenario
from adaptive_ff.comparison.matrix.cells import SCENARIOS
from adaptive_ff.comparison.registry import make_adaptive
from adaptive_ff.comparison.windows import Judgement, judge
from benchmarks.presliding import bristles
from benchmarks.wide import wide_console

NAMES = (
    "high_stiction_vs_quarter",
    "high_stiction_vs_fourfold",
    "high_stiction",
    "lugre_1e3",
    "lugre_3e3",
    "lugre_1e4",
    "lugre_1e5",
    "maxwell",
    "elasto_plastic",
    "rolling",
    "paper_100hz",
    "noisy_1khz",
    "gravity_100",
    "steep_5",
)
"""Joints of the first table: scenarios of the matrix, and stiffer bristles than they have."""

WEIGHTS = (0.0, 40.0, 100.0)
"""Weights of the second table, N m."""

SPANS = {"0 to 5 s": (0, 1), "5 to 10 s": (1, 2), "10 to 20 s": (2, 4), "30 to 40 s": (6, 8)}
"""Windows of 5 s that are shown together, from one to before another."""


def without_candidates(scenario: Scenario) -> Any:
    """Make the controller that keeps the Stribeck velocity which is assumed, and has no bristles."""
    return make_adaptive(scenario, stribeck_factors=(), presliding_factors=())


def named(name: str) -> Scenario:
    """Return a scenario of the first table."""
    return bristles(1e5) if name == "lugre_1e5" else load_scenario(SCENARIOS / f"{name}.toml")


def weighted(weight: float, identify: str) -> Scenario:
    """Return the built-in joint at 100 Hz with a weight (N m), and what is identified of it."""
    scenario = load_scenario(SCENARIOS / "paper_100hz.toml")
    return scenario.modified(
        joint=scenario.joint.model_copy(update={"gravity": weight}),
        adaptation=scenario.adaptation.model_copy(update={"identify": identify}),
    )


def judged(scenario: Scenario) -> tuple[Judgement, Judgement]:
    """Judge the controller without and with its candidates on one reference."""
    found = judge(scenario, without_candidates)
    return found, judge(scenario, base=found.base)


def seeded(scenario: Scenario, seeds: Iterable[int]) -> list[Scenario]:
    """Return a scenario for each seed."""
    return [scenario.modified(seed=seed) for seed in seeds]


def candidates_table(pool: Executor, seeds: range) -> Table:
    """Return what the candidates bring on each joint, medians over references."""
    table = Table(title=f"PI over own, settled, {len(seeds)} references of five draws of the noise", box=SIMPLE)
    for heading in ("joint", "without candidates (least)", "with (least)"):
        table.add_column(heading, justify="left" if heading == "joint" else "right", no_wrap=True)
    for name in NAMES:
        found = np.array([[one.settled for one in pair] for pair in pool.map(judged, seeded(named(name), seeds))])
        medians, least = np.median(found, axis=0), np.min(found, axis=0)
        table.add_row(name, *(f"{a:.2f} ({b:.2f})" for a, b in zip(medians, least, strict=True)))
    return table


def weights_table(pool: Executor, seeds: range) -> Table:
    """Return the errors on a joint with a weight, root mean squares over references."""
    table = Table(title=f"rms error, mrad/s, {len(seeds)} references of five draws of the noise", box=SIMPLE)
    for heading in ("weight, N m", "identified", *SPANS, "worst window over PI's"):
        table.add_column(heading, justify="right", no_wrap=True)
    for weight in WEIGHTS:
        for identify in ("offset", "gravity"):
            found = list(pool.map(judge, seeded(weighted(weight, identify), seeds)))
            windows = np.sqrt(np.mean(np.square([one.own.windows for one in found]), axis=0))
            spans = [1e3 * np.sqrt(np.mean(windows[first:last] ** 2)) for first, last in SPANS.values()]
            worst = max(one.worst_window for one in found)
            table.add_row(f"{weight:g}", identify, *(f"{span:.2f}" for span in spans), f"{worst:.2f}")
    return table


def main(
    first_seed: Annotated[int, typer.Option(min=0, help="First seed; 101 and more while tuning.")] = 1,
    references: Annotated[int, typer.Option(min=1, help="Number of references.")] = 10,
    workers: Annotated[int, typer.Option(min=1, help="Processes.")] = os.cpu_count() or 1,
) -> None:
    """Print what candidates for the model bring, and what identified gravity does."""
    judged(named("lugre_1e4").modified(duration=6.0))  # here, so that workers find the controllers compiled
    seeds = range(first_seed, first_seed + references)
    with ProcessPoolExecutor(workers) as pool:
        wide_console().print(candidates_table(pool, seeds))
        wide_console().print(weights_table(pool, seeds))


if __name__ == "__main__":
    typer.run(main)
