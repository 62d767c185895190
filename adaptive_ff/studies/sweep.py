"""Monte Carlo: how good controllers are on joints drawn at random around that of a scenario, and classes of them."""

import hashlib
import math
import re
from collections import Counter
from collections.abc import Callable, Iterable, Mapping, Sequence
from concurrent.futures import Executor
from contextlib import suppress
from dataclasses import asdict, dataclass
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np

from adaptive_ff.comparison.own import Own, check_own_names, own_marks, workers_for
from adaptive_ff.comparison.registry import CONTROLLERS as REGISTERED
from adaptive_ff.comparison.registry import loop_of
from adaptive_ff.comparison.run import run_by_name
from adaptive_ff.errors import InputError
from adaptive_ff.scenario.loop import HUNTING, fall_over_gain
from adaptive_ff.scenario.scenario import Scenario, check_scenario
from adaptive_ff.scenario.series import largest_size
from adaptive_ff.simulation.experiment import build_setup
from adaptive_ff.simulation.metrics import Metrics
from adaptive_ff.studies.study import Found, Store, code_digest, run_study
from plant import AnyJoint, check_factor, schedule

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

FINEST = 64  # largest number of parts that the scenario's solver period is cut into for a drawn joint


def draw_scenario(scenario: Scenario, seed: int, draw: int) -> Scenario:
    """Draw a joint and what the controllers assume of it.

    The PI loop is redesigned for the assumed inertia with the scenario's bandwidth; the torque limit grows with the
    largest torque that the reference needs. A joint that the solver period is too long for gets a shorter one. An
    encoder keeps its resolution, and gets no noise of the velocity beside it.
    """
    generator = np.random.default_rng([seed, draw])
    ranges, joint, feedback = scenario.sweep, scenario.joint, scenario.feedback

    def even(bounds: list[float]) -> float:
        return float(generator.uniform(bounds[0], bounds[1]))

    def logarithmic(bounds: list[float]) -> float:
        return float(np.exp(generator.uniform(math.log(bounds[0]), math.log(bounds[1]))))

    inertia = joint.inertia * logarithmic(ranges.inertia)
    coulomb, viscous = logarithmic(ranges.coulomb), logarithmic(ranges.viscous)
    stiction, lag = even(ranges.stiction), even(ranges.friction_lag)
    table, curves = {"inertia": inertia}, {"": joint.friction}
    if joint.friction_backward != joint.friction:
        curves["_backward"] = joint.friction_backward
    for ending, curve in curves.items():
        table[f"coulomb{ending}"] = curve.coulomb * coulomb
        table[f"viscous{ending}"] = curve.viscous * viscous
        table[f"stiction{ending}"] = curve.coulomb * coulomb * stiction
    if "friction_lag" in type(joint).model_fields:
        table["friction_lag"] = lag
    noise = even(ranges.velocity_noise)
    assumed_velocity = joint.stribeck_velocity * logarithmic(ranges.assumed_stribeck_velocity)
    assumed_inertia = inertia * logarithmic(ranges.assumed_inertia)
    loop = {"inertia": assumed_inertia, "bandwidth": feedback.hertz}
    if feedback.bandwidth is None:
        gains = (assumed_inertia / feedback.inertia * gain for gain in feedback.gains)
        loop = {"inertia": assumed_inertia, **dict(zip(("proportional", "integral"), gains, strict=True))}
    own_seed, limit = int(generator.integers(2**31)), scenario.actuator.torque_limit
    drawn, changed = drawn_joint(scenario, table), {}
    table["solver_period"] = joint.solver_period if drawn is None else drawn.solver_period
    if scenario.sensor.encoder_resolution is None:
        changed["sensor"] = {"velocity_noise": noise}
    if drawn is not None and limit is not None:  # a copy without checks: of it only the needed torque is asked for
        alike = scenario.model_copy(update={"seed": own_seed, "joint": drawn})
        changed["actuator"] = {"torque_limit": limit * needed_torque(alike) / needed_torque(scenario)}
    assumed = {"stribeck_velocity": assumed_velocity}
    given = {"seed": own_seed, "controllers": list(CONTROLLERS), "joint": table, "feedback": loop}
    return scenario.modified(**given, adaptation=assumed, **changed)


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


def class_of(fall: float) -> str:
    """Return the class of a joint whose friction falls by a multiple of the proportional gain."""
    return [name for name, least in CLASSES.items() if fall >= least][-1]


def needed_torque(scenario: Scenario) -> float:
    """Return a bound on the torque that the reference needs, N m."""
    joint, reference = scenario.joint, scenario.reference_velocity()
    fastest = largest_size(np.diff(reference)) / joint.solver_period
    friction = max(joint.stiction, joint.coulomb + joint.viscous * largest_size(reference))
    return joint.inertia * fastest + friction


@dataclass(frozen=True)
class Outcome:
    """One drawn joint."""

    draw: int  # number of the draw; with the seed of the sweep it gives the joint
    metrics: dict[str, Metrics]  # figures of merit by controller; empty where the draw was refused
    refused: str = ""  # why it was not run, empty where it was
    fall: float = math.nan  # steepest fall of its friction over the proportional gain

    def ratio(self, figure: str, controller: str, to: str) -> float:
        """Return a figure of merit of one controller over that of another."""
        top, bottom = (float(getattr(self.metrics[name], figure)) for name in (controller, to))
        return top / bottom


def run_draw(scenario: Scenario, seed: int, own: Mapping[str, Own], draw: int, controllers: Sequence[str]) -> Found:
    """Draw a joint and return the figures of controllers on it; None for one that did not keep the loop finite."""
    try:
        drawn = draw_scenario(scenario, seed, draw)
    except InputError as error:
        return {"": {"refused": str(error)}, **dict.fromkeys(controllers)}
    setup = build_setup(drawn)
    found: Found = {"": {"fall": fall_over_gain(drawn)}, **dict.fromkeys(controllers)}
    for name in controllers:
        with suppress(*(() if name in CONTROLLERS else (ArithmeticError,))):
            found[name] = asdict(run_by_name(drawn, name, setup, own).metrics)
    return found


def sweep(
    scenario: Scenario,
    runs: int,
    seed: int = 1,
    *,
    own: Mapping[str, Own] | None = None,
    further: Sequence[str] = (),
    folder: Path | None = None,
    executor: Executor | None = None,
    progress: Callable[[float], None] | None = None,
) -> list[Outcome]:
    """Draw joints and run ``pi``, ``oracle`` and ``adaptive`` on each, with further controllers and own ones.

    A draw depends on the seed and on its number only, not on the workers. Outcomes are kept in the folder as they come,
    so that a call that was interrupted goes on where it stopped; refused draws count among the runs.
    """
    check_scenario(scenario)
    if runs < 1:
        raise ValueError(f"runs = {runs} is not allowed: it must be at least 1")
    if scenario.feedback.is_auto:
        raise InputError("feedback.bandwidth = 'auto' is not allowed for a sweep: all joints have one; give a number")
    own = own or {}
    check_own_names(own, REGISTERED)
    for name in further:
        loop_of(scenario, name)
    store = None
    if folder is not None:
        mark = f"{code_digest()} {scenario.model_dump_json()}"
        store = Store(folder / f"sweep-{seed}.jsonl", hashlib.sha256(mark.encode()).hexdigest(), own_marks(own))
    found = run_study(
        partial(run_draw, scenario, seed, own),
        {str(draw): draw for draw in range(runs)},
        list(dict.fromkeys([*CONTROLLERS, *further, *own])),
        store=store,
        executor=executor,
        workers=workers_for(own),
        threads=not own,
        progress=progress,
    )
    metrics = {
        key: {name: Metrics(**figures) for name, figures in one.items() if name and figures is not None}
        for key, one in found.items()
    }
    return [Outcome(draw, metrics[str(draw)], **found[str(draw)][""]) for draw in range(runs)]


def refusals(outcomes: Sequence[Outcome]) -> dict[str, int]:
    """Return how often joints were refused, by reason; numbers in it are those of the first."""
    first: dict[str, str] = {}
    kinds = {one.draw: re.sub(r"[-+.\de]*\d[-+.\de]*", "#", one.refused) for one in outcomes if one.refused}
    count = Counter(first.setdefault(kinds[one.draw], one.refused) for one in outcomes if one.refused)
    return dict(count.most_common())


QUANTITIES = {
    "improvement": ("rms_error_settled", "pi", "adaptive"),
    "share_of_oracle": ("rms_error_settled", "oracle", "adaptive"),
    "whole_run": ("rms_error", "adaptive", "pi"),
    "start": ("rms_error_start", "adaptive", "pi"),
    "torque_variation": ("torque_variation", "adaptive", "oracle"),
}
"""What a sweep reports of each joint: a figure of one controller over that of another."""

WORST = 3  # worst cases that it lists
QUANTILES = (0.0, 0.005, 0.05, 0.5, 0.95, 0.995, 1.0)


def quantities(outcome: Outcome, controller: str = "adaptive", names: Iterable[str] = QUANTITIES) -> dict[str, float]:
    """Return what a sweep reports of one joint, of a controller in the place of ``adaptive``."""
    return {
        name: outcome.ratio(figure, *(controller if one == "adaptive" else one for one in pair))
        for name, (figure, *pair) in QUANTITIES.items()
        if name in names
    }


def _quantiles(values: Sequence[dict[str, float]]) -> dict[str, dict[str, float]]:
    """Return quantiles of what is reported of several joints; empty without any."""
    found = {name: np.quantile([one[name] for one in values], QUANTILES).tolist() for name in (values or [{}])[0]}
    return {name: dict(zip(map(str, QUANTILES), levels, strict=True)) for name, levels in found.items()}


def _classes(run: list[Outcome], values: dict[int, dict[str, float]]) -> dict[str, dict[str, float]]:
    """Return figures of the joints of each class that has any."""
    found = {}
    for name in CLASSES:
        chosen = [values[outcome.draw] for outcome in run if class_of(outcome.fall) == name]
        settled, start, whole = ([one[key] for one in chosen] for key in ("improvement", "start", "whole_run"))
        if chosen:
            found[name] = {
                "joints": len(chosen),
                "improvement": float(np.median(settled)),
                "least_improvement": min(settled),
                "start": float(np.median(start)),
                "worse_settled": sum(value < 1.0 for value in settled),
                "worse_whole_run": sum(value > 1.05 for value in whole),
            }
    return found


def summary(outcomes: list[Outcome], seed: int) -> dict[str, Any]:
    """Return the result of a sweep as ``--json`` writes it, with some worst cases by whole-run error against ``pi``."""
    run = [outcome for outcome in outcomes if not outcome.refused]
    values = {outcome.draw: quantities(outcome) for outcome in run}
    own: dict[str, dict[str, Any]] = {}
    for name in dict.fromkeys(name for outcome in run for name in outcome.metrics if name not in CONTROLLERS):
        ran = [quantities(one, name, ("improvement", "whole_run")) for one in run if name in one.metrics]
        own[name] = {"failed": len(run) - len(ran), **_quantiles(ran)}  # where it did not stay finite
    ranked = sorted(run, key=lambda outcome: -values[outcome.draw]["whole_run"])
    return {
        "seed": seed,
        "draws": len(outcomes),
        "refused": len(outcomes) - len(run),
        "quantiles": _quantiles(list(values.values())),
        "own": own,
        "classes": _classes(run, values),
        "pi_hunts": sum(outcome.fall > HUNTING for outcome in run),
        "worse_than_pi": sum(v["whole_run"] > 1.05 for v in values.values()) / max(1, len(values)),
        "worst": [
            {
                "draw": outcome.draw,
                **values[outcome.draw],
                "controllers": {name: asdict(metrics) for name, metrics in outcome.metrics.items()},
            }
            for outcome in ranked[:WORST]
        ],
    }
