"""Quantities of a stored result: a statistic of a figure of a controller over the cases of a row."""

import math
import re
from collections.abc import Callable
from fnmatch import fnmatchcase

import numpy as np

from adaptive_ff.errors import InputError
from benchmarks.compare import geometric_mean
from benchmarks.results import Columns, Result
from benchmarks.suite import Suite

STATISTICS: dict[str, Callable[[list[float]], float]] = {
    "median": lambda values: float(np.median(values)),
    "least": min,
    "most": max,
    "mean": lambda values: float(np.mean(values)),
    "size": lambda values: float(np.median(np.abs(values))),
    "geometric": geometric_mean,
    "percent": lambda values: 100.0 * float(np.mean(values)),
    "count": len,
    "total": sum,
}
"""Statistics by name; ``below:X`` and ``above:X`` count values beyond a limit. ``size`` is the median magnitude."""

ALL = "all"  # row that holds the cases of all rows
MORE_IS_BETTER = frozenset({"settled", "own_gain", "gain"})  # figures of which more is better; of all others less is

QUANTITY = re.compile(r"(?P<controller>[^.]+)\.(?P<figure>\w+) (?P<statistic>[\w:.]+)(?:\*(?P<scale>[\d.e+-]+))?")
"""How a quantity is written, such as ``adaptive.settled median`` or ``pi.error median*1000``."""


def columns_of(result: Result, row: str, controller: str) -> Columns:
    """Return the figures of a controller in a row, or in all rows that a pattern matches."""
    found: Columns = {}
    for name, one in result.rows.items():
        if row == ALL or fnmatchcase(name, row):
            for figure, column in one.figures.get(controller, {}).items():
                found.setdefault(figure, []).extend(column)
    return found


def quantity(result: Result, row: str, text: str) -> float | None:
    """Return a quantity of a row; None where the row has no such figure."""
    match = QUANTITY.fullmatch(text)
    if match is None:
        raise InputError(f"quantity = {text!r} is not allowed: write 'controller.figure statistic'")
    values = columns_of(result, row, match["controller"]).get(match["figure"], [])
    if not values:
        return None
    return float(match["scale"] or 1.0) * _statistic(match["statistic"])(values)


def _statistic(name: str) -> Callable[[list[float]], float]:
    kind, _, limit = name.partition(":")
    if kind == "below":
        return lambda values: sum(value < float(limit) for value in values)
    if kind == "above":
        return lambda values: sum(value > float(limit) for value in values)
    if name not in STATISTICS:
        raise InputError(f"statistic = {name!r} is not known; there are {', '.join(STATISTICS)}, below:X, above:X")
    return STATISTICS[name]


def shown(value: float | None, digits: int = 3) -> str:
    """Return a number as a table shows it, with few digits."""
    if value is None:
        return "-"
    if not math.isfinite(value):
        return "failed"
    if value == int(value) and abs(value) < 10**digits:
        return str(int(value))
    text = f"{value:.{digits}g}"
    return f"{float(text):.0f}" if "e+" in text else text


def targets_of(suite: Suite, row: str) -> dict[str, float]:
    """Return the targets of a row by quantity; a later pattern that matches goes before an earlier one."""
    found: dict[str, float] = {}
    if suite.is_outside(row):
        return found
    for pattern, limits in suite.targets.items():
        if fnmatchcase(row, pattern):
            found |= limits
    return found


def missed(suite: Suite, result: Result, row: str) -> list[str]:
    """Return which targets a row misses, in words."""
    found = []
    for text, limit in targets_of(suite, row).items():
        value, figure = quantity(result, row, text), text.partition(" ")[0].rpartition(".")[2]
        if value is None:
            continue
        more = figure in MORE_IS_BETTER or figure.endswith("_inside")
        if value < limit if more else value > limit:
            found.append(f"{figure} {shown(value)} {'<' if more else '>'} {shown(limit)}")
    return found
