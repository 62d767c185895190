"""The engine of every study: a function over cases x controllers, on all cores or a cluster, kept as it goes."""

import hashlib
import json
from collections.abc import Callable, Collection, Iterable, Mapping
from concurrent.futures import Executor, as_completed
from contextlib import suppress
from functools import cache
from pathlib import Path
from typing import Any

from adaptive_ff.errors import InputError
from adaptive_ff.workers import Threads, pool_of_workers
from controllers.compiled import compiles

Found = dict[str, Any]  # result of a case by controller, as JSON holds it
Function = Callable[[Any, list[str]], Found]  # results under further names belong to the case as a whole


def run_study(
    function: Function,
    cases: Mapping[str, Any],
    controllers: Collection[str],
    *,
    store: "Store | None" = None,
    executor: Executor | None = None,
    workers: int | None = None,
    threads: bool = False,
    progress: Callable[[float], None] | None = None,
) -> dict[str, Found]:
    """Run controllers on cases, here or by an executor such as that of a cluster; results by case and controller.

    Workers are ``threads`` for a function that is compiled for most of its time, where there is a compiler, else
    processes, to which function and cases must be picklable. The keys of the cases are unique and stay the same from
    one call to the next: what the store holds is not run again. One worker is this process.
    """
    results: dict[str, Found] = {key: {} if store is None else store.read(key, controllers) for key in cases}
    missing = {key: [name for name in controllers if name not in found] for key, found in results.items()}
    missing = {key: names for key, names in missing.items() if names}
    done = len(cases) - len(missing)

    def add(key: str, found: Found) -> None:
        nonlocal done
        results[key] |= found
        if store is not None:
            store.add(key, found)
        done += 1
        if progress is not None:
            progress(done / len(cases))

    alone = 1 if executor is not None or workers != 1 else len(missing)  # the first, so that others find it compiled
    for key in list(missing)[:alone]:
        add(key, function(cases[key], missing[key]))
    others = list(missing)[alone:]
    if not others:
        return results
    made = Threads if threads and compiles() else pool_of_workers
    pool = made(workers) if executor is None else executor
    try:
        futures = {pool.submit(function, cases[key], missing[key]): key for key in others}
        for future in as_completed(futures):
            add(futures[future], future.result())
    finally:
        if executor is None:
            pool.shutdown(cancel_futures=True)
    return results


def digest_of(files: Iterable[Path]) -> str:
    """Return the digest of some files."""
    digest = hashlib.sha256()
    for file in sorted(files):
        digest.update(file.name.encode() + file.read_bytes())
    return digest.hexdigest()[:16]


@cache
def code_digest() -> str:
    """Return the digest of the code of this package and of those that it stands on."""
    root = Path(__file__).resolve().parents[2]
    return digest_of(file for name in ("adaptive_ff", "plant", "controllers") for file in (root / name).rglob("*.py"))


class Store:
    """Results in a file, a line each, added as they come.

    A line counts only where its mark is that of the call: what all results depend on, such as the digest of the code,
    and with it those of a single controller (``marks``); None for one that is not kept, since it is a living object
    that may be another the next time. A line that a power cut has cut short does not count.
    """

    def __init__(self, file: Path, mark: str, marks: Mapping[str, str | None] | None = None) -> None:
        self._file, self._mark, self._marks = file, mark, dict(marks or {})
        self._kept: dict[str, Found] = {}
        lines: list[str] = []
        with suppress(OSError, UnicodeDecodeError):
            lines = file.read_text(encoding="utf-8").splitlines()
        for line in lines:
            with suppress(ValueError, TypeError):
                key, name, mark, found = json.loads(line)
                if mark == self._mark_of(name):
                    self._kept.setdefault(key, {})[name] = found

    def read(self, key: str, controllers: Collection[str]) -> Found:
        """Return what is kept of a case: results of the controllers, and what belongs to the case as a whole."""
        kept = self._kept.get(key, {})
        return {name: found for name, found in kept.items() if name in controllers or not name}

    def add(self, key: str, found: Found) -> None:
        """Add results of a case."""
        marked = {name: self._mark_of(name) for name in found}
        lines = [json.dumps([key, name, marked[name], one]) for name, one in found.items() if marked[name] is not None]
        try:
            self._file.parent.mkdir(parents=True, exist_ok=True)
            with self._file.open("a", encoding="utf-8") as stream:
                stream.write("".join(f"{line}\n" for line in lines))
        except OSError as error:
            raise InputError(f"{self._file}: cannot be written: {error.strerror or error}") from error

    def _mark_of(self, name: str) -> str | None:
        own = self._marks.get(name, "")
        return None if own is None else f"{self._mark}{own}"
