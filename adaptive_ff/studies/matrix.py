"""The scenario matrix: controllers on the scenarios of the package over seeds, and which of them is best."""

from collections.abc import Callable, Mapping
from concurrent.futures import Executor
from dataclasses import asdict
from functools import partial
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

from adaptive_ff.comparison.comparison import BASELINE, KNOW_THE_TRUTH
from adaptive_ff.comparison.own import Own, check_own_names, own_marks, workers_for
from adaptive_ff.comparison.registry import CONTROLLERS
from adaptive_ff.comparison.run import NOISE_FLOOR, Run, run_by_name
from adaptive_ff.scenario.library import SCENARIOS
from adaptive_ff.scenario.loop import TREMBLING
from adaptive_ff.scenario.scenario import Scenario, load_scenario
from adaptive_ff.simulation.experiment import build_setup
from adaptive_ff.simulation.metrics import START, rms, standstill_range
from adaptive_ff.simulation.tracking_errors import TrackingErrors, ratios
from adaptive_ff.studies.study import Store, code_digest, digest_of, run_study
from adaptive_ff.studies.tracking import run_errors
from controllers import fastest_bandwidth

RECOVERY = 10.0  # time that a controller is given after a change of friction, s

OURS = "adaptive"
ALIKE = 1.02  # a median ratio nearer to one than this factor counts as equal
Figures = dict[str, float | None]  # figures of merit by name; None where a scenario has no such thing


class Job(NamedTuple):
    """A scenario with a seed, and with the fastest PI loop or its own."""

    scenario: str  # name of the scenario
    seed: int  # seed
    fastest: bool  # whether the PI loop is the fastest that margin and noise allow

    @property
    def key(self) -> str:
        """Unique key."""
        return f"{self.scenario}, {'fastest' if self.fastest else 'own'}, {self.seed}"


Results = dict[Job, dict[str, Figures]]


def cell_scenario(name: str, seed: int, fastest: bool) -> Scenario:
    """Return a scenario of the matrix with a seed, and on demand with the fastest PI loop."""
    scenario = load_scenario(SCENARIOS / f"{name}.toml").modified(seed=seed)
    return with_fastest_loop(scenario) if fastest else scenario


def with_fastest_loop(scenario: Scenario) -> Scenario:
    """Return the scenario with the fastest PI loop of a maximum sensitivity of at most 1.7.

    Measurement noise causes at most 10 % of the torque limit (rms) through its proportional gain.
    """
    delay = int(np.ceil(scenario.delay - 1e-6))
    bandwidth = fastest_bandwidth(scenario.sampling.period, delay, velocity=scenario.velocity_estimator)
    noise, limit = scenario.velocity_noise, scenario.actuator.torque_limit
    if noise > 0.0 and limit is not None:
        bandwidth = min(bandwidth, TREMBLING * limit / (2.0 * np.pi * scenario.feedback.inertia * noise))
    feedback = {"inertia": scenario.feedback.inertia, "bandwidth": float(bandwidth)}
    return scenario.replaced(feedback=feedback)


def run_matrix(
    jobs: list[Job],
    controllers: list[str],
    folder: Path,
    *,
    own: Mapping[str, Own] | None = None,
    executor: Executor | None = None,
    progress: Callable[[float], None] | None = None,
) -> Results:
    """Run the jobs; what the folder holds from an earlier call, with the same code and scenarios, is not run again.

    Results are kept of own controllers that are given as ``FILE.py:NAME``, until that file changes.
    """
    own = own or {}
    check_own_names(own, {**CONTROLLERS, NOISE_FLOOR: None})
    digests = {name: digest_of(SCENARIOS.glob(f"{name}.*")) for name in {job.scenario for job in jobs}}
    keys = {job: f"{job.key}, {digests[job.scenario]}" for job in jobs}
    found = run_study(
        partial(run_job, own),
        {key: job for job, key in keys.items()},
        [*controllers, *own],
        store=Store(folder / "runs.jsonl", code_digest(), own_marks(own)),
        executor=executor,
        workers=workers_for(own),
        threads=not own,
        progress=progress,
    )
    return {job: {name: found[keys[job]][name] for name in (*controllers, *own)} for job in jobs}


def run_job(own: Mapping[str, Own], job: Job, controllers: list[str]) -> dict[str, Figures]:
    """Return figures of merit of controllers on a scenario, by name.

    A controller of the package that cannot be made for the scenario, or that does not keep the loop finite, has none;
    so does an own one whose loop does not stay finite. What else goes wrong in an own one is raised.
    """
    scenario = cell_scenario(*job)
    setup = build_setup(scenario)
    pi = run_by_name(scenario, BASELINE, setup)
    base = run_errors(pi)
    found: dict[str, Figures] = {}
    for controller in controllers:
        try:
            run = pi if controller == BASELINE else run_by_name(scenario, controller, setup, own)
            found[controller] = {**asdict(run.metrics), **further_figures(run, base)}
        except (ArithmeticError, ValueError) as error:
            if controller in own and isinstance(error, ValueError):
                raise
            found[controller] = {}
    return found


def further_figures(run: Run, base: TrackingErrors) -> Figures:
    """Return figures of merit beyond those of a run's own; ``base`` holds the errors of PI."""
    time, error = run.solver_time, run.reference - run.velocity
    change = run.scenario.last_change
    recovered = error[time >= change + RECOVERY]
    second = error[(time > START) & (time <= 2.0 * START)]
    return {
        "rms_error_second": rms(second) if second.size else None,
        "rms_error_recovered": rms(recovered) if change > 0.0 and recovered.size else None,
        "worst_window": ratios(base, run_errors(run))["window"],
        "standstill": standstill_range(time, run.reference, run.velocity),
    }


class Cell(NamedTuple):
    """A controller on a scenario, medians over the seeds."""

    error: float  # settled rms error, rad/s
    gain: float  # that of PI over its own, seed by seed


Cells = dict[str, dict[str, Cell]]  # by scenario and controller; one that failed on a seed has none


def collect(results: Results, figure: str = "rms_error_settled") -> Cells:
    """Return the cells of the matrix for a figure of merit."""
    cells: Cells = {}
    for scenario in dict.fromkeys(job.scenario for job in results):
        runs = [found for job, found in results.items() if job.scenario == scenario]
        base = np.array([found[BASELINE][figure] for found in runs], dtype=float)
        cells[scenario] = {}
        for name in runs[0]:
            errors = np.array([found[name].get(figure, np.nan) for found in runs], dtype=float)
            gains = base / np.maximum(errors, np.finfo(float).tiny)
            if not np.isnan(errors).any():
                cells[scenario][name] = Cell(float(np.median(errors)), float(np.median(gains)))
    return cells


def mean_gain(cells: Cells, name: str) -> float:
    """Return the geometric mean over scenarios of the improvement over PI; not a number where it failed on one."""
    gains = [row[name].gain if name in row else np.nan for row in cells.values()]
    return float(np.exp(np.mean(np.log(gains))))


def verdict(cells: Cells) -> dict[str, Any]:
    """Return which controller is best in the geometric mean over the scenarios, by how much, and where it is not."""
    names = dict.fromkeys(name for row in cells.values() for name in row if name not in KNOW_THE_TRUTH)
    means = {name: mean_gain(cells, name) for name in names}
    best = max(means, key=lambda name: np.nan_to_num(means[name]))
    gains = {scenario: row[best].gain for scenario, row in cells.items() if best in row}
    worst = min(gains, key=lambda scenario: gains[scenario])
    return {
        "best": best,
        "over_pi": means[best],
        "scenarios": len(cells),
        "worst": worst,
        "worst_over_pi": gains[worst],
        "below_pi": [scenario for scenario, gain in gains.items() if gain < 1.0 / ALIKE],
    }
