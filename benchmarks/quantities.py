"""Quantities of a stored result: a statistic of a figure of a controller over the cases of a row."""

import math
import re
from collections.abc import Callable, Iterable
from fnmatch import fnmatchcase

import numpy as np

from adaptive_ff.errors import InputError
from benchmarks.results import Result
from benchmarks.suite import Suite


def geometric_mean(values: Iterable[float]) -> float:
    """Return the geometric mean; what is zero counts as a thousandth."""
    logarithms = [math.log(max(value, 1e-3)) for value in values]
    return math.exp(sum(logarithms) / len(logarithms)) if logarithms else math.nan


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

QUANTITY = re.compile(r"(?P<controller>[^.]+)\.(?P<figure>\w+) (?P<statistic>[\w:.]+)(?:\*(?P<scale>[\d.e+-]+))?")
"""How a quantity is written, such as ``adaptive.settled median`` or ``pi.error median*1000``."""


def more_is_better(figure: str) -> bool:
    """Tell whether more of a figure is better; of most less is."""
    return figure in ("settled", "own_gain", "gain", "met") or figure.endswith(("_inside", "_repeats"))


def quantity(result: Result, row: str, text: str) -> float | None:
    """Return a quantity of a row, or of all rows that a pattern matches; None where they have no such figure."""
    match = QUANTITY.fullmatch(text)
    if match is None:
        raise InputError(f"quantity = {text!r} is not allowed: write 'controller.figure statistic'")
    rows = [one for name, one in result.rows.items() if row == ALL or fnmatchcase(name, row)]
    columns = (one.figures.get(match["controller"], {}).get(match["figure"], []) for one in rows)
    values = [value for column in columns for value in column]
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


def missed(suite: Suite, result: Result, row: str) -> list[str]:
    """Return which targets a row inside the contract misses, in words; of patterns that match the last one holds."""
    found, targets = [], {}
    for pattern, limits in suite.targets.items():
        if fnmatchcase(row, pattern) and not suite.is_outside(row):
            targets |= limits
    for text, limit in targets.items():
        value, figure = quantity(result, row, text), text.partition(" ")[0].rpartition(".")[2]
        if value is None:
            continue
        more = more_is_better(figure)
        if value < limit if more else value > limit:
            found.append(f"{figure} {shown(value)} {'<' if more else '>'} {shown(limit)}")
    return found
