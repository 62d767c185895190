"""What a comparison comes to, as codes and values: the best, its gain, whether it is worth it, what limits it.

The mean square of the settled error is split by two runs on the joint without friction, with and without noise: what
the loop leaves by itself (delay, sampling, bandwidth), what noise adds, and what is left of friction. The largest part
is the limit; torque at its limit goes before all.
"""

import math
from dataclasses import dataclass

import numpy as np

from adaptive_ff.comparison.comparison import BASELINE, Comparison
from adaptive_ff.comparison.reference_lines import noise_floor
from adaptive_ff.comparison.run import Run
from adaptive_ff.reported import WORTH
from adaptive_ff.scenario.scenario import Scenario
from adaptive_ff.simulation.metrics import settled_start

KNOW_THE_TRUTH = frozenset({"noise_floor", "oracle", "oracle_tuned", "coulomb_true", "stribeck_true"})
"""Controllers that know what nobody knows; they are limits, not candidates."""

SATURATED, NEAR = 0.01, 0.95
"""Fraction of the settled samples at or above this fraction of the torque limit from which the drive limits."""

IDENTIFIED = 0.5
"""Deviation of an estimate at the end, over the one before, below which it is identified."""

LONGEST = 60.0
"""Longest run on the joint without friction, s."""


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
    pi, run = runs.get(BASELINE), runs[best]
    over_pi = errors[BASELINE] / errors[best] if pi is not None and errors[best] > 0.0 else None
    over_oracle = errors["oracle"] / errors[best] if "oracle" in runs and errors[best] > 0.0 else None
    variation = None
    if pi is not None and pi.metrics.torque_variation > 0.0:
        variation = run.metrics.torque_variation / pi.metrics.torque_variation
    parts = error_parts(run.scenario, errors[best])
    limit = _largest(run.scenario, parts)
    shown = [name for name, spread in run.uncertainties.items() if spread[-1] < IDENTIFIED * spread[0]]
    estimates = {name: run.final_estimates[name] for name in shown}
    given = list(run.uncertainties) if run.final_estimates else ["inertia", "stribeck_velocity"]
    return Verdict(
        best,
        over_pi,
        over_oracle,
        variation,
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
    changes = [one.model_dump(exclude_unset=True) for one in scenario.change if one.time < duration]
    try:
        brief = scenario.modified(duration=duration, change=changes)
        floor, clean = (noise_floor(brief, noisy=noisy).metrics.rms_error_settled for noisy in (True, False))
    except (ArithmeticError, ValueError):
        return {}
    squares = {"loop": clean**2, "noise": floor**2 - clean**2, "friction": error**2 - floor**2}
    return {name: math.sqrt(max(square, 0.0)) for name, square in squares.items()}


def _largest(scenario: Scenario, parts: dict[str, float]) -> str | None:
    if not any(parts.values()):
        return None
    largest = max(parts, key=lambda name: parts[name])
    late = scenario.delay + scenario.velocity_lag / scenario.sampling.period >= 1.0
    return ("delay" if late else "bandwidth") if largest == "loop" else largest


def _saturated(run: Run) -> float:
    """Return the fraction of the settled samples whose torque is near its limit."""
    limit = run.scenario.actuator.torque_limit
    settled = run.time >= settled_start(run.scenario.last_change, float(run.solver_time[-1]))
    if limit is None or not np.any(settled):
        return 0.0
    return float(np.mean(np.abs(run.torque[settled]) > NEAR * limit))
