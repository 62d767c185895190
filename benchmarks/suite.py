"""A suite: cases, controllers, figures and targets, read from ``benchmarks/suites/NAME.toml``."""

import importlib
import tomllib
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from fnmatch import fnmatchcase
from functools import partial
from pathlib import Path
from typing import Any, NamedTuple

from adaptive_ff.errors import InputError

SUITES = Path(__file__).resolve().parent / "suites"  # where the files of the suites are

SCENARIOS = Path(__file__).resolve().parent.parent / "adaptive_ff"
"""Where scenario files lie, which every fingerprint covers."""

FIELDS = {"title", "cases", "controllers", "outside", "targets", "views", "modules"}


class Case(NamedTuple):
    """What is run at a time."""

    key: str  # unique in the suite
    seed: int  # seed of the reference, or number of the draw
    # runs controllers by name; returns figures by controller, each a number or one a joint, and under ``""`` the name
    # of the row that the case belongs to, as ``{"row": name}``
    run: Callable[[list[str]], dict[str, Any]]


Rows = Mapping[str, tuple[Any, ...]]  # arguments of what runs a row, by the name of the row

Generator = Callable[..., list[Case]]
"""Returns cases for a ``count`` of seeds from the ``first`` on, and more arguments."""


def seeded(
    run: Callable[..., dict[str, Any]], rows: Rows | Callable[..., Rows], *, first: int = 1, pooled: bool = False
) -> Generator:
    """Return a generator of a case for each row and seed: ``run(*row, seed, controllers)``."""

    def generate(count: int = 1, first: int = first, **given: Any) -> list[Case]:
        listed, seeds = rows(**given) if callable(rows) else rows, list(range(first, first + count))
        if pooled:
            return [Case(name, first, partial(run, *row, seeds)) for name, row in listed.items()]
        return [
            Case(f"{name}/{seed}", seed, partial(run, *row, seed)) for name, row in listed.items() for seed in seeds
        ]

    return generate


# of a case for each row, of all seeds together: ``run(*row, seeds, controllers)``
pooled = partial(seeded, pooled=True)


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
            chosen = {"count": 1 if quick else count, "first": first}
            arguments = table | {name: value for name, value in chosen.items() if value is not None}
            module, _, function = arguments.pop("from").partition(":")
            found += getattr(importlib.import_module(f"benchmarks.cases.{module}"), function)(**arguments)
        return found

    def is_outside(self, row: str) -> bool:
        """Return whether a row is outside the contract."""
        return any(fnmatchcase(row, pattern) for pattern in self.outside)


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
