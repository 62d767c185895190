"""How honest the intervals of ``identify`` are: ``python -m benchmarks.coverage [--logs N]``.

Half of the logs are of joints with the terms of the identified models, half of joints with physics that these lack
(see ``drawn_logs``). For inertia, Coulomb and viscous friction it is counted how often the textbook's 95 % interval
holds the truth, how wide it is, and how many logs are refused or not usable. Another record of each joint, along
another motion, shows whether repetition agrees: estimates apart by no more than both half widths, added as squares.
"""

import math
import time
from pathlib import Path
from typing import Annotated, Any

import numpy as np
import typer
from rich.box import SIMPLE
from rich.table import Table

from adaptive_ff import InputError
from adaptive_ff.files import write_json
from adaptive_ff.identify.identification import identify_log
from adaptive_ff.identify.result import UNUSABLE
from adaptive_ff.logs.log import Log
from benchmarks.drawn_logs import Case, make_case
from benchmarks.in_turn import CORES, Workers, run_seeds
from benchmarks.wide import wide_console

FIRST_SEED = 10_000
"""Seed of the first log; constants were chosen on seeds below 1 000."""

NAMES = ("inertia", "coulomb", "viscous")

HALVES = {0: "terms of the model", 1: "other physics"}


def examine(log: Log, truth: dict[str, float], **given: Any) -> dict[str, Any]:
    """Identify a log, and compare the textbook's intervals with the truth."""
    result: dict[str, Any] = {"log": log.name, "refused": None}
    start = time.perf_counter()
    try:
        found = identify_log(log, **given)
    except InputError as error:
        return {**result, "refused": str(error)}
    result |= {"seconds": time.perf_counter() - start, "grade": found.grade, "taken": list(found.taken)}
    for name in NAMES:
        one = found.parameters.get(name)
        if one is not None:
            result[name] = {
                "true": truth[name],
                "value": one.value,
                "lower": one.lower,
                "upper": one.upper,
                "covers": bool(one.lower <= truth[name] <= one.upper),
                "half_width": 0.5 * (one.upper - one.lower) / truth[name],
                "error": one.value / truth[name] - 1.0,
            }
    return result


def examine_seed(seed: int) -> list[dict[str, Any]]:
    """Examine both records of a joint."""
    return [_of_case(make_case(seed, record=record)) for record in (0, 1)]


def _of_case(case: Case) -> dict[str, Any]:
    return {**examine(case.log, case.truth), "kind": case.kind, "enough": case.enough}


def coverage_table(pairs: list[list[dict[str, Any]]], title: str) -> Table:
    """Return coverage, width, repetition and error, one parameter a row."""
    whole = [one for pair in pairs for one in pair]
    found = [one for one in whole if one["refused"] is None]
    unusable = sum(one["refused"] is not None or one["grade"] == UNUSABLE for one in whole)
    table = Table(
        title=f"{title}: {len(whole)} logs, {len(whole) - len(found)} refused, {unusable} refused or not usable; "
        f"median {np.median([one['seconds'] for one in found]):.2f} s a log",
        box=SIMPLE,
    )
    for heading in ("parameter", "holds the truth", "median half width", "repetition agrees", "median error"):
        table.add_column(heading, justify="left" if heading == "parameter" else "right")
    for name in NAMES:
        each = [one for one in found if name in one]
        wide = [one[name]["half_width"] for one in each if one.get("enough", True)]
        agree = [
            _agrees(*(one[name] for one in pair))
            for pair in pairs
            if len(pair) > 1 and all(name in one for one in pair)
        ]
        table.add_row(
            name,
            _percent([one[name]["covers"] for one in each]),
            f"{100.0 * float(np.median(wide)):.1f} %" if wide else "",
            _percent(agree),
            f"{100.0 * float(np.median([abs(one[name]['error']) for one in each])):.1f} %",
        )
    return table


def _agrees(one: dict[str, float], other: dict[str, float]) -> bool:
    """Tell whether two estimates are apart by no more than the halves of their intervals between them."""
    low, high = sorted((one, other), key=lambda each: each["value"])
    allowed = math.hypot(low["upper"] - low["value"], high["value"] - high["lower"])
    return bool(high["value"] - low["value"] <= allowed)


def _percent(flags: list[bool]) -> str:
    return f"{100.0 * np.mean(flags):.1f} %" if flags else ""


def main(
    logs: Annotated[int, typer.Option(min=2, help="Number of logs, two records of each joint.")] = 500,
    first: Annotated[int, typer.Option(min=0, help="Seed of the first joint.")] = FIRST_SEED,
    workers: Workers = CORES,
    json: Annotated[Path | None, typer.Option(help="Write all results there.")] = None,
) -> None:
    """Print coverage, width and repetition of the stated intervals, by half and by physics."""
    pairs = run_seeds(examine_seed, range(first, first + logs // 2), workers, "joints")
    console = wide_console()
    for half, title in HALVES.items():
        chosen = [pair for seed, pair in enumerate(pairs, start=first) if seed % 2 == half]
        if chosen:
            console.print(coverage_table(chosen, title))
    for kind in sorted({pair[0]["kind"] for pair in pairs}):
        found = [one for pair in pairs for one in pair if one["kind"] == kind and one["refused"] is None]
        held = ", ".join(f"{name} {sum(one[name]['covers'] for one in found if name in one)}" for name in NAMES)
        console.print(f"{kind}: held of {len(found)}: {held}", highlight=False)
    if json is not None:
        write_json(json, {"logs": pairs})


if __name__ == "__main__":
    typer.run(main)
