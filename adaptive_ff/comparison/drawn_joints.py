"""Monte Carlo: how good is the adaptive controller on joints drawn at random."""

import math
import os
from collections.abc import Callable
from concurrent.futures import Executor, ProcessPoolExecutor
from dataclasses import asdict, dataclass
from itertools import islice
from typing import Any

import numpy as np

from adaptive_ff.comparison.run import simulate
from adaptive_ff.errors import InputError
from adaptive_ff.scenario.scenario import Scenario
from adaptive_ff.simulation.experiment import lay_course
from adaptive_ff.simulation.metrics import Metrics
from controllers import pi_gains
from plant import steepest_fall

CONTROLLERS = ("pi", "oracle", "adaptive")

STEEPEST_FALL = 0.5
"""Steepest fall of the friction curve that is run, as a share of the proportional gain; beyond it, PI itself hunts."""

BATCH = 8
"""Joints handed to a worker at a time."""


@dataclass(frozen=True)
class Outcome:
    """One drawn joint.

    Attributes
    ----------
    draw : int
        Number of the draw; with the seed of the sweep it gives the joint, see :func:`draw_scenario`.
    metrics : dict of Metrics
        Figures of merit by controller; empty where the draw was refused.
    refused : str
        Why it was not run, empty where it was.
    """

    draw: int
    metrics: dict[str, Metrics]
    refused: str = ""

    def ratio(self, figure: str, controller: str, to: str) -> float:
        """Return a figure of merit of one controller over that of another."""
        top: float = getattr(self.metrics[controller], figure)
        bottom: float = getattr(self.metrics[to], figure)
        return top / bottom


def draw_scenario(scenario: Scenario, seed: int, draw: int) -> Scenario:
    """Draw a joint and what the controllers assume of it.

    The PI loop is redesigned for the assumed inertia with the scenario's bandwidth; the torque limit grows with the
    largest torque that the reference needs.

    Raises
    ------
    InputError
        The joint is one on which PI itself hunts, or which the solver period is too long for.
    """
    generator = np.random.default_rng([seed, draw])
    ranges, joint = scenario.sweep, scenario.joint

    def even(bounds: list[float]) -> float:
        return float(generator.uniform(bounds[0], bounds[1]))

    def logarithmic(bounds: list[float]) -> float:
        return float(np.exp(generator.uniform(math.log(bounds[0]), math.log(bounds[1]))))

    inertia = joint.inertia * logarithmic(ranges.inertia)
    coulomb, viscous = logarithmic(ranges.coulomb), logarithmic(ranges.viscous)
    stiction, lag = even(ranges.stiction), even(ranges.friction_lag)
    table = {"inertia": inertia}
    curves = {"": joint.friction, "_backward": joint.friction_backward}
    if curves["_backward"] == curves[""]:
        del curves["_backward"]
    for ending, curve in curves.items():
        table[f"coulomb{ending}"] = curve.coulomb * coulomb
        table[f"viscous{ending}"] = curve.viscous * viscous
        table[f"stiction{ending}"] = curve.coulomb * coulomb * stiction
    if "friction_lag" in type(joint).model_fields:
        table["friction_lag"] = lag
    noise = even(ranges.velocity_noise)
    assumed_velocity = joint.stribeck_velocity * logarithmic(ranges.assumed_stribeck_velocity)
    assumed_inertia = inertia * logarithmic(ranges.assumed_inertia)
    if scenario.feedback.bandwidth is None:
        share = assumed_inertia / scenario.feedback.inertia
        proportional, integral = (share * gain for gain in scenario.feedback.gains)
        feedback = {"inertia": assumed_inertia, "proportional": proportional, "integral": integral}
    else:
        proportional, _ = pi_gains(assumed_inertia, scenario.feedback.bandwidth)
        feedback = {"inertia": assumed_inertia, "bandwidth": scenario.feedback.bandwidth}
    drawn = scenario.modified(
        seed=int(generator.integers(2**31)),
        controllers=list(CONTROLLERS),
        joint=table,
        sensor={"velocity_noise": noise},
        feedback=feedback,
        adaptation={"stribeck_velocity": assumed_velocity},
    )
    steepest = max(map(steepest_fall, (drawn.joint.friction, drawn.joint.friction_backward)))
    if steepest > STEEPEST_FALL * proportional:
        raise InputError(f"draw {draw}: the friction curve falls too steeply for PI")
    limit = scenario.actuator.torque_limit
    if limit is None:
        return drawn
    return drawn.modified(actuator={"torque_limit": limit * needed_torque(drawn) / needed_torque(scenario)})


def needed_torque(scenario: Scenario) -> float:
    """Return a bound on the torque that the reference needs, N m."""
    joint, reference = scenario.joint, scenario.reference_velocity()
    fastest = float(np.max(np.abs(np.diff(reference)))) / joint.solver_period
    friction = max(joint.stiction, joint.coulomb + joint.viscous * float(np.max(np.abs(reference))))
    return joint.inertia * fastest + friction


def run_draw(scenario: Scenario, seed: int, draw: int) -> Outcome:
    """Draw a joint and run the controllers on it."""
    try:
        drawn = draw_scenario(scenario, seed, draw)
    except InputError as error:
        return Outcome(draw, {}, str(error))
    course = lay_course(drawn)
    return Outcome(draw, {name: simulate(drawn, name, course=course).metrics for name in CONTROLLERS})


def _run_batch(scenario: Scenario, seed: int, draws: list[int]) -> list[Outcome]:
    return [run_draw(scenario, seed, draw) for draw in draws]


def sweep(
    scenario: Scenario,
    runs: int,
    seed: int = 1,
    *,
    executor: Executor | None = None,
    progress: Callable[[float], None] | None = None,
) -> list[Outcome]:
    """Draw joints and run ``pi``, ``oracle`` and ``adaptive`` on each.

    Parameters
    ----------
    scenario : Scenario
        What the joints are drawn around, and the ranges.
    runs : int
        Number of draws, refused ones included.
    seed : int, optional
        Seed of the draws; each draw depends on it and on its number only, not on the workers.
    executor : concurrent.futures.Executor, optional
        Where the runs go, such as that of a cluster; by default processes on all cores.
    progress : callable, optional
        Is called with the share done, from 0 to 1.

    Returns
    -------
    list of Outcome
        One a draw, in order.

    Raises
    ------
    ValueError
        The number of runs is not positive.
    """
    if runs < 1:
        raise ValueError(f"runs = {runs} is not allowed: it must be at least 1")
    outcomes = [run_draw(scenario, seed, 0)]  # here, so that workers find the controllers compiled
    if outcomes[0].refused:
        simulate(scenario.modified(duration=1.0, change=[]), "adaptive")
    pool = ProcessPoolExecutor(os.cpu_count()) if executor is None else executor
    try:
        batches = [list(range(first, min(first + BATCH, runs))) for first in range(1, runs, BATCH)]
        for batch in pool.map(_run_batch, [scenario] * len(batches), [seed] * len(batches), batches):
            outcomes.extend(batch)
            if progress is not None:
                progress(len(outcomes) / runs)
    finally:
        if executor is None:
            pool.shutdown(cancel_futures=True)
    return outcomes


QUANTITIES = {
    "improvement": "settled: pi / adaptive",
    "share_of_oracle": "settled: oracle / adaptive",
    "whole_run": "whole run: adaptive / pi",
    "start": "first 5 s: adaptive / pi",
    "torque_variation": "sum |du|: adaptive / oracle",
}
"""What a sweep reports, with a name for people."""

QUANTILES = (0.0, 0.005, 0.05, 0.5, 0.95, 0.995, 1.0)


def quantities(outcome: Outcome) -> dict[str, float]:
    """Return what a sweep reports of one joint."""
    return {
        "improvement": outcome.ratio("rms_error_settled", "pi", "adaptive"),
        "share_of_oracle": outcome.ratio("rms_error_settled", "oracle", "adaptive"),
        "whole_run": outcome.ratio("rms_error", "adaptive", "pi"),
        "start": outcome.ratio("rms_error_start", "adaptive", "pi"),
        "torque_variation": outcome.ratio("torque_variation", "adaptive", "oracle"),
    }


def summary(outcomes: list[Outcome], seed: int, worst: int = 3) -> dict[str, Any]:
    """Return the result of a sweep as ``--json`` writes it.

    Parameters
    ----------
    outcomes : list of Outcome
        The outcomes.
    seed : int
        Seed of the sweep.
    worst : int, optional
        Number of worst cases (by whole-run error against ``pi``) to report.
    """
    run = [outcome for outcome in outcomes if not outcome.refused]
    values = {outcome.draw: quantities(outcome) for outcome in run}
    quantiles = {
        name: dict(
            zip(map(str, QUANTILES), np.quantile([v[name] for v in values.values()], QUANTILES).tolist(), strict=True)
        )
        for name in (QUANTITIES if values else ())
    }
    ranked = sorted(run, key=lambda outcome: -values[outcome.draw]["whole_run"])
    return {
        "seed": seed,
        "draws": len(outcomes),
        "refused": len(outcomes) - len(run),
        "quantiles": quantiles,
        "worse_than_pi": sum(v["whole_run"] > 1.05 for v in values.values()) / max(1, len(values)),
        "worst": [
            {
                "draw": outcome.draw,
                **values[outcome.draw],
                "controllers": {name: asdict(metrics) for name, metrics in outcome.metrics.items()},
            }
            for outcome in islice(ranked, worst)
        ],
    }
