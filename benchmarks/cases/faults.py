"""The built-in joint when its measured velocity is lost for a while, and when somebody pushes it."""

import math
from typing import Any

import numpy as np
from numpy.typing import NDArray

from adaptive_ff import Run, load_scenario, simulate
from adaptive_ff.simulation.experiment import build_setup
from adaptive_ff.studies.study import Found
from benchmarks.suite import Case, seeded

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
            squares.append(np.mean(_square(run)[_between(run, place, place + WINDOW)]))
        errors[name] = float(np.sqrt(np.mean(squares)))
    row = f"{loss:g} s" if loss else "undisturbed"
    figures = {name: {"error": error, "over_pi": error / errors["pi"]} for name, error in errors.items()}
    return {"": {"row": row}, **figures}


def losses(count: int, first: int = 1) -> list[Case]:
    """Return losses of several lengths."""
    return seeded(run_loss, ((f"{loss:g} s", (loss,)) for loss in LOSSES), count, first)


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
        squares = [np.mean(_square(one)[_between(one, end + LATER, end + LATER + WINDOW)]) for one in (run, calm)]
        figures[name] = {"error_after": math.sqrt(squares[0] / squares[1])}
        if run.estimates:
            figures[name]["moved"] = max(_moved(run, estimate) for estimate in WATCHED)
    return {"": {"row": f"{LOAD:g} N m for {LENGTH:g} s"}, **figures}


def _moved(run: Run, estimate: str) -> float:
    begin = int(np.searchsorted(run.time, PUSHED - 1e-6))
    series = run.estimates[estimate]
    return float(np.max(np.abs(series[begin:] - series[begin - 1])) / series[begin - 1])


def _square(run: Run) -> NDArray[np.float64]:
    return np.square(run.reference - run.velocity)


def _between(run: Run, first: float, last: float) -> NDArray[np.bool_]:
    return (run.solver_time >= first) & (run.solver_time < last)


def pushes(count: int, first: int = 1) -> list[Case]:
    """Return pushes of the built-in joint."""
    return seeded(run_push, [("push", ())], count, first)
