"""``python -m benchmarks.mutation``: how many small faults the tests notice.

Of all small faults (``operators``) of the functions of some rooms a sample is drawn. Each is put first into a fork of a
process that has collected the tests of these rooms, where all functions run as plain Python and the tests that reach
its line run, the quickest first; what survives is put into a copy of the tree, where kernels are compiled, for the
figures of ``tests/test_figures.py``, the tests that take long in plain Python and those of its room that import its
file. A mutant with which tests do not end counts as noticed. Verdicts are kept as they come: one of a test that noticed
a mutant while its file is the same, one of a survivor while all tests are.
"""

import fcntl
import importlib
import os
import tempfile
import time
from collections import Counter
from collections.abc import Iterator
from concurrent.futures import ThreadPoolExecutor
from functools import cache, partial
from pathlib import Path
from types import FunctionType
from typing import Annotated, Any
from unittest.mock import patch

# before numpy is loaded; a fork must not find threads waited for that it does not have
os.environ |= {"ADAPTIVE_FF_COMPILE": "0", "OPENBLAS_NUM_THREADS": "1", "OMP_NUM_THREADS": "1"}

import numpy as np
import pytest
import typer
from hypothesis import Phase, settings

from adaptive_ff.comparison.registry import CONTROLLERS
from adaptive_ff.studies.study import Store
from benchmarks.fingerprint import fingerprint
from benchmarks.mutation.compiled import ROOT, Copy
from benchmarks.mutation.operators import EQUIVALENT, Mutant, mutants
from benchmarks.mutation.session import Mutation
from benchmarks.running import KEPT

ROOMS = ("controllers", "plant", "friction", "learning", "adaptive", "identify", "simulation")  # what is mutated

TESTS = (
    "test_figures.py",
    "test_refused_arguments.py",
    "controllers",
    "plant",
    *(f"adaptive_ff/{room}" for room in (*ROOMS[2:], "baselines", "comparison", "replay")),
)
"""Files and folders of the tests that are run."""

OBSERVERS = ("disturbance_observer", "extended_state", "kalman_disturbance", "super_twisting")
LINE_UP = ("pi", "oracle", "adaptive", "adaptive_paper", *OBSERVERS)
"""Controllers that the tests find in plain Python; others are identified or tuned in many runs before they are made."""

OPTIONS = ("-n", "0", "-q", "-p", "no:cacheprovider", "--assert=plain", "--hypothesis-profile", "mutation")

PHASES = (Phase.explicit, Phase.generate)  # what hypothesis does; a failure need not be made small here


def room_of(name: str) -> str:
    """Return the room of a function by its full name."""
    return name.removeprefix("adaptive_ff.").partition(".")[0]


def functions() -> dict[str, FunctionType]:
    """Return the functions and methods of the rooms by their full names."""
    folders = [ROOT / ("" if room in ("controllers", "plant") else "adaptive_ff") / room for room in ROOMS]
    found = {}
    for file in sorted(file for folder in folders for file in folder.rglob("*.py") if file.stem != "__init__"):
        module = importlib.import_module(".".join(file.relative_to(ROOT).with_suffix("").parts))
        for function in _functions_in(module, module.__name__):
            if function.__code__.co_filename == str(file) and not function.__code__.co_freevars:
                found[f"{module.__name__}.{function.__qualname__}"] = function
    return {name: function for name, function in found.items() if "<" not in name}


def _functions_in(owner: Any, module: str) -> Iterator[FunctionType]:
    for value in vars(owner).values():
        for one in (value, *(getattr(value, name, None) for name in ("fget", "func", "__func__", "__wrapped__"))):
            if isinstance(one, FunctionType) and one.__module__ == module:
                yield one
        if isinstance(value, type) and value.__module__ == module and value is not owner:
            yield from _functions_in(value, module)


def drawn(found: list[Mutant], count: int, seed: int) -> dict[int, Mutant]:
    """Return a sample of mutants that are not equivalent, in the order in which they are drawn."""
    order = (found[place] for place in np.random.default_rng(seed).permutation(len(found)))
    chosen = (mutant for mutant in order if mutant.before != mutant.after and mutant.key not in EQUIVALENT)
    return {number: mutant for number, mutant in zip(range(count), chosen, strict=False)}


class Verdicts:
    """Verdicts of mutants, kept as they come: the test that noticed each, or None, by stage."""

    def __init__(self, file: Path, mark: str, sample: dict[int, Mutant]) -> None:
        self.sample, self._file, self._mark = sample, file, mark
        self.read()

    def read(self) -> None:
        """Read what is kept, by processes beside this one as well."""
        self._store = Store(self._file, self._mark)
        every = digests()
        self.found: dict[str, dict[int, str | None]] = {stage: {} for stage in STAGES}
        for number, mutant in self.sample.items():
            for stage, one in self._store.read(str(mutant.key), STAGES).items():
                if one["digest"] == digest_of(one["test"], every):
                    self.found[stage][number] = one["test"]

    def add(self, stage: str, number: int, test: str | None) -> None:
        """Keep a verdict."""
        mutant = self.sample[number]
        self.found[stage][number] = test
        self._store.add(str(mutant.key), {stage: {"test": test, "digest": digest_of(test, digests())}})
        print(f"{stage} {number}, {mutant.name}: {test}", file=PROGRESS, flush=True)

    def killed(self, number: int) -> bool:
        """Tell whether a test noticed a mutant."""
        return any(found.get(number) is not None for found in self.found.values())

    def left(self, stage: str) -> list[int]:
        """Return the mutants that no test noticed and that have not been tried in a stage."""
        return [number for number in self.sample if not self.killed(number) and number not in self.found[stage]]


@cache
def digests() -> dict[str, str]:
    """Return the digest of each file of tests, with all that it has in common with others."""
    files = sorted((ROOT / "tests").rglob("*.py"))
    common = [file for file in files if not file.name.startswith("test_")]
    return {str(file.relative_to(ROOT)): fingerprint([], [file, *common]) for file in files if file not in common}


def digest_of(test: str | None, every: dict[str, str]) -> str:
    """Return the digest of the file of a test; of all files where no single test has noticed a mutant."""
    return every.get((test or "").partition("::")[0], fingerprint([], text=str(every)))


STAGES = ("plain", "compiled")
PROGRESS = os.fdopen(os.dup(2), "w")  # where progress is written; pytest captures the other, and forks close it


def run(count: int, seed: int, workers: int) -> Verdicts:
    """Draw mutants and try those that have not been tried; another call waits for this one."""
    KEPT.mkdir(parents=True, exist_ok=True)
    with (KEPT / "mutants.lock").open("w") as lock:
        fcntl.flock(lock, fcntl.LOCK_EX)
        every = functions()
        sample = drawn([one for name, function in every.items() for one in mutants(name, function)], count, seed)
        mark = fingerprint({function.__module__ for function in every.values()})
        tried = fingerprint([], text=str([mutant.key for mutant in sample.values()]))
        verdicts = Verdicts(KEPT / "mutants.jsonl", mark, sample)
        notes = partial(Store, KEPT / "tests.jsonl", f"{mark}-{tried}")
        session = Mutation(sample, verdicts.left("plain"), notes, digests(), workers, partial(verdicts.add, "plain"))
        settings.register_profile("mutation", deadline=None, derandomize=True, database=None, phases=PHASES)
        if session.waiting or verdicts.left("compiled"):
            with patch.dict(CONTROLLERS, {name: CONTROLLERS[name] for name in LINE_UP}, clear=True):
                status = pytest.main([*OPTIONS, *(str(ROOT / "tests" / name) for name in TESTS)], [session])
            verdicts.read()
            if status != pytest.ExitCode.OK or verdicts.left("plain"):
                raise typer.Exit(1)
            parts = [verdicts.left("compiled")[place::workers] for place in range(workers)]
            with ThreadPoolExecutor(workers) as pool:
                list(pool.map(lambda part: in_copy(verdicts, session, part), parts))
        return verdicts


def in_copy(verdicts: Verdicts, session: Mutation, numbers: list[int]) -> None:
    """Try mutants in a copy of the tree, where kernels are compiled."""
    with tempfile.TemporaryDirectory() as folder:
        copy = Copy(Path(folder))
        for number in numbers:
            tests = session.slow_tests(number)
            verdicts.add("compiled", number, copy.noticed_by(verdicts.sample[number], tests))


def main(
    count: Annotated[int, typer.Option(min=1, help="Number of mutants that are drawn.")] = 300,
    seed: Annotated[int, typer.Option(help="Seed of the draw.")] = 8,
    workers: Annotated[int, typer.Option(min=1, help="Number of processes.")] = 2,
) -> None:
    """Print which mutants survive, and how many of each room."""
    start = time.monotonic()
    verdicts = run(count, seed, workers)
    left = {number: mutant for number, mutant in verdicts.sample.items() if not verdicts.killed(number)}
    for key, reason in EQUIVALENT.items():
        print(f"equivalent: {key[0]}: {key[1]}  ->  {key[2]}: {reason}")
    for mutant in sorted(left.values(), key=lambda mutant: mutant.name):
        print(f"survives: {mutant.name}:{mutant.line}: {mutant.before}  ->  {mutant.after}")
    every, survivors = (Counter(room_of(one.name) for one in some.values()) for some in (verdicts.sample, left))
    for room in ROOMS:
        print(f"{room}: {every[room]} drawn, {survivors[room]} survive")
    print(f"{len(left)} of {len(verdicts.sample)} mutants survive; {time.monotonic() - start:.0f} s")


if __name__ == "__main__":
    typer.run(main)
