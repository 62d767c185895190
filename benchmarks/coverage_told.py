"""What the logs of ``benchmarks.coverage`` determine at best: ``python -m benchmarks.coverage_told [--logs N]``.

The same logs are fitted with exactly the terms that the joint has, so nothing is chosen, and intervals are those of
that one fit (its lag and bend searched; where the shape of the saturation is none of those identified, the one that
fits best). What is vague then is vague for every choice of models: the noise of the log does not let it be told.
"""

from typing import Annotated, Any

import numpy as np
import typer
from rich.box import SIMPLE
from rich.table import Table

from adaptive_ff.identify.fitting.fit import fit_terms
from adaptive_ff.identify.fitting.fitted import Fitted
from adaptive_ff.identify.fitting.grid import BLOCKS, make_grid
from adaptive_ff.identify.fitting.grid_fit import fit_on_grid
from adaptive_ff.identify.preparation import prepare, regression_problem
from adaptive_ff.identify.reported import VAGUE
from adaptive_ff.identify.terms import BENT, LAG
from benchmarks.coverage import FIRST_SEED, NAMES, Case, make_case
from benchmarks.wide import wide_console

CONFIDENCE = 0.95


def fit_told(case: Case) -> Fitted | None:
    """Fit the terms that the joint of a log has; None where the log does not determine them."""
    prepared = prepare(case.log, None, linear=False)
    problem = regression_problem(prepared, prepared.pieces, 0.0)
    grid = make_grid(problem)
    every, none = np.ones(BLOCKS, dtype=np.bool_), np.zeros(BLOCKS, dtype=np.bool_)
    starts = {terms: fit_on_grid(grid, terms, every, none) for terms in case.models}
    terms, start = min(starts.items(), key=lambda item: item[1].squares)
    try:
        return fit_terms(
            problem, terms, CONFIDENCE, start={LAG: start.lag, **dict.fromkeys(BENT.values(), start.speed)}
        )
    except ValueError:
        return None


def judge(case: Case) -> dict[str, dict[str, Any]] | None:
    """Compare the intervals of a log with the truth; None where there is no fit."""
    fitted = fit_told(case)
    if fitted is None:
        return None
    judged = {}
    for name in NAMES:
        value, _, lower, upper = fitted.estimate(name)
        vague = 0.5 * (upper - lower) / abs(value)
        judged[name] = {"covers": lower <= case.truth[name] <= upper, "vague": vague, "zero": lower <= 0.0}
    return judged


def told_table(judged: list[dict[str, dict[str, Any]] | None]) -> Table:
    """Return coverage and vagueness, one parameter a row."""
    found = [one for one in judged if one is not None]
    table = Table(
        title=f"The true terms fitted, {len(judged)} logs, {len(judged) - len(found)} of them not", box=SIMPLE
    )
    for heading in ("parameter", "holds the truth", f"half width from {100.0 * VAGUE:g} % on", "holds zero"):
        table.add_column(heading, justify="left" if heading == "parameter" else "right")
    for name in NAMES:
        whole = [one[name] for one in found]
        shares = (
            [one["covers"] for one in whole],
            [one["vague"] >= VAGUE for one in whole],
            [one["zero"] for one in whole],
        )
        table.add_row(name, *(f"{100.0 * np.mean(share):.1f} %" for share in shares))
    vague = [one is None or any(one[name]["vague"] >= VAGUE for name in NAMES) for one in judged]
    zero = [one is None or any(one[name]["zero"] for name in NAMES) for one in judged]
    table.add_row("any, or no fit", "", *(f"{100.0 * np.mean(share):.1f} %" for share in (vague, zero)))
    return table


def main(
    logs: Annotated[int, typer.Option(min=1, help="Number of logs.")] = 500,
    first: Annotated[int, typer.Option(min=0, help="Seed of the first log.")] = FIRST_SEED,
) -> None:
    """Print what is vague even where the terms are told."""
    wide_console().print(told_table([judge(make_case(seed)) for seed in range(first, first + logs)]))


if __name__ == "__main__":
    typer.run(main)
