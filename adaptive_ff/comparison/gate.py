"""Regression gate: tracking must stay as good as in a stored result of the same scenario, the baseline."""

import json
import math
from collections.abc import Iterable, Iterator, Mapping
from pathlib import Path, PureWindowsPath
from typing import Any

import numpy as np
import scipy

from adaptive_ff.comparison.comparison import Comparison
from adaptive_ff.comparison.registry import CONTROLLERS
from adaptive_ff.errors import InputError, check_among, check_kind, checked_path, read_text
from adaptive_ff.scenario.axis_units import axis_unit
from adaptive_ff.scenario.scenario import Scenario
from adaptive_ff.simulation.metrics import METRIC_UNITS, POSITION_UNITS

GATED = {**METRIC_UNITS, **POSITION_UNITS}
"""Figures of merit that may not get worse, as far as a run has them, with units; smaller is better for all of them."""

NOT_COMPARED = ("controllers", "sweep")  # fields of a scenario that do not change the run of a controller
ACROSS = {"gains": "feedback"}  # what a baseline may differ in on demand, and the table of the scenario that says it
MOST_SHOWN = 6  # most differing fields that a message names
TOLERANCE = 0.05  # default tolerance, relative

GUARDED = frozenset({"pi", "pi_inertia", "fixed", "adaptive"})
"""Controllers of this package that are guarded where none are chosen; the others are yardsticks."""

EXAMPLES = {"controllers": "adaptive", "metrics": "rms_error_settled"}  # of what may be named, for messages
CONFIDENCE = 0.95  # of the interval of a mean over seeds that is tolerated where no tolerance is given

Fraction = float | str
Tolerance = Fraction | Mapping[str, Fraction]


def read_fraction(name: str, value: Fraction) -> float:
    """Return a fraction such as ``"5%"``, ``"0.05"`` or 0.05 as a number; messages call it by the name.

    Above one only as a percentage, since a bare 5 is more likely meant as 5 % than as 500 %.
    """
    text = str(value).strip()
    try:
        fraction = float(text.removesuffix("%")) * (0.01 if text.endswith("%") else 1.0)
    except ValueError:
        fraction = math.nan
    if not (math.isfinite(fraction) and fraction >= 0.0):
        raise InputError(f"{name} = {value!r} is not allowed: it must be a fraction such as 5% or 0.05, zero or more")
    if fraction > 1.0 and not text.endswith("%"):
        raise InputError(
            f"{name} = {value!r} is not allowed: as a number it would mean {100.0 * fraction:g} %; "
            f"write {text}% or {0.01 * fraction:g} for {text} %, or {100.0 * fraction:g}% if that is meant"
        )
    return fraction


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
        check_among("across = ", name, ACROSS)
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


class Gate:
    """A baseline, called by a name in messages, and what may be worse than it; checked before anything runs.

    A tolerance is a fraction for all, or fractions by metric, controller or ``CONTROLLER.METRIC`` beside a ``default``;
    the most particular one counts. Without one it is 5 %, of several seeds half the interval of their mean.
    """

    def __init__(
        self,
        baseline: Mapping[str, Any],
        scenario: Scenario,
        seeds: int,
        *,
        tolerance: Tolerance | None = None,
        controllers: Iterable[str] | None = None,
        metrics: Iterable[str] | None = None,
        across: Iterable[str] = (),
        name: str = "baseline",
    ) -> None:
        found = scenario_differences(scenario, baseline, across)
        if found:
            gains = all(one.startswith(f"{ACROSS['gains']}.") for one in found)
            more = f" and {len(found) - MOST_SHOWN} more fields differ" if len(found) > MOST_SHOWN else ""
            raise InputError(
                f"{name}: is of another scenario: {'; '.join(found[:MOST_SHOWN])}{more}; run the scenario that it was "
                f"made with, or make a new baseline{', or compare across gains (--across gains)' if gains else ''}"
            )
        there = seeds_of(baseline.get("by_seed"))
        if there != seeds:
            raise InputError(
                f"seeds = {seeds} is not allowed: the baseline is of {there}; run as many, or make a new one"
            )
        self._baseline, self._axis, self._all = baseline, scenario.joint.axis, controllers is None
        self._fractions = self._read_tolerances(tolerance)
        self.controllers = self._guarded_controllers(controllers)
        self.metrics = self._guarded_metrics(metrics)

    def _read_tolerances(self, tolerance: Tolerance | None) -> dict[str, float]:
        given = tolerance if isinstance(tolerance, Mapping) else {"default": tolerance}
        given = {key: value for key, value in given.items() if value is not None}
        names = list(self._baseline["controllers"])
        allowed = {"default", *GATED, *names, *(f"{name}.{metric}" for name in names for metric in GATED)}
        for key in given:
            if key not in allowed:
                raise InputError(
                    f"tolerance {key!r} is not known; there are the metrics {', '.join(GATED)}, the controllers "
                    f"{', '.join(names)} and CONTROLLER.METRIC"
                )
        said = {key: "tolerance" if key == "default" else f"tolerance of {key}" for key in given}
        return {key: read_fraction(said[key], value) for key, value in given.items()}

    def _guarded_controllers(self, chosen: Iterable[str] | None) -> list[str]:
        """Return the controllers that are looked at: by default all of the baseline but the package's yardsticks."""
        there = list(self._baseline["controllers"])
        default = [name for name in there if name in GUARDED or name not in CONTROLLERS]
        names = default if chosen is None else _several("controllers", chosen)
        for name in names:
            check_among("guarded controller ", name, there, "in the baseline")
        if not names:
            raise InputError(
                f"the baseline has only controllers that are not guarded by default ({', '.join(there)}); choose "
                "which to guard"
            )
        return names

    def _guarded_metrics(self, chosen: Iterable[str] | None) -> list[str]:
        """Return the metrics that are looked at: by default all that the baseline has."""
        controllers = self._baseline["controllers"]
        default = [name for name in GATED if all(name in figures for figures in controllers.values())]
        names = default if chosen is None else _several("metrics", chosen)
        for name in names:
            check_among("metric ", name, GATED)
            for controller, figures in controllers.items():
                check_among("metric ", name, figures, f"in the baseline of {controller}")
        return names

    def tolerance_of(self, controller: str, metric: str) -> float:
        """Return how much worse a figure of a controller may be, relative."""
        for key in (f"{controller}.{metric}", metric, controller, "default"):
            if key in self._fractions:
                return self._fractions[key]
        values = (self._baseline.get("by_seed") or {}).get(controller, {}).get(metric, [])
        if len(values) < 2 or not any(values):
            return TOLERANCE
        quantile = float(scipy.special.stdtrit(len(values) - 1, 0.5 + 0.5 * CONFIDENCE))
        return quantile * float(np.std(values, ddof=1) / np.mean(values)) / math.sqrt(len(values))

    def worse(self, comparison: Comparison) -> list[str]:
        """Return what got worse, a sentence each; an own controller that is not in the baseline is named."""
        before, now = (mean_figures(result) for result in (self._baseline, comparison.to_dict()))
        unguarded = [name for name in now if name not in CONTROLLERS and name not in before] if self._all else []
        found = [f"{name}: is not in the baseline, so nothing guards it" for name in unguarded]
        for name in self.controllers:
            if name not in now:
                found.append(f"{name}: is in the baseline, but was not run")
                continue
            for figure in self.metrics:
                old, new, allowed = before[name][figure], now[name][figure], self.tolerance_of(name, figure)
                if new > old * (1.0 + allowed):
                    found.append(f"{name}: {_growth(self._axis, figure, old, new)}, allowed {100.0 * allowed:.3g} %)")
        return found


def _several(name: str, chosen: Iterable[str]) -> list[str]:
    """Return names as a list; a gate that looks at nothing would let everything pass."""
    names: list[Any] = list(chosen) if isinstance(chosen, Iterable) and not isinstance(chosen, str) else [None]
    if not all(isinstance(one, str) for one in names):
        example = chosen if isinstance(chosen, str) else EXAMPLES[name]
        raise InputError(f"{name} = {chosen!r} is not allowed: it must be a list of names, such as [{example!r}]")
    if not names:
        raise InputError(f"{name} = [] is not allowed: name one at least, or leave it out for the default")
    return names


def mean_figures(result: Mapping[str, Any]) -> dict[str, dict[str, float]]:
    """Return the figures of each controller of a result, over its seeds where it has several."""
    by_seed = result.get("by_seed") or {}
    means = {name: {key: float(np.mean(one)) for key, one in figures.items()} for name, figures in by_seed.items()}
    return {name: means.get(name, figures) for name, figures in result["controllers"].items()}


def seeds_of(by_seed: Mapping[str, Mapping[str, list[float]]] | None) -> int:
    """Return the number of seeds of a result by its figures at each."""
    return max((len(one) for figures in (by_seed or {}).values() for one in figures.values()), default=1)


def _growth(axis: str, figure: str, old: float, new: float) -> str:
    unit, factor = GATED[figure], 1.0
    if unit.startswith("rad"):
        unit, factor = f"m{unit}", 1e3
    fraction = f"{100.0 * (new / old - 1.0):.1f} %" if old > 0.0 else "from zero"
    return f"{figure} grew from {factor * old:.4g} to {factor * new:.4g} {axis_unit(axis, unit)} ({fraction}"


def regressions(
    comparison: Comparison,
    baseline: Mapping[str, Any],
    tolerance: Tolerance | None = None,
    *,
    controllers: Iterable[str] | None = None,
    metrics: Iterable[str] | None = None,
    across: Iterable[str] = (),
) -> list[str]:
    """Return what got worse than a baseline, a sentence each; empty where nothing did.

    Parameters
    ----------
    comparison : Comparison
        The result now.
    baseline : mapping
        The earlier result, see :func:`read_baseline`.
    tolerance : float, str or mapping, optional
        How much worse a figure may be, as 0.05 or ``"5%"``; or a mapping from metrics, controllers or
        ``CONTROLLER.METRIC`` to such fractions, with ``default`` for the others. By default 5 %, of several seeds half
        the 95 % interval of the mean of the baseline's.
    controllers : iterable of str, optional
        Which to guard; by default all of the baseline but the yardsticks of this package, and every own controller: one
        that ran and is not in the baseline is named.
    metrics : iterable of str, optional
        Which figures to guard; by default all that the baseline has.
    across : iterable of str, optional
        What may differ from the baseline's scenario: ``"gains"``, all of ``[feedback]``.

    Raises
    ------
    InputError
        The baseline is of another scenario or of other seeds, or lacks a figure, or a tolerance, a controller or a
        metric is not allowed.
    TypeError
        The comparison or the baseline is none.
    """
    check_kind("comparison", comparison, Comparison, "a Comparison: compare(scenario) makes one")
    check_kind("baseline", baseline, Mapping, "what read_baseline(path) returns")
    if not {"scenario", "controllers"} <= set(baseline):
        raise InputError("baseline is not allowed: it lacks scenario or controllers; read_baseline(path) returns one")
    options: dict[str, Any] = {"tolerance": tolerance, "controllers": controllers, "metrics": metrics, "across": across}
    return Gate(baseline, comparison.scenario, seeds_of(comparison.by_seed), **options).worse(comparison)


def assert_no_regression(
    comparison: Comparison,
    baseline: str | Path,
    tolerance: Tolerance | None = None,
    *,
    controllers: Iterable[str] | None = None,
    metrics: Iterable[str] | None = None,
    across: Iterable[str] = (),
) -> None:
    """Fail a test where tracking got worse than a stored result.

    Parameters
    ----------
    comparison : Comparison
        The result now.
    baseline : str or Path
        A file that ``adaptive-ff compare --json`` or ``comparison.write`` wrote.
    tolerance, controllers, metrics, across : optional
        See :func:`regressions`.

    Raises
    ------
    AssertionError
        Something got worse; the message says what.
    InputError
        The baseline cannot be read or is of another scenario, or an argument is not allowed.
    TypeError
        The comparison is none, or the baseline no path.
    """
    check_kind("comparison", comparison, Comparison, "a Comparison: compare(scenario) makes one")
    earlier = read_baseline(checked_path("baseline", baseline))
    options: dict[str, Any] = {"tolerance": tolerance, "controllers": controllers, "metrics": metrics, "across": across}
    gate = Gate(earlier, comparison.scenario, seeds_of(comparison.by_seed), name=str(baseline), **options)
    worst, *others = gate.worse(comparison) or [""]
    if worst:
        more = f"; and {len(others)} more" if others else ""
        raise AssertionError("\n".join([f"tracking got worse than in {baseline}: {worst}{more}", *others]))
