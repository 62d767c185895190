"""Running a suite: its cases on the engine of the studies, and their figures gathered into rows."""

import time
from collections.abc import Callable, Sequence
from concurrent.futures import Executor
from subprocess import SubprocessError
from typing import Any

from adaptive_ff.studies.study import Found, Store, run_study
from benchmarks.fingerprint import fingerprint
from benchmarks.results import RESULTS, Result, Row, circumstances
from benchmarks.suite import SCENARIOS, SUITES, Case, Suite

KEPT = RESULTS / "kept"  # where results are kept as they come; not committed

BASE = "pi"


def run_suite(
    suite: Suite,
    cases: Sequence[Case],
    controllers: Sequence[str],
    *,
    named: str | None = None,
    workers: int | None = None,
    executor: Executor | None = None,
    progress: Callable[[float], None] | None = None,
) -> Result:
    """Run cases of a suite.

    Parameters
    ----------
    suite : Suite
        The suite.
    cases : sequence of Case
        Which of its cases.
    controllers : sequence of str
        Names of the controllers.
    named : str, optional
        Name under which the only controller beside PI goes into the result; by default its own.
    workers, executor, progress
        As for :func:`adaptive_ff.studies.study.run_study`.
    """
    mark = suite_fingerprint(suite)
    began = time.perf_counter()
    listed = {case.key: case for case in cases}
    store = Store(KEPT / f"{suite.name}.jsonl", mark)
    found = run_study(run_case, listed, controllers, store=store, executor=executor, workers=workers, progress=progress)
    seconds = round(time.perf_counter() - began, 1)
    others = [name for name in controllers if name != BASE]
    names = {name: named if named and others == [name] else name for name in controllers}
    rows, refused = gathered(listed, found, names)
    return Result(suite.name, fingerprint=mark, seconds=seconds, rows=rows, refused=refused, **circumstances())


def suite_fingerprint(suite: Suite) -> str:
    """Return the digest of all that the figures of a suite depend on: code, scenarios, what it says of its cases."""
    modules = [*(f"benchmarks.cases.{table['from'].partition(':')[0]}" for table in suite.cases), *suite.modules]
    folders = {SUITES.parent / name.split(".")[1] for name in modules if name.startswith("benchmarks.")}
    data = [file for folder in folders for end in ("toml", "xml", "c", "ld") for file in folder.rglob(f"*.{end}")]
    return fingerprint(modules, [*SCENARIOS.rglob("scenarios/*"), *data], repr(suite.cases))


def run_case(case: Case, controllers: list[str]) -> Found:
    """Run controllers on a case; of one that cannot be run, say why."""
    try:
        return case.run(controllers)
    except (ArithmeticError, ValueError, SubprocessError) as error:
        return {"": {"refused": str(error)}, **{name: {} for name in controllers}}


def gathered(
    cases: dict[str, Case], found: dict[str, Found], names: dict[str, str]
) -> tuple[dict[str, Row], dict[str, str]]:
    """Return rows with a column a figure, and the cases that were refused."""
    rows: dict[str, Row] = {}
    refused = {key: one[""]["refused"] for key, one in found.items() if "refused" in one[""]}
    for key, one in found.items():
        if key in refused:
            continue
        row = rows.setdefault(one[""]["row"], Row())
        row.seeds.append(cases[key].seed)
        for name, shown in names.items():
            columns = row.figures.setdefault(shown, {})
            for figure, value in one[name].items():
                if name == BASE and figure in _OF_PI_ALONE:
                    continue
                columns.setdefault(figure, []).extend(value if isinstance(value, list) else [value])
    return rows, refused


_OF_PI_ALONE = frozenset({"settled", "window", "start", "after", "torque_variation"})
"""Ratios to PI, which of PI itself are one."""


def tracked(
    row: str | Callable[[Any], str], make: Callable[[int], Any], draws: int, seed: int, controllers: list[str]
) -> Found:
    """Run controllers on a scenario that is made of a seed here; its row may depend on what was drawn."""
    from adaptive_ff.studies.tracking import track_scenario

    scenario = make(seed)
    found: Found = dict(track_scenario(scenario, controllers, draws=draws))
    return {"": {"row": row if isinstance(row, str) else row(scenario)}, **found}
