"""Controllers in the loop whose bandwidth suits each best, chosen on seeds that are not reported.

On a common PI loop a good compensator is held to the bandwidth that suits the others, and a weak one is helped by a
loop that is slow. Here each takes the bandwidth at which its settled error is least, up to the fastest loop that a
maximum sensitivity of 1.7 allows.
"""

from functools import partial

import numpy as np

from adaptive_ff import Scenario, load_scenario
from adaptive_ff.comparison.own_bandwidth import find_own_bandwidth, settled_error, with_bandwidth
from adaptive_ff.comparison.reference_lines import NOISE_FLOOR, noise_floor
from adaptive_ff.comparison.registry import CONTROLLERS
from adaptive_ff.scenario.library import SCENARIOS
from adaptive_ff.studies.study import Found
from benchmarks.suite import Case

NAMES = ("paper_100hz", "noisy_1khz", "encoder", "delay", "elastic")


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
        found[controller] = {
            "error": _median(reported, controller),
            "own_error": _median(own, controller),
            "own_bandwidth": best.best,
        }
    for one in found.values():
        for error, gain in (("error", "gain"), ("own_error", "own_gain")):
            if error in one:
                one[gain] = found["pi"][error] / one[error]
    return {"": {"row": name}, **found}


def _median(scenarios: list[Scenario], controller: str) -> float:
    return float(np.median([settled_error(one, CONTROLLERS[controller]) for one in scenarios]))


def scenarios(count: int, first: int = 1) -> list[Case]:
    """Return the scenarios, each over as many seeds."""
    seeds = list(range(first, first + count))
    return [Case(name, first, partial(run_scenario, name, seeds)) for name in NAMES]
