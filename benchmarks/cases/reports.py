"""Experiments that report rows of their own: the paper, the exported C, friction laws on a record, mutants.

A figure is a number that a row reports, under a short name of what was measured; ``met`` holds a one or a zero for each
target.
"""

import importlib
import re
import subprocess
import sys
from collections.abc import Callable, Iterable
from dataclasses import dataclass
from functools import partial
from typing import Any

from adaptive_ff.studies.study import Found
from benchmarks.suite import Case


@dataclass(frozen=True)
class Row:
    """What an experiment reports."""

    quantity: str  # what was measured, unit included
    value: float | str  # the figure
    target: str = ""  # what it should reach, empty where nothing is asked
    met: bool | None = None  # whether it does; None without a target


def limited(quantity: str, value: float, limit: float) -> Row:
    """Return a row whose figure should not be above a limit."""
    return Row(quantity, value, f"<= {limit:g}", value <= limit)


def run_report(row: str, report: Callable[[], Iterable[Row]], controllers: list[str]) -> Found:
    """Run an experiment; its figures stand under the only name in the place of a controller."""
    (name,) = controllers
    figures: dict[str, Any] = {"met": []}
    for one in report():
        number = re.search(r"-?\d+(?:\.\d+)?(?:e[-+]?\d+)?", one.value) if isinstance(one.value, str) else one.value
        if number is not None:
            value = number.group() if isinstance(number, re.Match) else number
            figures[re.sub(r"\W+", "_", one.quantity).strip("_")] = float(value)
        if one.met is not None:
            figures["met"].append(float(one.met))
    return {"": {"row": row}, name: figures}


def _report(module: str, name: str) -> Iterable[Row]:
    found = importlib.import_module(f"benchmarks.{module}").EXPERIMENTS[name]()
    return getattr(found, "rows", found)


def experiments(module: str, count: int = 1, first: int = 1) -> list[Case]:
    """Return the experiments that a module has by name."""
    names = importlib.import_module(f"benchmarks.{module}").EXPERIMENTS
    return [Case(name, first, partial(run_report, name, partial(_report, module, name))) for name in names]


def _mutation(room: str, mutants: int, seed: int) -> list[Row]:
    command = [sys.executable, "-m", "benchmarks.mutation", "--count", str(mutants), "--seed", str(seed)]
    done = subprocess.run(command, capture_output=True, text=True, check=False)
    found = re.search(rf"^{room}: (\d+) drawn, (\d+) survive", done.stdout, re.M)
    if found is None:
        raise ValueError(f"mutation: {(done.stdout + done.stderr)[-200:]}")
    return [Row("drawn", int(found[1])), Row("survived", int(found[2]))]


def mutation(rooms: list[str], mutants: int, count: int = 1, first: int = 1) -> list[Case]:
    """Return the rooms of draws of so many mutants: the first one runs them all, and keeps what the others read."""
    return [
        Case(f"{room}/{seed}", seed, partial(run_report, room, partial(_mutation, room, mutants, seed)))
        for seed in range(first, first + count)
        for room in rooms
    ]


def _chip(chip: str, kinds: list[str]) -> Found:
    from benchmarks.export.chips import CHIPS, measured

    return {"": {"row": chip}, **{kind: measured(CHIPS[chip], kind) for kind in kinds}}


def chips(count: int = 1, first: int = 1) -> list[Case]:
    """Return the processors for which controllers are exported."""
    from benchmarks.export.chips import CHIPS

    return [Case(chip, first, partial(_chip, chip)) for chip in CHIPS]
