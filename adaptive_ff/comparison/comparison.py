"""All controllers of a scenario side by side, and what that comes to.

For the verdict the mean square of the settled error is split by two runs on the joint without friction, with and
without noise: what the loop leaves by itself (delay, sampling, bandwidth), what noise adds, and what is left of
friction. The largest part is the limit; torque at its limit goes before all.
"""

import copy
import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np

from adaptive_ff.comparison.own import Own, check_own_names
from adaptive_ff.comparison.registry import CONTROLLERS, loop_of, make_controller
from adaptive_ff.comparison.run import Run, noise_floor, simulate
from adaptive_ff.comparison.running import check_progress, compile_together
from adaptive_ff.errors import checked_path
from adaptive_ff.files import write_result
from adaptive_ff.reported import WORTH, Reported
from adaptive_ff.scenario.axis_units import axis_unit
from adaptive_ff.scenario.loop import HUNTING, TREMBLING, fall_over_gain
from adaptive_ff.scenario.scenario import Scenario, check_scenario, load_scenario
from adaptive_ff.simulation.experiment import build_setup
from adaptive_ff.simulation.metrics import settled_start
from adaptive_ff.workers import part_of_progress

ORACLE = "oracle"  # what is fed the true friction
NO_GAIN = 0.95  # settled error of the oracle over that of the baseline beyond which feedforward gains nothing
MOST_SEEDS = 100  # most seeds of a comparison
BASELINE = "pi"  # the controller that improvement is measured against

KNOW_THE_TRUTH = frozenset({"noise_floor", "oracle", "oracle_tuned", "coulomb_true", "stribeck_true"})
"""Controllers that know what nobody knows; they are limits, not candidates."""

SATURATED, NEAR = 0.01, 0.95  # the drive limits where so many settled samples are at so much of the torque limit
IDENTIFIED = 0.5  # deviation of an estimate at the end, over the one before, below which it is identified
LONGEST = 60.0  # longest run on the joint without friction, s


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
        runs = self.runs if self.scenario.feedback.is_auto else {}
        return {name: run.scenario.feedback.hertz for name, run in runs.items()}

    def cautions(self) -> list[str]:
        """Return what makes the figures say little of friction, a sentence each: noise, and commands that tremble."""
        found: list[str] = []
        speed, force = (axis_unit(self.scenario.joint.axis, unit) for unit in ("mrad/s", "N m"))
        settled = {name: 1e3 * run.metrics.rms_error_settled for name, run in self.runs.items()}
        lost = {BASELINE, ORACLE} <= settled.keys() and settled[ORACLE] > NO_GAIN * settled[BASELINE] > 0.0
        if lost and self.scenario.velocity_noise > 0.0 and fall_over_gain(self.runs[BASELINE].scenario) <= HUNTING:
            found.append(
                f"{ORACLE}, which is fed the true friction, settles at {settled[ORACLE]:.3g} {speed}, {BASELINE} at "
                f"{settled[BASELINE]:.3g}: noise of the measurement dominates, not friction; a slower loop "
                "(adaptive-ff tune) or a finer sensor helps, feedforward does not"
            )
        limit = self.scenario.actuator.torque_limit or math.inf
        # the mean step of a white torque is 2/sqrt(pi) times its rms
        scale = 0.5 * math.sqrt(math.pi) / self.scenario.samples
        noise = {name: scale * run.metrics.torque_variation for name, run in self.runs.items()}
        trembling = [name for name, value in noise.items() if value > TREMBLING * limit]
        if trembling:
            most = max(noise[name] for name in trembling)
            found.append(
                f"the command of {', '.join(trembling)} trembles by up to {most:.3g} {force} (rms), "
                f"{100.0 * most / limit:.2g} % of actuator.torque_limit = {limit:g} {force}: a slower loop or a lower "
                "velocity.cutoff calms it"
            )
        return found

    def to_dict(self) -> dict[str, Any]:
        """Return the result as ``--json`` writes it."""
        further = {"bandwidths": self.bandwidths, "by_seed": self.by_seed}
        return {
            "scenario": self.scenario.model_dump(mode="json", exclude_none=True),
            "controllers": {
                name: {**run.figures(), **({"estimates": run.final_estimates} if run.estimates else {})}
                for name, run in self.runs.items()
            },
            "improvement": self.improvement,
            **{name: one for name, one in further.items() if one},
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
        return f"Comparison(settled rms error, {axis_unit(self.scenario.joint.axis, 'rad/s')}: {settled})"

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
    names = dict.fromkeys([*scenario.controllers, *own])
    runs: dict[str, list[Run]] = {name: [] for name in names}
    for place in range(seeds):
        one, mine = scenario.modified(seed=scenario.seed + place) if place else scenario, copy.deepcopy(own)
        loops = {name: loop_of(one, name, mine) for name in names}
        made = {name: make_controller(loop, name, mine) for name, loop in loops.items()}
        setup = build_setup(one)
        compile_together(made.values(), setup)
        for name, controller in made.items():
            report = part_of_progress(None if progress is None else partial(progress, name), place, seeds)
            run = simulate(loops[name], controller, name=name, setup=setup, progress=report, thin=thin)
            runs[name].append(run)
    figures = {name: [run.figures() for run in listed] for name, listed in runs.items()}
    by_seed = {name: {key: [one[key] for one in listed] for key in listed[0]} for name, listed in figures.items()}
    return Comparison(scenario, {name: listed[0] for name, listed in runs.items()}, by_seed if seeds > 1 else {})


@dataclass(frozen=True)
class Verdict:
    """What a comparison comes to."""

    best: str  # the controller with the least settled error that does not know the truth
    over_pi: float | None  # settled error of PI over its; None without PI
    over_oracle: float | None  # that of the oracle over its; None without
    torque_variation: float | None  # its torque variation over that of PI
    worth: bool  # whether it improves on PI by more than 5 %
    # what most of the error is due to: ``saturation``, ``noise``, ``delay``, ``bandwidth`` or ``friction``
    limit: str | None
    parts: dict[str, float]  # root mean square of the settled error due to ``loop``, ``noise`` and ``friction``, rad/s
    # parameters of the best that stay as they were given, or assumed, and those that the motion has shown
    given: tuple[str, ...]
    identified: tuple[str, ...]
    # standard deviation of the latter over the estimate, at the end of the run; None of an estimate that is zero
    deviations: dict[str, float | None]


def verdict(comparison: Comparison) -> Verdict:
    """Return what a comparison comes to."""
    runs, errors = comparison.runs, {name: run.metrics.rms_error_settled for name, run in comparison.runs.items()}
    best = min((name for name in runs if name not in KNOW_THE_TRUTH), key=lambda name: errors[name], default=min(runs))
    run, over_pi = runs[best], comparison.improvement.get(best)
    variation = runs[BASELINE].metrics.torque_variation if BASELINE in runs else 0.0
    parts = error_parts(run.scenario, errors[best])
    largest = max(parts, key=lambda name: parts[name]) if any(parts.values()) else None
    late = run.scenario.delay + run.scenario.velocity_lag / run.scenario.sampling.period >= 1.0
    limit = ("delay" if late else "bandwidth") if largest == "loop" else largest
    shown = [name for name, spread in run.uncertainties.items() if spread[-1] < IDENTIFIED * spread[0]]
    estimates = {name: run.final_estimates[name] for name in shown}
    given = list(run.uncertainties) if run.final_estimates else ["inertia", "stribeck_velocity"]
    return Verdict(
        best,
        over_pi,
        errors["oracle"] / errors[best] if "oracle" in runs and errors[best] > 0.0 else None,
        run.metrics.torque_variation / variation if variation > 0.0 else None,
        over_pi is not None and over_pi > WORTH,
        "saturation" if limit != "noise" and _saturated(run) > SATURATED else limit,  # noise alone may saturate
        parts,
        tuple(name for name in given if name not in shown),
        tuple(shown),
        {name: float(run.uncertainties[name][-1]) / abs(value) if value else None for name, value in estimates.items()},
    )


def error_parts(scenario: Scenario, error: float) -> dict[str, float]:
    """Return what of a settled error (rad/s rms) is due to the loop, to noise and to friction; empty where unknown."""
    duration = min(scenario.length, LONGEST)
    changes = [one for one in scenario.change if one.time < duration]
    try:
        brief = scenario.modified(duration=duration, change=changes)
        floor, clean = (noise_floor(brief, noisy=noisy).metrics.rms_error_settled for noisy in (True, False))
    except (ArithmeticError, ValueError):
        return {}
    squares = {"loop": clean**2, "noise": floor**2 - clean**2, "friction": error**2 - floor**2}
    return {name: math.sqrt(max(square, 0.0)) for name, square in squares.items()}


def _saturated(run: Run) -> float:
    """Return the fraction of the settled samples whose torque is near its limit."""
    limit = run.scenario.actuator.torque_limit
    settled = run.time >= settled_start(run.scenario.last_change, float(run.solver_time[-1]))
    if limit is None or not np.any(settled):
        return 0.0
    return float(np.mean(np.abs(run.torque[settled]) > NEAR * limit))
