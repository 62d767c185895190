"""A suite: cases, controllers, figures and targets, read from ``benchmarks/suites/NAME.toml``."""

import importlib
import tomllib
from collections.abc import Callable, Iterable
from dataclasses import dataclass, field
from fnmatch import fnmatchcase
from functools import partial
from pathlib import Path
from typing import Any, NamedTuple

from adaptive_ff.errors import InputError

SUITES = Path(__file__).resolve().parent / "suites"  # where the files of the suites are

SCENARIOS = Path(__file__).resolve().parent.parent / "adaptive_ff"
"""Where scenario files lie, which every fingerprint covers."""

COUNT = "count"  # argument of a generator for the number of its references or draws; ``first`` is the seed of the first

FIELDS = {"title", "cases", "controllers", "outside", "targets", "views", "modules"}


class Case(NamedTuple):
    """What is run at a time."""

    key: str  # unique in the suite
    seed: int  # seed of the reference, or number of the draw
    # runs controllers by name; returns figures by controller, each a number or one a joint, and under ``""`` the name
    # of the row that the case belongs to, as ``{"row": name}``
    run: Callable[[list[str]], dict[str, Any]]


def seeded(
    run: Callable[..., dict[str, Any]], rows: Iterable[tuple[str, tuple[Any, ...]]], count: int, first: int
) -> list[Case]:
    """Return cases of a function of a row's arguments and a seed, for so many seeds a row, by the name of the row."""
    seeds = range(first, first + count)
    return [Case(f"{name}/{seed}", seed, partial(run, *row, seed)) for name, row in rows for seed in seeds]


@dataclass(frozen=True)
class Suite:
    """Cases, controllers and targets of a benchmark."""

    name: str  # name, title: name of its file, and what it asks, in a line
    title: str
    # generators of cases: ``from`` names module and function in ``benchmarks.cases`` (``"drawn:machines"``), the rest
    # are its arguments
    cases: list[dict[str, Any]]
    controllers: list[str] = field(default_factory=list)  # names of the controllers
    # patterns of the rows that are outside the contract of the adaptive controller; ``"*"`` for all
    outside: list[str] = field(default_factory=list)
    # targets by pattern of the row: ``figure.statistic`` to the limit, see :mod:`benchmarks.quantities`
    targets: dict[str, dict[str, float]] = field(default_factory=dict)
    views: dict[str, dict[str, Any]] = field(default_factory=dict)  # tables by name, see :mod:`benchmarks.pages`
    modules: list[str] = field(default_factory=list)  # further modules that the result depends on

    def generated(self, *, count: int | None = None, first: int | None = None, quick: bool = False) -> list[Case]:
        """Return the cases, with another count or first seed where one is given; one of each kind where it is quick."""
        found: list[Case] = []
        for table in self.cases:
            arguments = {name: value for name, value in table.items() if name != "from"}
            if quick or count is not None:
                arguments[COUNT] = 1 if quick else count
            if first is not None:
                arguments["first"] = first
            found += self._generator(table["from"])(**arguments)
        return found

    def is_outside(self, row: str) -> bool:
        """Return whether a row is outside the contract."""
        return any(fnmatchcase(row, pattern) for pattern in self.outside)

    @property
    def code(self) -> list[str]:
        """Modules that the figures come from, without what they import."""
        generators = [f"benchmarks.cases.{table['from'].partition(':')[0]}" for table in self.cases]
        return sorted({*generators, *self.modules})

    @staticmethod
    def _generator(name: str) -> Callable[..., list[Case]]:
        module, _, function = name.partition(":")
        found: Callable[..., list[Case]] = getattr(importlib.import_module(f"benchmarks.cases.{module}"), function)
        return found


def suite_names() -> list[str]:
    """Return the names of all suites."""
    return sorted(file.stem for file in SUITES.glob("*.toml"))


def load_suite(name: str) -> Suite:
    """Return a suite."""
    if name not in suite_names():
        raise InputError(f"suite = {name!r} is not known; there are {', '.join(suite_names())}")
    table = tomllib.loads((SUITES / f"{name}.toml").read_text(encoding="utf-8"))
    if unknown := sorted(set(table) - FIELDS):
        raise InputError(f"{name}.toml: {unknown[0]} is not known; there are {', '.join(sorted(FIELDS))}")
    return Suite(name, **table)
