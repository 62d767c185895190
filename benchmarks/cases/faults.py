"""The built-in joint when its measured velocity is lost for a while, and when somebody pushes it."""

import math
from typing import Any

import numpy as np

from adaptive_ff import Run, load_scenario, simulate
from adaptive_ff.simulation.experiment import build_setup
from adaptive_ff.studies.study import Found
from benchmarks.suite import seeded

LOSSES = (0.0, 0.2, 1.0, 5.0)  # lengths of the losses, s; without one for comparison
PLACES = (31.0, 36.5, 42.0, 47.5, 53.0)  # where they begin, s
WINDOW = 5.0  # length of what is judged, s from the start of a loss


def run_loss(loss: float, seed: int, controllers: list[str]) -> Found:
    """Lose the measurement for a time (s) at each of the places, in runs of their own.

    ``error`` is the rms error (rad/s) of the five seconds from the start of the loss on, over all places; ``over_pi``
    the same over PI's.
    """
    scenario = load_scenario().modified(seed=seed)
    setup, period = build_setup(scenario), scenario.sampling.period
    errors: dict[str, float] = {}
    for name in dict.fromkeys(["pi", *controllers]):
        squares = []
        for place in PLACES:
            first, noise = round(place / period), setup.noise.copy()
            noise[first : first + round(loss / period)] = math.nan
            run = simulate(scenario, name, setup=setup._replace(noise=noise), uncertain=False)
            squares.append(mean_square(run, place))
        errors[name] = float(np.sqrt(np.mean(squares)))
    row = f"{loss:g} s" if loss else "undisturbed"
    figures = {name: {"error": error, "over_pi": error / errors["pi"]} for name, error in errors.items()}
    return {"": {"row": row}, **figures}


losses = seeded(run_loss, {f"{loss:g} s": (loss,) for loss in LOSSES})

PUSHED, LENGTH, LOAD, DURATION = 30.0, 3.0, 80.0, 60.0
"""When the push begins and how long it is, s; its torque, N m; how long a run is, s."""

LATER = 5.0  # time from the end of the push to the seconds whose error counts, s

WATCHED = ("inertia", "coulomb", "stiction", "viscous")


def run_push(seed: int, controllers: list[str]) -> Found:
    """Push the joint when it has moved for half a minute.

    ``moved`` is the largest change of an estimate from just before the push to the end of the run, over its value;
    ``error_after`` the error from 5 to 10 s after the push, over that of the same seconds undisturbed.
    """
    still = load_scenario().modified(seed=seed, duration=DURATION)
    end = PUSHED + LENGTH
    pushed = still.modified(change=[{"time": PUSHED, "load": LOAD}, {"time": end, "load": 0.0}])
    figures: dict[str, Any] = {}
    for name in controllers:
        run, calm = (simulate(scenario, name, uncertain=False) for scenario in (pushed, still))
        figures[name] = {"error_after": math.sqrt(mean_square(run, end + LATER) / mean_square(calm, end + LATER))}
        if run.estimates:
            begin = int(np.searchsorted(run.time, PUSHED - 1e-6))
            series = [run.estimates[estimate][begin - 1 :] for estimate in WATCHED]
            figures[name]["moved"] = max(float(np.max(np.abs(one - one[0])) / one[0]) for one in series)
    return {"": {"row": f"{LOAD:g} N m for {LENGTH:g} s"}, **figures}


def mean_square(run: Run, first: float) -> float:
    """Return the mean squared error (rad^2/s^2) of the window from a time (s) on."""
    error = run.reference - run.velocity
    return float(np.mean(np.square(error[(run.solver_time >= first) & (run.solver_time < first + WINDOW)])))


pushes = seeded(run_push, {"push": ()})
