"""Judging a controller against its PI loop: a row of figures for each situation, and what of that asked is missed."""

from collections.abc import Callable, Iterable
from concurrent.futures import Executor
from typing import Any

import numpy as np
from rich.box import SIMPLE
from rich.table import Table

from adaptive_ff.comparison.comparison import BASELINE
from adaptive_ff.comparison.windows import Judgement, judge, judge_chance
from benchmarks.never_worse.cases import Case
from benchmarks.never_worse.situations import asked_of

WORST_SETTLED = 0.95
"""Least settled error of PI over the controller's for any reference."""


def judge_case(case: Case, controller: str, draws: int) -> Judgement:
    """Judge a controller on one reference; PI under other noise than that which it is compared with."""
    if controller == BASELINE:
        return judge_chance(case.scenario, draws=draws)
    return judge(case.scenario, controller, draws=draws)


def row_of(name: str, found: list[Judgement]) -> dict[str, Any]:
    """Return the figures of a situation over its references, and which of what is asked is missed."""
    asked = asked_of(name)
    settled = np.array([judgement.settled for judgement in found])
    windows = np.array([judgement.worst_window for judgement in found])
    start = np.array([judgement.start for judgement in found])
    after = np.array([ratio for judgement in found for ratio in judgement.after])
    row = {
        "situation": name,
        "references": len(found),
        "pi": float(np.median([judgement.base.settled for judgement in found])),
        "settled": float(np.median(settled)),
        "settled_worst": float(np.min(settled)),
        "settled_under": int(np.sum(settled < WORST_SETTLED)),
        "worst_window": float(np.max(windows)),
        "windows_over": int(np.sum(windows > asked.window)),
        "start": float(np.median(start)),
        "start_worst": float(np.max(start)),
        "after": float(np.median(after)) if after.size else None,
        "asked": asked._asdict(),
    }
    # of drawn joints the median is one of different joints; each is asked to be never worse all the same
    checks = {
        "settled": row["settled"] >= asked.settled and row["settled_worst"] >= WORST_SETTLED,
        "window": row["worst_window"] <= asked.window,
        "start": row["start"] <= asked.start and (asked.start == np.inf or row["start_worst"] <= 1.0),
        "after": row["after"] is None or row["after"] <= asked.after,
    }
    return {**row, "missed": [check for check, met in checks.items() if not met]}


HEADINGS = (
    "situation",
    "n",
    "pi, mrad/s or mrad",
    "pi / own (least)",
    "worse",
    "worst window",
    "over",
    "start (worst)",
    "after change",
    "missed",
)


def table_of(rows: list[dict[str, Any]], title: str) -> Table:
    """Return the rows as a table for a terminal.

    *worse* counts references whose settled error of PI over the controller's is below what is asked of each, *over*
    those with a window above its limit.
    """
    table = Table(title=title, box=SIMPLE, title_style="bold")
    for heading in HEADINGS:
        table.add_column(heading, justify="left" if heading in ("situation", "missed") else "right", no_wrap=True)
    for row in rows:
        asked = row["asked"]
        table.add_row(
            row["situation"],
            str(row["references"]),
            f"{1e3 * row['pi']:.3g}",
            f"{row['settled']:.2f} ({row['settled_worst']:.2f}) >= {asked['settled']:g}",
            str(row["settled_under"]),
            f"{row['worst_window']:.2f}" + _limit(asked["window"]),
            str(row["windows_over"]),
            f"{row['start']:.2f} ({row['start_worst']:.2f})" + _limit(asked["start"]),
            "-" if row["after"] is None else f"{row['after']:.2f}" + _limit(asked["after"]),
            ", ".join(row["missed"]),
            style="red" if row["missed"] else None,
        )
    return table


def _limit(value: float) -> str:
    return "" if np.isinf(value) else f" <= {value:g}"


def as_json(value: Any) -> Any:
    """Return a row as JSON can hold it: what is infinite, such as a limit that is not asked for, is null."""
    if isinstance(value, dict):
        return {name: as_json(part) for name, part in value.items()}
    return None if isinstance(value, float) and not np.isfinite(value) else value


def rows_of(
    cases: list[Case],
    controller: str,
    draws: int,
    pool: Executor,
    watch: Callable[[Iterable[Judgement], int], Iterable[Judgement]],
) -> list[dict[str, Any]]:
    """Judge all cases and return a row for each name, in their order."""
    count = len(cases)
    found = list(watch(pool.map(judge_case, cases, [controller] * count, [draws] * count), count))
    names = dict.fromkeys(case.name for case in cases)
    return [row_of(name, [f for case, f in zip(cases, found, strict=True) if case.name == name]) for name in names]
