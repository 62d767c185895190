"""Synthetic logs with known truth, as ``identify`` finds them."""

from functools import partial
from typing import Any

from adaptive_ff.studies.study import Found
from benchmarks.coverage import HALVES, NAMES
from benchmarks.coverage import examine_seed as drawn_pair
from benchmarks.coverage_driven import examine_seed as driven_log
from benchmarks.suite import Case


def figures_of(logs: list[dict[str, Any]]) -> dict[str, list[float]]:
    """Return the figures of logs that were not refused.

    For each parameter the ``error`` over its true value, ``width`` of half the interval over it, and ``inside``, one
    where the interval holds the truth, else zero; ``seconds`` of the identification.
    """
    figures: dict[str, list[float]] = {"seconds": [log["seconds"] for log in logs]}
    for name in NAMES:
        found = [log[name] for log in logs if name in log]
        figures[f"{name}_error"] = [one["error"] for one in found]
        figures[f"{name}_width"] = [one["half_width"] for one in found]
        figures[f"{name}_inside"] = [float(one["covers"]) for one in found]
    return figures


def run_drawn(seed: int, controllers: list[str]) -> Found:
    """Identify both records of a drawn joint."""
    logs = drawn_pair(seed)
    taken = [log for log in logs if log["refused"] is None]
    figures = {"refused": float(len(logs) - len(taken)), **figures_of(taken)}
    return {"": {"row": HALVES[seed % 2]}, **dict.fromkeys(controllers, figures)}


def run_driven(seed: int, controllers: list[str]) -> Found:
    """Identify the log of a joint that sticks under PI alone."""
    log = driven_log(seed)
    taken = [log] if log["refused"] is None else []
    figures = {"refused": 1.0 - len(taken), **figures_of(taken)}
    return {"": {"row": f"under PI alone, {log['kind']}"}, **dict.fromkeys(controllers, figures)}


def drawn(count: int, first: int = 10_000) -> list[Case]:
    """Return drawn joints with two records each."""
    return [Case(f"drawn/{seed}", seed, partial(run_drawn, seed)) for seed in range(first, first + count)]


def driven(count: int, first: int = 1) -> list[Case]:
    """Return joints of another simulator that stick under PI alone."""
    return [Case(f"driven/{seed}", seed, partial(run_driven, seed)) for seed in range(first, first + count)]
