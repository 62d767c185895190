"""Experiments that report rows of their own: the paper, the exported C, friction laws on a record, mutants.

A figure is a number that a row reports, under a short name of what was measured; ``met`` holds a one or a zero for each
target.
"""

import importlib
import re
import subprocess
import sys
from collections.abc import Iterable
from dataclasses import dataclass
from typing import Any

from adaptive_ff.studies.study import Found
from benchmarks.suite import pooled, seeded

FIRST_NUMBER = re.compile(r"-?\d+(?:\.\d+)?(?:e[-+]?\d+)?|$")  # of a text, or its end
Figures = dict[str, list[float]]


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


def figures_of(rows: Iterable[Row]) -> Figures:
    """Return the numbers of rows by what was measured, and ``met``."""
    figures: Figures = {"met": []}
    for row in rows:
        number = FIRST_NUMBER.search(row.value)[0] if isinstance(row.value, str) else row.value
        if number != "":
            figures[re.sub(r"\W+", "_", row.quantity).strip("_")] = [float(number)]
        if row.met is not None:
            figures["met"].append(float(row.met))
    return figures


def imported(module: str) -> Any:
    """Return a module by its name in this package, which no fingerprint follows from here."""
    return importlib.import_module(f"benchmarks.{module}")


def run_experiment(module: str, row: str, _: list[int], controllers: list[str]) -> Found:
    """Run an experiment; its figures stand under the only name in the place of a controller."""
    (name,), found = controllers, imported(module).EXPERIMENTS[row]()
    return {"": {"row": row}, name: figures_of(getattr(found, "rows", found))}


def run_mutants(room: str, mutants: int, seed: int, controllers: list[str]) -> Found:
    """Count survivors of a room among so many mutants: the first room runs them all, and keeps what others read."""
    command = [sys.executable, "-m", "benchmarks.mutation", "--count", str(mutants), "--seed", str(seed)]
    done = subprocess.run(command, capture_output=True, text=True, check=False)
    found = re.search(rf"^{room}: (\d+) drawn, (\d+) survive", done.stdout, re.M)
    if found is None:
        raise ValueError(f"mutation: {(done.stdout + done.stderr)[-200:]}")
    return {"": {"row": room}, controllers[0]: {"drawn": float(found[1]), "survived": float(found[2])}}


def run_chip(chip: str, _: list[int], kinds: list[str]) -> Found:
    """Measure exported controllers on a processor."""
    measured = imported("export.chips").measured
    return {"": {"row": chip}, **{kind: measured(chip, kind) for kind in kinds}}


experiments = pooled(run_experiment, lambda module: {name: (module, name) for name in imported(module).EXPERIMENTS})
mutation = seeded(run_mutants, lambda rooms, mutants: {room: (room, mutants) for room in rooms})
chips = pooled(run_chip, lambda: {chip: (chip,) for chip in imported("export.chips").CHIPS})
