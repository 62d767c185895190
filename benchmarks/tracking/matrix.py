"""The matrix as a set of jobs on all cores or a cluster, each kept in a file as soon as it is done."""

import hashlib
import json
import os
from collections.abc import Callable, Iterator
from concurrent.futures import Executor, ProcessPoolExecutor, as_completed
from dataclasses import dataclass
from pathlib import Path

from adaptive_ff.report.files import write_json
from benchmarks.tracking.cells import SCENARIOS, Figures, run_cell

ROOT = Path(__file__).resolve().parent.parent.parent
SOURCES = ("adaptive_ff/**/*.py", "plant/**/*.py", "controllers/**/*.py", "benchmarks/tracking/cells.py")
"""What a result depends on, beside the scenario."""


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
    executor: Executor | None = None,
    progress: Callable[[float], None] | None = None,
) -> Results:
    """Run the jobs; those whose result is kept from an earlier call are not run again.

    A result is kept with the state of the sources and of the scenario, and used again only where both are the same.

    Parameters
    ----------
    jobs : list of Job
        What to run.
    controllers : list of str
        Names of the controllers.
    folder : Path
        Where results are kept.
    executor : concurrent.futures.Executor, optional
        Where the runs go, such as that of a Dask client; by default processes on all cores.
    progress : callable, optional
        Is called with the share done, from 0 to 1.
    """
    sources = _hash_sources()
    marks = {job: _mark(job, sources) for job in jobs}
    results: Results = {}
    for job in jobs:
        kept = _read(job.file(folder), marks[job])
        if kept is not None and all(name in kept for name in controllers):
            results[job] = {name: kept[name] for name in controllers}
    missing = [job for job in jobs if job not in results]
    for count, (job, found) in enumerate(_run(missing, controllers, executor), start=len(results) + 1):
        results[job] = found
        file = job.file(folder)
        file.parent.mkdir(parents=True, exist_ok=True)
        write_json(file, {"mark": marks[job], "controllers": found})
        if progress is not None:
            progress(count / len(jobs))
    return {job: results[job] for job in jobs}


def _run(
    jobs: list[Job], controllers: list[str], executor: Executor | None
) -> Iterator[tuple[Job, dict[str, Figures]]]:
    if not jobs:
        return
    first, *others = jobs  # here, so that workers find the controllers compiled
    yield first, run_job(first, controllers)
    pool = ProcessPoolExecutor(os.cpu_count()) if executor is None else executor
    try:
        futures = {pool.submit(run_job, job, controllers): job for job in others}
        for done in as_completed(futures):
            yield futures[done], done.result()
    finally:
        if executor is None:
            pool.shutdown(cancel_futures=True)


def run_job(job: Job, controllers: list[str]) -> dict[str, Figures]:
    """Run one job."""
    return run_cell(job.scenario, job.seed, job.fastest, controllers)


def _read(file: Path, mark: str) -> dict[str, Figures] | None:
    try:
        content = json.loads(file.read_text(encoding="utf-8"))
    except (OSError, ValueError):
        return None
    if not isinstance(content, dict) or content.get("mark") != mark:
        return None
    controllers: dict[str, Figures] = content["controllers"]
    return controllers


def _mark(job: Job, sources: bytes) -> str:
    files = (SCENARIOS / f"{job.scenario}{ending}" for ending in (".toml", ".csv"))  # a recorded reference beside it
    content = b"".join(file.read_bytes() for file in files if file.is_file())
    return hashlib.sha256(sources + content).hexdigest()[:16]


def _hash_sources() -> bytes:
    digest = hashlib.sha256()
    for pattern in SOURCES:
        for path in sorted(ROOT.glob(pattern)):
            digest.update(str(path.relative_to(ROOT)).encode())
            digest.update(path.read_bytes())
    return digest.digest()
