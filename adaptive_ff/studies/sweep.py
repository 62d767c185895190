"""Monte Carlo: how good is the adaptive controller on joints drawn at random."""

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

from adaptive_ff.comparison.own import Own, can_be_sent, check_own_names, own_mark
from adaptive_ff.comparison.reference_lines import run_by_name
from adaptive_ff.comparison.registry import CONTROLLERS as REGISTERED
from adaptive_ff.comparison.registry import loop_of
from adaptive_ff.errors import InputError
from adaptive_ff.scenario.scenario import Scenario, check_scenario
from adaptive_ff.simulation.experiment import build_setup
from adaptive_ff.simulation.metrics import Metrics
from adaptive_ff.studies.drawn_joints import CLASSES, CONTROLLERS, HUNTING, class_of, draw_scenario, fall_over_gain
from adaptive_ff.studies.study import Found, Store, code_digest, run_study


@dataclass(frozen=True)
class Outcome:
    """One drawn joint."""

    draw: int  # number of the draw; with the seed of the sweep it gives the joint
    metrics: dict[str, Metrics]  # figures of merit by controller; empty where the draw was refused
    refused: str = ""  # why it was not run, empty where it was
    fall: float = math.nan  # steepest fall of its friction over the proportional gain

    def ratio(self, figure: str, controller: str, to: str) -> float:
        """Return a figure of merit of one controller over that of another."""
        top: float = getattr(self.metrics[controller], figure)
        bottom: float = getattr(self.metrics[to], figure)
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
        marks = {name: own_mark(one) for name, one in own.items()}
        store = Store(folder / f"sweep-{seed}.jsonl", hashlib.sha256(mark.encode()).hexdigest(), marks)
    found = run_study(
        partial(run_draw, scenario, seed, own),
        {str(draw): draw for draw in range(runs)},
        list(dict.fromkeys([*CONTROLLERS, *further, *own])),
        store=store,
        executor=executor,
        workers=None if can_be_sent(own) else 1,
        threads=not own,
        progress=progress,
    )
    return [_outcome(draw, found[str(draw)]) for draw in range(runs)]


def _outcome(draw: int, found: Found) -> Outcome:
    about = found[""]
    metrics = {name: Metrics(**figures) for name, figures in found.items() if name and figures is not None}
    return Outcome(draw, metrics, about.get("refused", ""), about.get("fall", math.nan))


def refusals(outcomes: Sequence[Outcome]) -> dict[str, int]:
    """Return how often joints were refused, by reason; numbers in it are those of the first."""
    kinds: dict[str, str] = {}
    count: Counter[str] = Counter()
    for outcome in outcomes:
        if outcome.refused:
            kind = re.sub(r"[-+.\de]*\d[-+.\de]*", "#", outcome.refused)
            count[kinds.setdefault(kind, outcome.refused)] += 1
    return dict(count.most_common())


QUANTITIES = {
    "improvement": ("rms_error_settled", "pi", "adaptive"),
    "share_of_oracle": ("rms_error_settled", "oracle", "adaptive"),
    "whole_run": ("rms_error", "adaptive", "pi"),
    "start": ("rms_error_start", "adaptive", "pi"),
    "torque_variation": ("torque_variation", "adaptive", "oracle"),
}
"""What a sweep reports of each joint: a figure of one controller over that of another."""

WORST = 3
"""Worst cases that it lists."""

QUANTILES = (0.0, 0.005, 0.05, 0.5, 0.95, 0.995, 1.0)


def quantities(outcome: Outcome, controller: str = "adaptive", names: Iterable[str] = QUANTITIES) -> dict[str, float]:
    """Return what a sweep reports of one joint, of a controller in the place of ``adaptive``."""
    chosen = {name: QUANTITIES[name] for name in names}
    return {
        name: outcome.ratio(figure, *(controller if one == "adaptive" else one for one in pair))
        for name, (figure, *pair) in chosen.items()
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
    values = [quantities(outcome, name, ("improvement", "whole_run")) for outcome in ran]
    return {"failed": len(run) - len(ran), **_quantiles(values)}


def summary(outcomes: list[Outcome], seed: int) -> dict[str, Any]:
    """Return the result of a sweep as ``--json`` writes it, with some worst cases by whole-run error against ``pi``."""
    run = [outcome for outcome in outcomes if not outcome.refused]
    values = {outcome.draw: quantities(outcome) for outcome in run}
    own = dict.fromkeys(name for outcome in run for name in outcome.metrics if name not in CONTROLLERS)
    ranked = sorted(run, key=lambda outcome: -values[outcome.draw]["whole_run"])
    return {
        "seed": seed,
        "draws": len(outcomes),
        "refused": len(outcomes) - len(run),
        "quantiles": _quantiles(list(values.values())),
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
            for outcome in ranked[:WORST]
        ],
    }
