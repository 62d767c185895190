"""Two results of a suite side by side: geometric means, counts below a target, and the rows that moved."""

import math
from collections import defaultdict
from collections.abc import Iterable, Iterator, Sequence
from typing import NamedTuple

import numpy as np

from benchmarks.results import Result, Row
from benchmarks.running import BASE
from benchmarks.suite import Suite

WORSE, WINDOW = 0.95, 1.2
"""Settled ratio below which a case counts as worse than PI, and the largest ratio that a window may have."""

MOVED = 1.1  # factor by which the median of a row must change to be listed


class Pair(NamedTuple):
    """Figures of the same cases of a row in two results, one value a case; empty where one of both has none."""

    row: str
    first: defaultdict[str, list[float]]
    second: defaultdict[str, list[float]]


def pairs(first: Result, second: Result, controller: str) -> Iterator[Pair]:
    """Yield the rows that both results have of a controller, with the cases that both have."""
    for name, row in first.rows.items():
        other = second.rows.get(name)
        if other is not None and controller in row.figures and controller in other.figures:
            seeds = set(row.seeds) & set(other.seeds)
            if seeds:
                yield Pair(name, *(_of_seeds(one, controller, seeds) for one in (row, other)))


def _of_seeds(row: Row, controller: str, seeds: set[int]) -> defaultdict[str, list[float]]:
    """Return the columns of some seeds; of a case with several joints each counts."""
    found = defaultdict(list)
    for figure, column in row.figures[controller].items():
        joints, rest = divmod(len(column), len(row.seeds))
        if not rest:  # else not every case has this figure
            found[figure] = [value for place, value in enumerate(column) if row.seeds[place // joints] in seeds]
    return found


def geometric_mean(values: Iterable[float]) -> float:
    """Return the geometric mean; what is zero counts as a thousandth."""
    logarithms = [math.log(max(value, 1e-3)) for value in values]
    return math.exp(sum(logarithms) / len(logarithms)) if logarithms else math.nan


HEADINGS = ("suite", "contract", "controller", "cases", "settled", "ratio", "< 0.95", "window > 1.2", "start", "after")
"""Of :func:`summary_lines`; where a cell has two numbers, they are before and after."""

MOVED_HEADINGS = ("suite", "contract", "controller", "row", "figure", "before", "after", "better by")
"""Of :func:`moved_lines`."""


def summary_lines(suite: Suite, first: Result, second: Result, controllers: Sequence[str]) -> Iterator[list[str]]:
    """Yield a line for each controller, inside and outside the contract.

    Geometric mean over all cases of PI's settled error over the controller's in both, and the ratio of these two;
    number of cases below 0.95; number with a window above 1.2; medians of the first 5 s over PI's, and after a change.
    """
    for controller in controllers:
        listed = list(pairs(first, second, controller))
        for outside in (False, True):
            chosen = [pair for pair in listed if suite.is_outside(pair.row) is outside]
            both = [_columns([(pair.first, pair.second)[side] for pair in chosen]) for side in (0, 1)]
            if not both[0]["settled"] or not both[1]["settled"]:
                continue
            means = [geometric_mean(one["settled"]) for one in both]
            cells = [
                " ".join(f"{mean:.3f}" for mean in means),
                f"{means[1] / means[0]:.3f}",
                " ".join(str(sum(value < WORSE for value in one["settled"])) for one in both),
                " ".join(str(sum(value > WINDOW for value in one["window"])) for one in both),
                *(" ".join(_median(one[figure]) for one in both) for figure in ("start", "after")),
            ]
            label = "outside" if outside else "inside"
            yield [suite.name, label, controller, str(len(both[0]["settled"])), *cells]


def _columns(chosen: Sequence[dict[str, list[float]]]) -> dict[str, list[float]]:
    return {name: [value for one in chosen for value in one[name]] for name in ("settled", "window", "start", "after")}


def _median(values: list[float]) -> str:
    return f"{np.median(values):.3f}" if values else "-"


def moved_lines(suite: Suite, first: Result, second: Result, controllers: Sequence[str]) -> Iterator[list[str]]:
    """Yield the medians of rows that moved by more than a tenth, those that became worse first."""
    found = []
    for controller in controllers:
        for pair in pairs(first, second, controller):
            for figure in dict.fromkeys([*pair.first, *pair.second]):
                before, after = pair.first[figure], pair.second[figure]
                if not before or not after or figure in ("window", "torque_variation"):
                    continue
                old, new = (float(np.median(np.abs(one))) for one in (before, after))
                gain = _gain(figure, old, new)
                if not 1.0 / MOVED <= gain <= MOVED:
                    contract = "outside" if suite.is_outside(pair.row) else "inside"
                    found.append(
                        (gain, [suite.name, contract, controller, pair.row, figure, f"{old:.4g}", f"{new:.4g}"])
                    )
    for gain, cells in sorted(found, key=lambda one: one[0]):
        yield [*cells, f"{gain:.2f}"]


def _gain(figure: str, old: float, new: float) -> float:
    """Return by which factor a figure became better."""
    if old == new:
        return 1.0
    better, worse = (new, old) if figure == "settled" else (old, new)
    return better / worse if worse > 0.0 else math.inf


def compared_controllers(first: Result, second: Result) -> list[str]:
    """Return the controllers beside PI that both results have."""
    names = [{name for row in one.rows.values() for name in row.figures} for one in (first, second)]
    return sorted((names[0] & names[1]) - {BASE})
