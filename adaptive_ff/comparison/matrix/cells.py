"""One run of the matrix: all controllers on a scenario with a seed, and their figures of merit."""

from collections.abc import Mapping
from dataclasses import asdict
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from adaptive_ff.comparison.comparison import BASELINE
from adaptive_ff.comparison.own import Own
from adaptive_ff.comparison.reference_lines import NOISE_FLOOR, noise_floor
from adaptive_ff.comparison.registry import make_controller
from adaptive_ff.comparison.run import Run, simulate
from adaptive_ff.scenario.scenario import Scenario, load_scenario
from adaptive_ff.simulation.experiment import lay_course
from adaptive_ff.simulation.metrics import START, rms, standstill_range
from adaptive_ff.simulation.tracking_errors import WINDOW, window_slices
from controllers import fastest_bandwidth

SCENARIOS = Path(__file__).resolve().parent / "scenarios"
"""Scenario files of the matrix."""

RECOVERY = 10.0
"""Time that a controller is given after a change of friction, s."""

NOISE_SHARE = 0.1
"""Largest share of the torque limit that the noise may cost the fastest PI loop (rms)."""

Figures = dict[str, float | None]
"""Figures of merit by name; None where a scenario has no such thing."""


def scenario_names() -> list[str]:
    """Return the names of the scenarios of the matrix."""
    return sorted(file.stem for file in SCENARIOS.glob("*.toml"))


def cell_scenario(name: str, seed: int, fastest: bool) -> Scenario:
    """Return a scenario of the matrix with a seed, and on demand with the fastest PI loop."""
    scenario = load_scenario(SCENARIOS / f"{name}.toml").modified(seed=seed)
    return with_fastest_loop(scenario) if fastest else scenario


def with_fastest_loop(scenario: Scenario) -> Scenario:
    """Return the scenario with the fastest PI loop that margin and noise allow.

    The maximum sensitivity is at most 1.7, and the torque that measurement noise causes through the proportional gain
    at most 10 % of the torque limit (rms).
    """
    period = scenario.sampling.period
    bandwidth = fastest_bandwidth(period, int(np.ceil(scenario.delay - 1e-6)))
    noise, limit = scenario.velocity_noise, scenario.actuator.torque_limit
    if noise > 0.0 and limit is not None:
        bandwidth = min(bandwidth, NOISE_SHARE * limit / (2.0 * np.pi * scenario.feedback.inertia * noise))
    feedback = {"inertia": scenario.feedback.inertia, "bandwidth": float(bandwidth)}
    return Scenario.model_validate({**scenario.model_dump(exclude_unset=True), "feedback": feedback})


def run_cell(
    name: str, seed: int, fastest: bool, controllers: list[str], own: Mapping[str, Own] | None = None
) -> dict[str, Figures]:
    """Run controllers on a scenario with a seed and return their figures of merit by name.

    A controller of the package that cannot be made for the scenario, or that does not keep the loop finite, has none;
    so does an own one whose loop does not stay finite. What else goes wrong in an own one is raised.
    """
    own = own or {}
    scenario = cell_scenario(name, seed, fastest)
    course = lay_course(scenario)
    pi = simulate(scenario, BASELINE, course=course, uncertain=False)
    base = windows(pi)
    found: dict[str, Figures] = {}
    for controller in controllers:
        try:
            if controller == NOISE_FLOOR:
                run = noise_floor(scenario, course)
            elif controller == BASELINE:
                run = pi
            else:
                made = make_controller(scenario, controller, own)
                run = simulate(scenario, made, name=controller, course=course, uncertain=False)
        except ArithmeticError:
            found[controller] = {}
        except ValueError:
            if controller in own:
                raise
            found[controller] = {}
        else:
            found[controller] = {**asdict(run.metrics), **further_figures(run, base)}
    return found


def further_figures(run: Run, base: NDArray[np.float64]) -> Figures:
    """Return figures of merit beyond those of a run's own.

    Parameters
    ----------
    run : Run
        The run.
    base : ndarray
        Errors of PI in windows of 5 s, rad/s, from :func:`windows`.
    """
    time, error = run.solver_time, run.reference - run.velocity
    change = run.scenario.last_change
    own = windows(run)
    later = np.arange(own.size) * WINDOW >= change
    recovered = error[time >= change + RECOVERY]
    second = error[(time > START) & (time <= 2.0 * START)]
    return {
        "rms_error_second": rms(second) if second.size else None,
        "rms_error_recovered": rms(recovered) if change > 0.0 and recovered.size else None,
        "worst_window": float(np.max(own[later] / np.maximum(base[later], np.finfo(float).tiny))),
        "standstill": standstill_range(time, run.reference, run.velocity),
    }


def windows(run: Run) -> NDArray[np.float64]:
    """Return the rms error in each whole window of 5 s, rad/s."""
    error = run.reference - run.velocity
    return np.array([rms(error[part]) for part in window_slices(error.size, run.scenario.joint.solver_period)])
