"""Controllers in the loop whose bandwidth suits each best, chosen on seeds that are not reported.

On a common PI loop a good compensator is held to the bandwidth that suits the others, and a weak one is helped by a
loop that is slow. Here each takes the bandwidth of ``auto``: what suits tracking and a step of the load, up to the
fastest loop that a maximum sensitivity of 1.7 allows.
"""

import tomllib
from pathlib import Path
from typing import Any

import numpy as np

from adaptive_ff import Scenario, load_scenario, parse_scenario, simulate
from adaptive_ff.comparison.own_bandwidth import find_own_bandwidth, loaded, settled_error, with_bandwidth
from adaptive_ff.comparison.registry import CONTROLLERS
from adaptive_ff.comparison.run import NOISE_FLOOR, noise_floor
from adaptive_ff.scenario.library import SCENARIOS
from adaptive_ff.scenario.new import Encoder, new_scenario_text
from adaptive_ff.simulation.tracking_errors import ratios, tracking_errors
from adaptive_ff.studies.study import Found
from benchmarks.suite import pooled


def run_scenario(name: str, seeds: list[int], controllers: list[str]) -> Found:
    """Find the bandwidth of each controller and its errors there and in the common loop, medians over seeds.

    ``error`` and ``own_error`` are settled errors (rad/s) in the common and in its own loop, ``gain`` and ``own_gain``
    those of PI over them, ``own_bandwidth`` is in Hz.
    """
    scenario = load_scenario(SCENARIOS / f"{name}.toml")
    reported = [scenario.modified(seed=seed) for seed in seeds]
    found: Found = {}
    for controller in controllers:
        if controller == NOISE_FLOOR:
            errors = [noise_floor(one).metrics.rms_error_settled for one in reported]
            found[controller] = {"error": float(np.median(errors))}
            continue
        best = find_own_bandwidth(scenario, CONTROLLERS[controller])
        own = [with_bandwidth(one, best.best) for one in reported]
        errors = {"error": _median(reported, controller), "own_error": _median(own, controller)}
        found[controller] = errors | {"own_bandwidth": best.best}
    gains, base = {"error": "gain", "own_error": "own_gain"}, found["pi"]
    for one in found.values():
        one |= {gain: base[error] / one[error] for error, gain in gains.items() if error in one}
    return {"": {"row": name}, **found}


DATA_SHEETS = tomllib.loads(Path(__file__).with_suffix(".toml").read_text(encoding="utf-8"))
LOADED_TIME = 40.0  # length of the runs with a step of the load, s: it comes after three quarters of it


def run_data_sheet(name: str, seeds: list[int], controllers: list[str]) -> Found:
    """Compare controllers, each at its own bandwidth, with PI at its own, before and after a step of the load.

    ``settled`` is PI's settled error over the controller's before the step, ``window`` the controller's error over PI's
    in the worst window of 5 s of those from half of the run on, both pooled over seeds; ``own_bandwidth`` is in Hz.
    """
    sheet: dict[str, Any] = {"inertia": 0.5, "torque": 20.0, "speed": 6.0, **DATA_SHEETS[name]}
    if "encoder" in sheet:
        sheet["encoder"] = Encoder(**sheet["encoder"])
    scenario = parse_scenario(tomllib.loads(new_scenario_text(**sheet)), name).modified(duration=LOADED_TIME)
    errors, found = {}, {}
    for controller in controllers:
        best = find_own_bandwidth(scenario, CONTROLLERS[controller]).best
        at = with_bandwidth(loaded(scenario), best)
        runs = [simulate(at.modified(seed=seed), controller) for seed in seeds]
        squares = np.mean([(run.reference - run.velocity) ** 2 for run in runs], axis=0)
        errors[controller] = own = tracking_errors(squares[squares.size // 2 :], at.joint.solver_period)
        settled, window = errors["pi"].windows[0] / own.windows[0], ratios(errors["pi"], own)["window"]
        found[controller] = {"settled": settled, "window": window, "own_bandwidth": best}
    return {"": {"row": name}, **found}


def _median(scenarios: list[Scenario], controller: str) -> float:
    return float(np.median([settled_error(one, CONTROLLERS[controller]) for one in scenarios]))


scenarios = pooled(run_scenario, lambda names: {name: (name,) for name in names})
data_sheets = pooled(run_data_sheet, {name: (name,) for name in DATA_SHEETS})
