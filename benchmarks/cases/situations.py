"""Scenarios by name: those of the package, and situations made of the built-in one (``situations.toml``)."""

import math
import tomllib
from collections.abc import Iterable
from functools import cache, partial
from pathlib import Path
from typing import Any

import numpy as np

from adaptive_ff import Scenario, load_scenario, parse_scenario
from adaptive_ff.scenario.library import scenario_names
from adaptive_ff.scenario.new import new_scenario_text
from benchmarks.running import tracked
from benchmarks.suite import Rows, seeded

STAIRS, STAIR_SPEEDS = 20, (1.0, 3.0)  # number and range (rad/s) of the speeds of a staircase, drawn for each reference


@cache
def made(file: str = "situations") -> dict[str, dict[str, Any]]:
    """Return the situations of a file beside this one, by name."""
    return tomllib.loads(Path(__file__).with_name(f"{file}.toml").read_text(encoding="utf-8"))


def rows_of(file: str = "situations", draws: int = 1, names: Iterable[str] = ()) -> Rows:
    """Return situations of a file, all of them or some of them and of the package's scenarios by name."""
    return {name: (name, partial(named_scenario, name, file=file), draws) for name in names or made(file)}


situations = seeded(tracked, rows_of)
matrix = seeded(tracked, lambda draws: rows_of(draws=draws, names=scenario_names()))


def named_scenario(name: str, seed: int, file: str = "situations") -> Scenario:
    """Return a scenario of the package or a situation with a seed."""
    if name not in made(file):
        return load_scenario(name).modified(seed=seed)
    tables = dict(made(file)[name])
    base, sheet = tables.pop("base", None), tables.pop("sheet", None)
    counts, ripple, learnt = (tables.pop(special, None) for special in ("counts", "ripple", "map"))
    if counts is not None:
        tables["sensor"] = {"velocity_noise": 0.0, "encoder_resolution": 2.0 * np.pi / counts}
    if ripple is not None:
        period = 2.0 * np.pi / ripple["times"]
        tables["sensor"] = {"ripple_amplitude": ripple["share"] * period / (2.0 * np.pi), "ripple_period": period}
        tables = {"sampling": {"period": 0.002}, "reference": stairs(seed), **tables}
    if sheet is not None:
        scenario = parse_scenario(tomllib.loads(new_scenario_text(*sheet)), name)
    else:
        scenario = load_scenario(base) if base else load_scenario()
    scenario = scenario.modified(seed=seed, **tables)
    return scenario if learnt is None else scenario.modified(adaptation=mapped(scenario, **learnt))


def stairs(seed: int) -> dict[str, Any]:
    """Draw a reference of speeds of one sign."""
    speeds = np.random.default_rng([seed, STAIRS]).uniform(*STAIR_SPEEDS, STAIRS).round(3)
    return {"kind": "staircase", "velocities": speeds.tolist(), "hold": 3.0, "acceleration": 2.0}


def mapped(
    scenario: Scenario, periods: Iterable[float] = (), hats: int = 0, spacing: float = 0.0, load: bool = False
) -> dict[str, Any]:
    """Return the table of a map of friction over position or load; its range is that of the reference."""
    table: dict[str, Any] = {"position_periods": list(periods), "load_friction": load}
    if hats or spacing:
        position = np.cumsum(scenario.reference_velocity()) * scenario.joint.solver_period
        lowest, highest = float(np.min(position)), float(np.max(position))
        number = hats or math.ceil((highest - lowest) / spacing) + 1
        table |= {"position_hats": number, "position_range": [lowest, highest]}
    return table
