"""Monte Carlo: how good is the adaptive controller on joints drawn at random."""

import math
from collections.abc import Callable, Iterator, Mapping, Sequence
from concurrent.futures import Executor, as_completed
from contextlib import suppress
from dataclasses import asdict
from itertools import islice
from pathlib import Path
from typing import Any

import numpy as np

from adaptive_ff.comparison.outcomes import KeptOutcomes, Outcome
from adaptive_ff.comparison.own import Own, can_be_sent, check_own_names, make_own
from adaptive_ff.comparison.registry import CONTROLLERS as REGISTERED
from adaptive_ff.comparison.registry import loop_of
from adaptive_ff.comparison.run import simulate
from adaptive_ff.errors import InputError
from adaptive_ff.scenario.given import check_scenario
from adaptive_ff.scenario.scenario import Scenario
from adaptive_ff.scenario.series import largest_size
from adaptive_ff.simulation.experiment import lay_course
from adaptive_ff.workers import pool_of_workers
from plant import AnyJoint, check_factor, schedule, steepest_fall

CONTROLLERS = ("pi", "oracle", "adaptive")

CLASSES = {
    "up to 0.5 Kp": 0.0,
    "0.5 to 1 Kp": 0.5,
    "1 to 2 Kp": 1.0,
    "2 to 5 Kp": 2.0,
    "5 to 10 Kp": 5.0,
    "10 to 20 Kp": 10.0,
    "above 20 Kp": 20.0,
}
"""Classes of joints by how steeply friction falls, over the proportional gain: each from its number on."""

HUNTING = 1.0
"""Fall of the friction over the proportional gain from which PI itself hunts at low speed."""

FINEST = 64
"""Largest number of parts that the scenario's solver period is cut into for a drawn joint."""

BATCH = 8
"""Joints handed to a worker at a time."""


def draw_scenario(scenario: Scenario, seed: int, draw: int) -> Scenario:
    """Draw a joint and what the controllers assume of it.

    The PI loop is redesigned for the assumed inertia with the scenario's bandwidth; the torque limit grows with the
    largest torque that the reference needs. A joint that the solver period is too long for gets a shorter one.

    Raises
    ------
    InputError
        No solver period is short enough for the joint.
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
        feedback = {"inertia": assumed_inertia, "bandwidth": scenario.feedback.hertz}
    own_seed, limit = int(generator.integers(2**31)), scenario.actuator.torque_limit
    drawn = drawn_joint(scenario, table)
    table["solver_period"] = scenario.joint.solver_period if drawn is None else drawn.solver_period
    drive = {}
    if drawn is not None and limit is not None:  # a copy without checks: of it only the needed torque is asked for
        alike = scenario.model_copy(update={"seed": own_seed, "joint": drawn})
        drive = {"actuator": {"torque_limit": limit * needed_torque(alike) / needed_torque(scenario)}}
    return scenario.modified(
        seed=own_seed,
        controllers=list(CONTROLLERS),
        joint=table,
        sensor={"velocity_noise": noise},
        feedback=feedback,
        adaptation={"stribeck_velocity": assumed_velocity},
        **drive,
    )


def drawn_joint(scenario: Scenario, table: dict[str, float]) -> AnyJoint | None:
    """Return a scenario's joint with other fields, and the longest part of its solver period that leaves one solution.

    None where the step of the joint is ambiguous even with the shortest part; what makes a scenario of it says why.
    """
    period: float = scenario.joint.solver_period
    fields = {**scenario.joint.model_dump(exclude_unset=True), **table}
    for parts in (2**power for power in range(FINEST.bit_length())):
        try:
            joint = type(scenario.joint)(**{**fields, "solver_period": period / parts})
            plan = schedule(scenario.change, period / parts, scenario.variation)
            check_factor(joint.parameters, plan, period / parts, joint.weight.amplitude)
        except ValueError:
            continue
        return joint
    return None


def fall_over_gain(scenario: Scenario) -> float:
    """Return how steeply friction falls at worst, over the proportional gain; from one on, PI itself hunts."""
    steepest = max(map(steepest_fall, (scenario.joint.friction, scenario.joint.friction_backward)))
    return float(steepest / scenario.feedback.gains[0])


def class_of(fall: float) -> str:
    """Return the class of a joint whose friction falls by a multiple of the proportional gain."""
    return [name for name, least in CLASSES.items() if fall >= least][-1]


def needed_torque(scenario: Scenario) -> float:
    """Return a bound on the torque that the reference needs, N m."""
    joint, reference = scenario.joint, scenario.reference_velocity()
    fastest = largest_size(np.diff(reference)) / joint.solver_period
    friction = max(joint.stiction, joint.coulomb + joint.viscous * largest_size(reference))
    return joint.inertia * fastest + friction


def run_draw(scenario: Scenario, seed: int, draw: int, further: Mapping[str, Own | None] | None = None) -> Outcome:
    """Draw a joint and run the controllers on it, and further ones: own ones, or by name alone those of the package."""
    try:
        drawn = draw_scenario(scenario, seed, draw)
    except InputError as error:
        return Outcome(draw, {}, str(error))
    course = lay_course(drawn)
    metrics = {name: simulate(drawn, name, course=course, uncertain=False).metrics for name in CONTROLLERS}
    for name, one in (further or {}).items():
        with suppress(ArithmeticError):  # it may fail on a joint; it then has no figures there
            made = name if one is None else make_own(name, one, drawn)
            metrics[name] = simulate(drawn, made, name=name, course=course, uncertain=False).metrics
    return Outcome(draw, metrics, fall=fall_over_gain(drawn))


def _run_batch(scenario: Scenario, seed: int, draws: list[int], further: Mapping[str, Own | None]) -> list[Outcome]:
    return [run_draw(scenario, seed, draw, further) for draw in draws]


def sweep(
    scenario: Scenario,
    runs: int,
    seed: int = 1,
    *,
    own: Mapping[str, Own] | None = None,
    rivals: Sequence[str] = (),
    folder: Path | None = None,
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
    own : mapping, optional
        Own controllers by name that are run, too; see :func:`adaptive_ff.comparison.own.make_own`.
    rivals : sequence of str, optional
        Names of further controllers of the package that are run, too.
    folder : Path, optional
        Where outcomes are kept as they come, so that a call that was interrupted goes on where it stopped.
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
    InputError
        The scenario leaves the bandwidth open, or there is no controller of a name.
    """
    check_scenario(scenario)
    if runs < 1:
        raise ValueError(f"runs = {runs} is not allowed: it must be at least 1")
    if scenario.feedback.is_auto:
        raise InputError("feedback.bandwidth = 'auto' is not allowed for a sweep: all joints share one; give a number")
    check_own_names(own or {}, REGISTERED)
    for name in rivals:
        loop_of(scenario, name)
    further: dict[str, Own | None] = {name: None for name in rivals if name not in CONTROLLERS} | dict(own or {})
    kept = KeptOutcomes(folder, scenario, seed, further)
    outcomes = {draw: outcome for draw, outcome in kept.read().items() if draw < runs}
    for batch in _run(scenario, seed, [draw for draw in range(runs) if draw not in outcomes], further, executor):
        outcomes |= {outcome.draw: outcome for outcome in batch}
        kept.add(batch)
        if progress is not None:
            progress(len(outcomes) / runs)
    return [outcomes[draw] for draw in range(runs)]


def _run(
    scenario: Scenario, seed: int, draws: list[int], further: Mapping[str, Own | None], executor: Executor | None
) -> Iterator[list[Outcome]]:
    """Yield the outcomes of draws, in batches as they come."""
    if not draws:
        return
    first = run_draw(scenario, seed, draws[0], further)  # here, so that workers find the controllers compiled
    if first.refused:
        simulate(scenario.modified(duration=1.0, change=[]), "adaptive")
    yield [first]
    batches = [draws[start : start + BATCH] for start in range(1, len(draws), BATCH)]
    if executor is None and not can_be_sent(further):
        yield from (_run_batch(scenario, seed, batch, further) for batch in batches)
        return
    pool = pool_of_workers() if executor is None else executor
    try:
        for done in as_completed([pool.submit(_run_batch, scenario, seed, batch, further) for batch in batches]):
            yield done.result()
    finally:
        if executor is None:
            pool.shutdown(cancel_futures=True)


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


def _classes(run: list[Outcome], values: dict[int, dict[str, float]]) -> dict[str, dict[str, float]]:
    """Return figures of the joints of each class that has any."""
    found = {}
    for name in CLASSES:
        chosen = [values[outcome.draw] for outcome in run if class_of(outcome.fall) == name]
        if chosen:
            settled = [value["improvement"] for value in chosen]
            found[name] = {
                "joints": len(chosen),
                "improvement": float(np.median(settled)),
                "least_improvement": min(settled),
                "start": float(np.median([value["start"] for value in chosen])),
                "worse_settled": sum(value < 1.0 for value in settled),
                "worse_whole_run": sum(value["whole_run"] > 1.05 for value in chosen),
            }
    return found


def own_summary(run: list[Outcome], name: str) -> dict[str, Any]:
    """Return how an own controller fared: joints on which it did not stay finite, and quantiles of its figures."""
    ran = [outcome for outcome in run if name in outcome.metrics]
    ratios = {
        "improvement": [outcome.ratio("rms_error_settled", "pi", name) for outcome in ran],
        "whole_run": [outcome.ratio("rms_error", name, "pi") for outcome in ran],
    }
    found: dict[str, Any] = {"failed": len(run) - len(ran)}
    if ran:
        for key, values in ratios.items():
            found[key] = dict(zip(map(str, QUANTILES), np.quantile(values, QUANTILES).tolist(), strict=True))
    return found


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
    own = dict.fromkeys(name for outcome in run for name in outcome.metrics if name not in CONTROLLERS)
    ranked = sorted(run, key=lambda outcome: -values[outcome.draw]["whole_run"])
    return {
        "seed": seed,
        "draws": len(outcomes),
        "refused": len(outcomes) - len(run),
        "quantiles": quantiles,
        "own": {name: own_summary(run, name) for name in own},
        "classes": _classes(run, values),
        "pi_hunts": sum(outcome.fall > HUNTING for outcome in run),
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
