"""A stored result as the baseline of a regression gate: reading it, and whether it is of the same scenario."""

import json
import math
from collections.abc import Iterable, Iterator, Mapping
from pathlib import Path, PureWindowsPath
from typing import Any

from adaptive_ff.errors import InputError, checked_path, read_text
from adaptive_ff.scenario.scenario import Scenario
from adaptive_ff.simulation.metrics import METRIC_UNITS, POSITION_UNITS

GATED = (*METRIC_UNITS, *POSITION_UNITS)
"""Figures of merit that may not get worse, as far as a run has them; smaller is better for all of them."""

NOT_COMPARED = ("controllers", "sweep")
"""Fields of a scenario that do not change the run of a controller."""

ACROSS = {"gains": "feedback"}
"""What a baseline may differ in on demand, and the table of the scenario that says it."""

MOST_SHOWN = 6
"""Most differing fields that a message names."""


def read_baseline(path: str | Path) -> dict[str, Any]:
    """Read a result that ``adaptive-ff compare --json`` wrote.

    Raises
    ------
    InputError
        The file cannot be read or is no such result.
    TypeError
        The path is none.
    """
    text = read_text(checked_path("path", path), "is not valid JSON")
    try:
        content = json.loads(text)
    except (ValueError, RecursionError) as error:
        raise InputError(f"{path}: is not valid JSON: {error}") from error
    if not isinstance(content, dict):
        content = {}
    for part in ("controllers", "scenario"):
        if not content.get(part) or not isinstance(content[part], dict):
            raise InputError(f"{path}: {part} is missing; the file must be a result of 'adaptive-ff compare --json'")
    for name, figures in content["controllers"].items():
        figures = figures if isinstance(figures, dict) else {}
        for figure in (*METRIC_UNITS, *(POSITION_UNITS.keys() & figures)):
            value = figures.get(figure)
            if isinstance(value, bool) or not isinstance(value, int | float) or not math.isfinite(value) or value < 0.0:
                raise InputError(
                    f"{path}: controllers.{name}.{figure} = {value!r} is not allowed: it must be a finite number >= 0"
                )
    return content


def scenario_differences(scenario: Scenario, baseline: Mapping[str, Any], across: Iterable[str] = ()) -> list[str]:
    """Return in which fields the scenario of a baseline differs from a scenario, a phrase each.

    A field that the baseline does not have, because an earlier version wrote it, counts as its default. Of the path of
    a recorded reference only the name of the file counts, so that a baseline may move between machines. What is named
    in ``across``, of :data:`ACROSS`, may differ.
    """
    for name in across:
        if name not in ACROSS:
            raise InputError(f"across = {name!r} is not known; there are {', '.join(ACROSS)}")
    ignored = (*NOT_COMPARED, *(ACROSS[name] for name in across))
    there = dict(_leaves(baseline["scenario"]))
    here = dict(_leaves(scenario.model_dump(mode="json", exclude_none=True)))
    chosen = dict(_leaves(scenario.model_dump(mode="json", exclude_none=True, exclude_defaults=True)))
    found = []
    for name in dict.fromkeys([*here, *there]):
        if name.partition(".")[0] in ignored or (name not in there and name not in chosen):
            continue
        old, new = there.get(name), here.get(name)
        if name == "reference.path" and isinstance(old, str) and isinstance(new, str):
            old, new = PureWindowsPath(old).name, PureWindowsPath(new).name  # which takes the paths of any system
        if old != new:
            found.append(f"{name} is {_shown(old)} there and {_shown(new)} here")
    return found


def check_same_scenario(scenario: Scenario, baseline: Mapping[str, Any], name: str, across: Iterable[str] = ()) -> None:
    """Refuse a baseline (called ``name``) of another scenario but for what may differ; the message names the fields."""
    found = scenario_differences(scenario, baseline, across)
    if found:
        gains = all(one.startswith(f"{ACROSS['gains']}.") for one in found)
        more = f" and {len(found) - MOST_SHOWN} more fields differ" if len(found) > MOST_SHOWN else ""
        raise InputError(
            f"{name}: is of another scenario: {'; '.join(found[:MOST_SHOWN])}{more}; run the scenario that it was "
            f"made with, or make a new baseline{', or compare across gains (--across gains)' if gains else ''}"
        )


def _leaves(value: Any, path: str = "") -> Iterator[tuple[str, Any]]:
    """Yield the values of nested tables, each with its path such as ``change.0.time``; lists of numbers as a whole."""
    if isinstance(value, Mapping):
        pairs = list(value.items())
    elif isinstance(value, list) and any(isinstance(item, Mapping) for item in value):
        pairs = list(enumerate(value))
    else:
        yield path, value
        return
    for key, item in pairs:
        yield from _leaves(item, f"{path}.{key}" if path else str(key))


def _shown(value: Any) -> str:
    if value is None:
        return "not given"
    text = json.dumps(value)
    return text if len(text) <= 60 else text[:57] + "..."
