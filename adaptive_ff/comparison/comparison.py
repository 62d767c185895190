"""All controllers of a scenario side by side."""

import copy
import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from functools import partial
from pathlib import Path
from typing import Any

from adaptive_ff.comparison.own import Own, check_own_names
from adaptive_ff.comparison.registry import CONTROLLERS, loop_of, make_controller
from adaptive_ff.comparison.run import Run, simulate
from adaptive_ff.comparison.running import check_progress, compile_together
from adaptive_ff.errors import checked_path
from adaptive_ff.files import write_result
from adaptive_ff.reported import Reported
from adaptive_ff.scenario.axis_units import axis_unit
from adaptive_ff.scenario.loop import TREMBLING
from adaptive_ff.scenario.scenario import Scenario, check_scenario, load_scenario
from adaptive_ff.simulation.experiment import build_setup
from adaptive_ff.workers import part_of_progress

ORACLE = "oracle"
"""What is fed the true friction."""

NO_GAIN = 0.95
"""Settled error of the oracle over that of the baseline beyond which feedforward gains nothing."""

MOST_SEEDS = 100
"""Most seeds of a comparison."""

BASELINE = "pi"
"""The controller that improvement is measured against."""


@dataclass(frozen=True, eq=False, repr=False)
class Comparison(Reported):
    """Runs of several controllers on the same scenario.

    Attributes
    ----------
    scenario : Scenario
        The scenario.
    runs : dict of Run
        A run a controller, by name.
    by_seed : dict of dict of list of float, optional
        Figures of merit by controller at this and further seeds, where there are any: what a gate compares.
    """

    _drawn_by = "plot_comparison"

    scenario: Scenario
    runs: dict[str, Run]
    by_seed: dict[str, dict[str, list[float]]] = field(default_factory=dict)

    @property
    def improvement(self) -> dict[str, float]:
        """Settled rms error of ``pi`` over that of each controller; empty without ``pi``."""
        if BASELINE not in self.runs:
            return {}
        base = self.runs[BASELINE].metrics.rms_error_settled
        errors = {name: run.metrics.rms_error_settled for name, run in self.runs.items()}
        return {name: base / error for name, error in errors.items() if error > 0.0}

    @property
    def bandwidths(self) -> dict[str, float]:
        """Bandwidth that was found best for each controller, Hz, where the scenario says ``auto``; else empty."""
        if not self.scenario.feedback.is_auto:
            return {}
        return {name: run.scenario.feedback.hertz for name, run in self.runs.items()}

    def cautions(self) -> list[str]:
        """Return what makes the figures say little of friction, a sentence each: noise, and commands that tremble."""
        found, axis = [], self.scenario.joint.axis
        speed, force = axis_unit(axis, "mrad/s"), axis_unit(axis, "N m")
        settled = {name: 1e3 * run.metrics.rms_error_settled for name, run in self.runs.items()}
        if {BASELINE, ORACLE} <= settled.keys() and settled[ORACLE] > NO_GAIN * settled[BASELINE] > 0.0:
            found.append(
                f"{ORACLE}, which is fed the true friction, settles at {settled[ORACLE]:.3g} {speed}, {BASELINE} at "
                f"{settled[BASELINE]:.3g}: noise of the measurement dominates, not friction; a slower loop "
                "(adaptive-ff tune) or a finer sensor helps, feedforward does not"
            )
        limit = self.scenario.actuator.torque_limit or math.inf
        # the mean step of a white torque is 2/sqrt(pi) times its rms
        scale = 0.5 * math.sqrt(math.pi) / self.scenario.samples
        noise = {name: scale * run.metrics.torque_variation for name, run in self.runs.items()}
        trembling = {name: value for name, value in noise.items() if value > TREMBLING * limit}
        if trembling:
            most = max(trembling.values())
            found.append(
                f"the command of {', '.join(trembling)} trembles by up to {most:.3g} {force} (rms), "
                f"{100.0 * most / limit:.2g} % of actuator.torque_limit = {limit:g} {force}: a slower loop or a lower "
                "velocity.cutoff calms it"
            )
        return found

    def to_dict(self) -> dict[str, Any]:
        """Return the result as ``--json`` writes it."""
        controllers: dict[str, dict[str, Any]] = {}
        for name, run in self.runs.items():
            controllers[name] = run.figures()
            if run.estimates:
                controllers[name]["estimates"] = run.final_estimates
        return {
            "scenario": self.scenario.model_dump(mode="json", exclude_none=True),
            "controllers": controllers,
            "improvement": self.improvement,
            **({"bandwidths": self.bandwidths} if self.bandwidths else {}),
            **({"by_seed": self.by_seed} if self.by_seed else {}),
        }

    def write(self, path: str | Path) -> None:
        """Write the result as JSON, as ``adaptive-ff compare --json`` does: the baseline of a regression gate.

        Raises
        ------
        InputError
            The file cannot be written.
        TypeError
            The path is none.
        """
        write_result(checked_path("path", path), self.to_dict())

    def __repr__(self) -> str:
        """Return the settled errors in one line."""
        settled = ", ".join(f"{name} {run.metrics.rms_error_settled:.3g}" for name, run in self.runs.items())
        return f"Comparison(settled rms error, rad/s: {settled})"

    def _repr_html_(self) -> str:
        """Return tables and pictures for a notebook."""
        return str(self._report("comparison_html"))

    def to_pandas(self) -> Any:
        """Return the figures of merit as a ``pandas.DataFrame``, a row a controller (extra ``pandas``).

        Units are in ``attrs["units"]``.
        """
        return self._report("figures_frame")

    def to_xarray(self) -> Any:
        """Return the series of all controllers as an ``xarray.Dataset`` by controller and time (extra ``pandas``).

        Series at the samples and the reference; the unit of each is in its ``attrs["units"]``.
        """
        return self._report("series_dataset")


def compare(
    scenario: Scenario | None = None,
    *,
    own: Mapping[str, Own] | None = None,
    progress: Callable[[str, float], None] | None = None,
    thin: int | None = None,
    seeds: int = 1,
) -> Comparison:
    """Run every controller of a scenario.

    Parameters
    ----------
    scenario : Scenario, optional
        The scenario; the built-in one by default.
    own : mapping, optional
        Further controllers by name; they run after those that the scenario names. Each is an object with a method
        ``step``, a class or a factory that gets the scenario and the PI gains, or ``FILE.py:NAME`` of one of these;
        see :func:`~adaptive_ff.comparison.own.make_own`.
    progress : callable, optional
        Is called with the name of the controller and the fraction of its run that is done.
    thin : int, optional
        Keep one of so many samples in the series, 1 for all; for the default see
        :func:`~adaptive_ff.comparison.run.simulate`.
    seeds : int, optional
        Number of seeds, from the scenario's on. Series are kept of the first; the figures of all stand in ``by_seed``.

    Returns
    -------
    Comparison
        The runs.

    Raises
    ------
    InputError
        The scenario names a controller that there is not, or an own one has the name of one that there is.
    TypeError
        The scenario, ``own`` or another argument is of another kind.
    ValueError
        ``thin`` or ``seeds`` is out of range.
    """
    if seeds not in range(1, MOST_SEEDS + 1):
        raise ValueError(f"seeds = {seeds!r} is not allowed: it must be a whole number from 1 to {MOST_SEEDS}")
    scenario = load_scenario() if scenario is None else scenario
    check_scenario(scenario)
    check_progress(progress)
    own = {} if own is None else own
    check_own_names(own, CONTROLLERS)
    seeded = [scenario, *(scenario.modified(seed=scenario.seed + place) for place in range(1, seeds))]
    first, *further = (_runs(one, copy.deepcopy(own), progress, thin, place, seeds) for place, one in enumerate(seeded))
    figures = {name: [run.figures(), *(one[name].figures() for one in further)] for name, run in first.items()}
    by_seed = {name: {key: [one[key] for one in listed] for key in listed[0]} for name, listed in figures.items()}
    return Comparison(scenario, first, by_seed if seeds > 1 else {})


def _runs(
    scenario: Scenario,
    own: Mapping[str, Own],
    progress: Callable[[str, float], None] | None,
    thin: int | None,
    place: int,
    seeds: int,
) -> dict[str, Run]:
    """Run every controller of a scenario at its seed, which has a place among several."""
    names = dict.fromkeys([*scenario.controllers, *own])
    loops = {name: loop_of(scenario, name, own) for name in names}
    made = {name: make_controller(loop, name, own) for name, loop in loops.items()}
    setup = build_setup(scenario)
    compile_together(made.values(), setup)
    runs = {}
    for name, controller in made.items():
        report = part_of_progress(None if progress is None else partial(progress, name), place, seeds)
        runs[name] = simulate(loops[name], controller, name=name, setup=setup, progress=report, thin=thin)
    return runs
