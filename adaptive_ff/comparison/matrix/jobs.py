"""The matrix as a set of jobs on all cores or a cluster, each kept in a file as soon as it is done."""

import json
from collections.abc import Callable, Iterator, Mapping
from concurrent.futures import Executor, as_completed
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from adaptive_ff.comparison.kept import mark_of, own_mark, source_digest
from adaptive_ff.comparison.matrix.cells import SCENARIOS, Figures, run_cell
from adaptive_ff.comparison.own import Own, can_be_sent, check_own_names
from adaptive_ff.comparison.reference_lines import NOISE_FLOOR
from adaptive_ff.comparison.registry import CONTROLLERS
from adaptive_ff.files import write_result
from adaptive_ff.workers import pool_of_workers


@dataclass(frozen=True)
class Job:
    """A scenario with a seed, and with the fastest PI loop or its own.

    Attributes
    ----------
    scenario : str
        Name of the scenario.
    seed : int
        Seed.
    fastest : bool
        Whether the PI loop is the fastest that margin and noise allow.
    """

    scenario: str
    seed: int
    fastest: bool

    def file(self, folder: Path) -> Path:
        """Return where the job's result is kept."""
        loop = "fastest" if self.fastest else "own"
        return folder / "runs" / self.scenario / f"{loop}-{self.seed}.json"


Results = dict[Job, dict[str, Figures]]


def run_matrix(
    jobs: list[Job],
    controllers: list[str],
    folder: Path,
    *,
    own: Mapping[str, Own] | None = None,
    executor: Executor | None = None,
    progress: Callable[[float], None] | None = None,
) -> Results:
    """Run the jobs; those whose result is kept from an earlier call are not run again.

    The result of a controller is kept with the state of the sources and of the scenario, and used again only where both
    are the same.

    Parameters
    ----------
    jobs : list of Job
        What to run.
    controllers : list of str
        Names of the controllers.
    folder : Path
        Where results are kept.
    own : mapping, optional
        Own controllers by name, run beside those; see :func:`adaptive_ff.comparison.own.make_own`. Results are kept of
        those that are given as ``FILE.py:NAME``, until that file changes.
    executor : concurrent.futures.Executor, optional
        Where the runs go, such as that of a Dask client; by default processes on all cores.
    progress : callable, optional
        Is called with the share done, from 0 to 1.
    """
    own = own or {}
    check_own_names(own, {**CONTROLLERS, NOISE_FLOOR: None})
    sources = source_digest()
    own_marks = {name: own_mark(one) for name, one in own.items()}
    results: Results = {job: {} for job in jobs}
    missing: dict[Job, list[str]] = {}
    marks = {}
    for job in jobs:
        marks[job] = {name: _mark(job, sources, own_marks.get(name, "")) for name in (*controllers, *own)}
        kept = _read(job.file(folder))
        for name, mark in marks[job].items():
            if mark and kept.get(name, {}).get("mark") == mark:
                results[job][name] = kept[name]["figures"]
        wanted = [name for name in marks[job] if name not in results[job]]
        if wanted:
            missing[job] = wanted
    for count, (job, found) in enumerate(_run(missing, own, executor), start=len(jobs) - len(missing) + 1):
        results[job] |= found
        file = job.file(folder)
        fresh = {name: {"mark": marks[job][name], "figures": figures} for name, figures in found.items()}
        write_result(file, {"controllers": {**_read(file), **fresh}})
        if progress is not None:
            progress(count / len(jobs))
    return {job: {name: results[job][name] for name in marks[job]} for job in jobs}


def _run(
    jobs: Mapping[Job, list[str]], own: Mapping[str, Own], executor: Executor | None
) -> Iterator[tuple[Job, dict[str, Figures]]]:
    if not jobs:
        return
    (first, names), *others = jobs.items()  # the first one here, so that workers find the controllers compiled
    yield first, run_job(first, names, own)
    if executor is None and not can_be_sent(own):
        for job, names in others:
            yield job, run_job(job, names, own)
        return
    pool = pool_of_workers() if executor is None else executor
    try:
        futures = {pool.submit(run_job, job, names, own): job for job, names in others}
        for done in as_completed(futures):
            yield futures[done], done.result()
    finally:
        if executor is None:
            pool.shutdown(cancel_futures=True)


def run_job(job: Job, controllers: list[str], own: Mapping[str, Own]) -> dict[str, Figures]:
    """Run controllers of one job."""
    return run_cell(job.scenario, job.seed, job.fastest, controllers, own)


def _read(file: Path) -> dict[str, Any]:
    """Return what is kept of a job by controller; nothing where the file is missing or damaged."""
    try:
        content = json.loads(file.read_text(encoding="utf-8"))
    except (OSError, ValueError):
        return {}
    kept = content.get("controllers") if isinstance(content, dict) else None
    return {name: one for name, one in kept.items() if isinstance(one, dict)} if isinstance(kept, dict) else {}


def _mark(job: Job, sources: bytes, own: str | None) -> str:
    """Return what a result depends on as a short text; empty for one that cannot be kept."""
    if own is None:
        return ""
    files = (SCENARIOS / f"{job.scenario}{ending}" for ending in (".toml", ".csv"))  # a recorded reference beside it
    return mark_of(sources, *(file.read_bytes() for file in files if file.is_file()), own.encode())
