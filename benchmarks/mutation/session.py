"""Test runs in forked processes: one that notes which lines each test reaches, then one a mutant."""

import itertools
import json
import math
import os
import resource
import signal
import sys
import time
from collections import defaultdict
from collections.abc import Callable
from contextlib import suppress
from dataclasses import dataclass, field
from typing import Any

import pytest
from _pytest.runner import runtestprotocol

from adaptive_ff.studies.study import Store
from benchmarks.mutation.operators import Mutant, marked_code

SLOWEST = 2.0
"""Tests that take longer in plain Python, s of processor time, are run compiled alone, as all cases of the same."""

MOST = 10.0  # processor time of the tests that a mutant meets in plain Python at most, s

PATIENCE, GRACE = 3.0, 5.0
"""A mutant is given this many times the time that its tests take without it, and so many seconds."""

LONGEST = 1800.0  # processor time of the tests of a file at most, s

MARK = "_reached_by_tests"

NO_ANSWER = "out of time"  # the answer of a process that was ended or died


class TooSlow(BaseException):
    """A test takes too long."""


@dataclass
class Noted:
    """What is known of a test in plain Python."""

    seconds: float  # how long it takes
    passed: bool  # whether it passes, and in time
    reached: list[int]  # the mutants whose line it reaches


@dataclass
class Mutation:
    """A plug-in of pytest that runs the collected tests once a mutant."""

    mutants: dict[int, Mutant]  # what is tried, by number
    waiting: list[int]  # those of them that have not been tried yet
    notes: Callable[[], Store]  # reads what each test reaches, by file and its digest
    digests: dict[str, str]  # of the files of tests
    workers: int  # number of processes
    # is called with the number of each mutant and the test that noticed it, or None
    found: Callable[[int, str | None], None]
    noted: dict[str, Noted] = field(default_factory=dict)  # what each test does in plain Python

    def pytest_runtestloop(self, session: pytest.Session) -> bool:
        """Run the tests without a fault, then those that reach a mutated line for each mutant."""
        if session.testsfailed:
            raise session.Interrupted(f"{session.testsfailed} files of tests cannot be collected")
        items = {item.nodeid: item for item in session.items}
        files: dict[str, list[pytest.Item]] = defaultdict(list)
        for item in session.items:
            files[item.nodeid.partition("::")[0]].append(item)
        notes = self.notes()
        unknown = [file for file in files if not notes.read(file, [self.digests[file]])]
        self._side_by_side(unknown, lambda file: self._add_notes(file, files[file]))
        notes = self.notes()
        kept = {file: notes.read(file, [self.digests[file]]) for file in files}
        if missing := [file for file, found in kept.items() if not found]:
            raise RuntimeError(f"tests without a mutant ended their process: {', '.join(missing)}")
        for found in kept.values():
            noted, modules = next(iter(found.values()))
            self.noted |= {name: Noted(*values) for name, values in noted.items()}
            for name in modules:  # once here, not in every fork
                if name not in sys.modules and not name.startswith("hypothesis"):
                    with suppress(Exception):
                        __import__(name)
        self._side_by_side(self.waiting, lambda number: self._find(number, items))
        return True

    def _side_by_side(self, every: list[Any], work: Callable[[Any], None]) -> None:
        """Call a function with each of a list, in processes that take turns."""
        children = []
        for place in range(self.workers):
            if (child := os.fork()) == 0:
                try:
                    for one in every[place :: self.workers]:
                        work(one)
                finally:
                    os._exit(0)  # whatever happened, a fork must not go on as its parent would
            children.append(child)
        for child in children:
            os.waitpid(child, 0)

    def _add_notes(self, file: str, items: list[pytest.Item]) -> None:
        answer = _in_fork(lambda: self._note(items), LONGEST)
        if answer != NO_ANSWER:
            self.notes().add(file, {self.digests[file]: answer})

    def _find(self, number: int, items: dict[str, pytest.Item]) -> None:
        chosen = self.quick_tests(number)
        limit = GRACE + PATIENCE * sum(self.noted[name].seconds for name in chosen)
        self.found(number, _in_fork(lambda: _try(self.mutants[number], [items[name] for name in chosen]), limit))

    def quick_tests(self, number: int) -> list[str]:
        """Return the tests that reach the line of a mutant in plain Python, the quickest first."""
        reaching = [name for name, one in self.noted.items() if one.passed and number in one.reached]
        reaching.sort(key=lambda name: self.noted[name].seconds)
        until = itertools.accumulate(self.noted[name].seconds for name in reaching)
        return [name for name, seconds in zip(reaching, until, strict=True) if seconds < MOST]

    def slow_tests(self, number: int) -> list[str]:
        """Return the other tests that reach it."""
        quick = set(self.quick_tests(number))
        return [name for name, one in self.noted.items() if number in one.reached and name not in quick]

    def _note(self, items: list[pytest.Item]) -> Any:
        """Return time, verdict and reached mutants of each test of a file, and the modules that were loaded."""
        reached: set[int] = set()
        of_function = defaultdict(dict)
        for number, mutant in self.mutants.items():
            of_function[mutant.function][number] = mutant
        for function, mutants in of_function.items():
            function.__globals__[MARK] = reached.add
            function.__code__ = marked_code(mutants, MARK)
        noted, slow = {}, {}
        for index, item in enumerate(items):
            case = item.nodeid.partition("[")[0]
            if case in slow:  # what its first case reached stands for this one, too
                noted[item.nodeid] = (SLOWEST, False, slow[case])
                continue
            reached.clear()
            start = time.process_time()
            passed = _passes(item, items[index + 1] if index + 1 < len(items) else None, SLOWEST)
            seconds = time.process_time() - start
            noted[item.nodeid] = (seconds, passed, sorted(reached))
            if seconds > SLOWEST:
                slow[case] = sorted(reached)
        return noted, sorted(sys.modules)


def _try(mutant: Mutant, items: list[pytest.Item]) -> str | None:
    mutant.function.__code__ = mutant.code()
    for index, item in enumerate(items):
        if not _passes(item, items[index + 1] if index + 1 < len(items) else None):
            return item.nodeid
    return None


def _passes(item: pytest.Item, following: pytest.Item | None, limit: float = 0.0) -> bool:
    """Run a test with its fixtures; tell whether nothing of it failed, within a limit of time (s) if there is one."""
    signal.signal(signal.SIGPROF, _too_slow)
    signal.setitimer(signal.ITIMER_PROF, limit, limit)  # again, where something swallows the first
    try:
        reports = runtestprotocol(item, log=False, nextitem=following)
    except BaseException:  # it may come in the middle of a report as well
        signal.setitimer(signal.ITIMER_PROF, 0.0)
        with suppress(BaseException):
            item.session._setupstate.teardown_exact(None)
        return False
    finally:
        signal.setitimer(signal.ITIMER_PROF, 0.0)
    failed = any(report.failed for report in reports)
    if failed:  # a fixture that was interrupted on the way would fail every test that follows
        for fixture in (one for each in item._fixtureinfo.name2fixturedefs.values() for one in each):
            if fixture.cached_result is None:
                fixture._finalizers.clear()
    return not failed


def _too_slow(*_: Any) -> None:
    raise TooSlow


def _in_fork(work: Callable[[], Any], limit: float) -> Any:
    """Return what a function returns in a process of its own; where that takes too much time (s) or dies, say so."""
    reading, writing = os.pipe()
    child = os.fork()
    if child == 0:
        os.close(reading)
        resource.setrlimit(resource.RLIMIT_CPU, (math.ceil(limit), math.ceil(limit) + 1))
        try:
            with os.fdopen(writing, "w") as pipe:
                pipe.write(json.dumps(work()))
        finally:
            os._exit(0)  # whatever happened, a fork must not go on as its parent would
    os.close(writing)
    with os.fdopen(reading) as pipe:
        text = pipe.read()
    os.waitpid(child, 0)
    return json.loads(text) if text else NO_ANSWER
