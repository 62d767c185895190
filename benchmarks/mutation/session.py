"""Test runs in forked processes: one that times the tests and notes which kernels they call, then one a mutant."""

import ast
import json
import math
import os
import resource
import signal
import sys
import time
from collections.abc import Callable
from contextlib import suppress
from dataclasses import dataclass, field
from types import FunctionType
from typing import Any

import pytest
from _pytest.runner import runtestprotocol

from benchmarks.mutation.operators import Mutant, compiled_code, syntax

SLOWEST = 2.0
"""Tests that take longer, s of processor time, are left out, with all other cases of the same test."""

MOST = 10.0
"""Processor time of all tests that a mutant meets at most, s."""

PATIENCE, GRACE = 3.0, 5.0
"""A mutant is given this many times the time that its tests take without it, and so many seconds."""

LONGEST = 3600.0
"""Processor time of all tests together at most, s."""

CALLED = "_called_by_tests"

NO_ANSWER = "out of time"
"""What is told of a process that was ended or died."""


class TooSlow(BaseException):
    """A test takes too long."""


@dataclass
class Noted:
    """What is known of a test.

    Attributes
    ----------
    seconds : float
        How long it takes.
    passed : bool
        Whether it passes with plain kernels.
    kernels : list of str
        The kernels that it calls.
    """

    seconds: float
    passed: bool
    kernels: list[str]


@dataclass
class Mutation:
    """A plug-in of pytest that runs the collected tests once a mutant.

    Attributes
    ----------
    kernels : dict
        Functions by their full name.
    mutants : list of Mutant
        What is tried.
    tell : callable
        Is called with a line for each mutant.
    killed : dict
        For each mutant that was noticed, by its place in the list, the test that noticed it.
    noted : dict of Noted
        What each test does with plain kernels.
    """

    kernels: dict[str, FunctionType]
    mutants: list[Mutant]
    tell: Callable[[str], None]
    killed: dict[int, str] = field(default_factory=dict)
    noted: dict[str, Noted] = field(default_factory=dict)

    def pytest_runtestloop(self, session: pytest.Session) -> bool:
        """Run the tests without a fault, then those that call a mutated kernel for each mutant."""
        if session.testsfailed:
            raise session.Interrupted(f"{session.testsfailed} files of tests cannot be collected")
        items = {item.nodeid: item for item in session.items}
        answer = _in_fork(lambda: self._note(items), LONGEST)
        if answer == NO_ANSWER:
            raise RuntimeError("the tests without a mutant ended their process")
        noted, modules = answer
        for name in modules:  # once here, not in every fork
            if name not in sys.modules and not name.startswith("hypothesis"):
                _import_quietly(name)
        self.noted = {name: Noted(*values) for name, values in noted.items()}
        for place, mutant in enumerate(self.mutants):
            chosen = self._tests_of(mutant)
            limit = GRACE + PATIENCE * sum(self.noted[name].seconds for name in chosen)
            found = _in_fork(lambda m=mutant, c=chosen: self._try(m, [items[name] for name in c]), limit)
            if found is not None:
                self.killed[place] = found
            self.tell(f"{'killed' if found is not None else 'SURVIVES'} {mutant.module}:{mutant.line}")
        return True

    def _tests_of(self, mutant: Mutant) -> list[str]:
        """Return the tests that call the kernel, the quickest first."""
        kernel = f"{mutant.module}.{mutant.function}"
        calling = [name for name, one in self.noted.items() if one.passed and kernel in one.kernels]
        chosen, left = [], MOST
        for name in sorted(calling, key=lambda name: self.noted[name].seconds):
            left -= self.noted[name].seconds
            if left > 0.0:
                chosen.append(name)
        return chosen

    def _try(self, mutant: Mutant, items: list[pytest.Item]) -> str | None:
        function = self.kernels[f"{mutant.module}.{mutant.function}"]
        function.__code__ = mutant.code(function)
        for index, item in enumerate(items):
            following = items[index + 1] if index + 1 < len(items) else None
            if not _passes(item, following):
                return item.nodeid
        return None

    def _note(self, items: dict[str, pytest.Item]) -> Any:
        """Return time, verdict and called kernels of each test, and the modules that were loaded."""
        called: set[str] = set()
        for name, function in self.kernels.items():
            tree = syntax(function)
            function.__globals__[CALLED] = called.add
            tree.body.insert(0, ast.parse(f"{CALLED}({name!r})").body[0])
            function.__code__ = compiled_code(tree, function)
        noted, listed, slow = {}, list(items.values()), set()
        for index, item in enumerate(listed):
            called.clear()
            case = item.nodeid.partition("[")[0]
            if case in slow:
                continue
            start = time.process_time()
            passed = _passes(item, listed[index + 1] if index + 1 < len(listed) else None, SLOWEST)
            noted[item.nodeid] = (time.process_time() - start, passed, sorted(called))
            if noted[item.nodeid][0] > SLOWEST:
                slow.add(case)
            self.tell(f"{noted[item.nodeid][0]:.3f} {passed} {item.nodeid}")
        return noted, sorted(sys.modules)


def _import_quietly(name: str) -> None:
    try:
        __import__(name)
    except Exception:
        return


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
    return not any(report.failed for report in reports)


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
