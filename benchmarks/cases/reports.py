"""Experiments that report rows of their own: the paper, the exported C, friction laws on a record, mutants.

A figure is a number that a row reports, under a short name of what was measured; ``met`` holds a one or a zero for each
target.
"""

import re
import subprocess
import sys
from collections.abc import Callable, Iterable
from functools import partial
from typing import Any

from adaptive_ff.studies.study import Found
from benchmarks.suite import Case

Reported = Iterable[tuple[str, Any, bool | None]]
"""What was measured, the number or text that was found, and whether the target is met."""


def run_report(row: str, report: Callable[[], Reported], controllers: list[str]) -> Found:
    """Run an experiment; its figures stand under the only name in the place of a controller."""
    (name,) = controllers
    figures: dict[str, Any] = {"met": []}
    for what, value, met in report():
        number = value if isinstance(value, float | int) else _first_number(str(value))
        if number is not None:
            figures[re.sub(r"\W+", "_", what).strip("_")] = float(number)
        if met is not None:
            figures["met"].append(float(met))
    return {"": {"row": row}, name: figures}


def _first_number(text: str) -> float | None:
    found = re.search(r"-?\d+(?:\.\d+)?(?:e[-+]?\d+)?", text)
    return float(found.group()) if found else None


def _paper(name: str) -> Reported:
    from benchmarks.paper.__main__ import EXPERIMENTS

    return [(row.quantity, row.value, row.met) for row in EXPERIMENTS[name]().rows]


def paper(count: int = 1, first: int = 1) -> list[Case]:
    """Return the experiments of the paper."""
    from benchmarks.paper.__main__ import EXPERIMENTS

    return [Case(name, first, partial(run_report, name, partial(_paper, name))) for name in EXPERIMENTS]


def _export(name: str) -> Reported:
    from benchmarks.export.sections import SECTIONS

    return SECTIONS[name]()


def export(count: int = 1, first: int = 1) -> list[Case]:
    """Return the sections of the export."""
    from benchmarks.export.sections import SECTIONS

    return [Case(name, first, partial(run_report, name, partial(_export, name))) for name in SECTIONS]


def _friction_laws() -> Reported:
    from benchmarks.friction.laws import LAWS, fit_all
    from benchmarks.friction.record import DATA, read_record

    if not DATA.is_file():
        raise ValueError("the measured record is not beside this repository")
    fits, asked = fit_all(read_record(DATA)), {law.name: law.fraction for law in LAWS}
    shares = {fit.law: fit.tested / fits[0].tested for fit in fits}
    return [(law, fraction, fraction <= asked[law] if law in asked else None) for law, fraction in shares.items()]


def friction_laws(count: int = 1, first: int = 1) -> list[Case]:
    """Return the fits of the friction laws, errors over that of Coulomb friction."""
    return [Case("presliding record", first, partial(run_report, "presliding record", _friction_laws))]


def _mutation(room: str, mutants: int, seed: int) -> Reported:
    command = [sys.executable, "-m", "benchmarks.mutation", "--count", str(mutants), "--seed", str(seed)]
    done = subprocess.run(command, capture_output=True, text=True, check=False)
    found = re.search(rf"^{room}: (\d+) drawn, (\d+) survive", done.stdout, re.M)
    if found is None:
        raise ValueError(f"mutation: {(done.stdout + done.stderr)[-200:]}")
    return [("drawn", int(found[1]), None), ("survived", int(found[2]), None)]


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
