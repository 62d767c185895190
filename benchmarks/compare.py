"""Two results of a suite side by side: geometric means, counts below a target, and the rows that moved."""

import math
from collections.abc import Iterator, Sequence

import numpy as np

from benchmarks.quantities import geometric_mean, more_is_better
from benchmarks.results import Columns, Result, Row
from benchmarks.running import BASE
from benchmarks.suite import Suite

WORSE, WINDOW = 0.95, 1.2
"""Settled ratio below which a case counts as worse than PI, and the largest ratio that a window may have."""

MOVED = 1.1  # factor by which the median of a row must change to be listed
SUMMARISED = ("settled", "window", "start", "after")
Pair = tuple[str, str, tuple[Columns, Columns]]  # name of a row, in- or outside the contract, figures of both results

HEADINGS = ("suite", "contract", "controller", "cases", "settled", "ratio", "< 0.95", "window > 1.2", "start", "after")
"""Of :func:`summary_lines`; where a cell has two numbers, they are before and after."""

MOVED_HEADINGS = ("suite", "contract", "controller", "row", "figure", "before", "after", "better by")
"""Of :func:`moved_lines`."""


def pairs(suite: Suite, first: Result, second: Result, controller: str) -> Iterator[Pair]:
    """Yield the rows that both results have of a controller: name, in- or outside the contract, figures of both.

    A figure has a value for each of the cases that both have.
    """
    for name, row in first.rows.items():
        rows = (row, second.rows.get(name, Row()))
        seeds = set(row.seeds) & set(rows[1].seeds)
        if seeds and all(controller in one.figures for one in rows):
            before, after = (_of_seeds(one, controller, seeds) for one in rows)
            yield name, "outside" if suite.is_outside(name) else "inside", (before, after)


def _of_seeds(row: Row, controller: str, seeds: set[int]) -> Columns:
    """Return the columns of some seeds; of a case with several joints each counts."""
    found = {}
    for figure, column in row.figures[controller].items():
        joints, rest = divmod(len(column), len(row.seeds))
        if not rest:  # else not every case has this figure
            found[figure] = [value for place, value in enumerate(column) if row.seeds[place // joints] in seeds]
    return found


def summary_lines(suite: Suite, first: Result, second: Result, controllers: Sequence[str]) -> Iterator[list[str]]:
    """Yield a line for each controller, inside and outside the contract.

    Geometric mean over all cases of PI's settled error over the controller's in both, and the ratio of these two;
    number of cases below 0.95; number with a window above 1.2; medians of the first 5 s over PI's, and after a change.
    """
    for controller in controllers:
        listed = list(pairs(suite, first, second, controller))
        for contract in ("inside", "outside"):
            chosen = [both for _, which, both in listed if which == contract]
            settled, windows, *others = (
                [[value for both in chosen for value in both[side].get(figure, [])] for side in (0, 1)]
                for figure in SUMMARISED
            )
            if not all(settled):
                continue
            means = [geometric_mean(values) for values in settled]
            cells = [
                " ".join(f"{mean:.3f}" for mean in means),
                f"{means[1] / means[0]:.3f}",
                " ".join(str(sum(value < WORSE for value in values)) for values in settled),
                " ".join(str(sum(value > WINDOW for value in values)) for values in windows),
                *(" ".join(f"{np.median(values):.3f}" if values else "-" for values in both) for both in others),
            ]
            yield [suite.name, contract, controller, str(len(settled[0])), *cells]


def moved_lines(suite: Suite, first: Result, second: Result, controllers: Sequence[str]) -> Iterator[list[str]]:
    """Yield the medians of rows that moved by more than a tenth, those that became worse first."""
    found = []
    for controller in controllers:
        for row, contract, both in pairs(suite, first, second, controller):
            for figure in both[0]:
                before, after = (one.get(figure) for one in both)
                if not before or not after or figure in ("window", "torque_variation"):
                    continue
                old, new = (float(np.median(np.abs(one))) for one in (before, after))
                gain = _gain(figure, old, new)
                if not 1.0 / MOVED <= gain <= MOVED:
                    cells = [suite.name, contract, controller, row, figure, f"{old:.4g}", f"{new:.4g}"]
                    found.append((gain, [*cells, f"{gain:.2f}"]))
    return (cells for _, cells in sorted(found, key=lambda one: one[0]))


def _gain(figure: str, old: float, new: float) -> float:
    """Return by which factor a figure became better."""
    if old == new:
        return 1.0
    better, worse = (new, old) if more_is_better(figure) else (old, new)
    return better / worse if worse > 0.0 else math.inf


def compared_controllers(first: Result, second: Result) -> list[str]:
    """Return the controllers beside PI that both results have."""
    names = [{name for row in one.rows.values() for name in row.figures} for one in (first, second)]
    return sorted((names[0] & names[1]) - {BASE})
