"""Whether a restored state is one that an adaptive controller can have come to."""

import math
from typing import Any

import numpy as np

from adaptive_ff.adaptive.candidate_state import CandidateState
from adaptive_ff.adaptive.candidates import candidate_distance, candidate_velocity
from adaptive_ff.adaptive.estimator import PEAK_FACTOR
from adaptive_ff.adaptive.estimator_state import EstimatorParameters, EstimatorState, load_count
from adaptive_ff.model.bounds import write_ranges

ROUNDING = 1e-9
"""How far an estimate may lie beyond its range, relative to it."""


def check_estimator_state(estimator: EstimatorParameters, state: EstimatorState, largest: float) -> None:
    """Raise ``ValueError`` where an estimator cannot have come to a state.

    Parameters
    ----------
    estimator : EstimatorParameters
        Its parameters.
    state : EstimatorState
        The state.
    largest : float
        Largest plausible torque, N m.
    """
    levels = state.levels
    for name, value in levels._asdict().items():
        if value < 0.0:
            raise ValueError(f"state.estimator.levels.{name} = {value} is not allowed: it must be zero or more")
    if levels.torque > largest:
        raise ValueError(f"state.estimator.levels.torque = {levels.torque} is not allowed: at most {largest:g} N m")
    if levels.learnt > 0.0 and levels.speed <= 0.0:
        raise ValueError("state.estimator.levels.speed = 0 is not allowed of an estimator that has learnt")
    ranges = np.array(estimator.ranges)
    if levels.learnt > 0.0 and levels.speed > 0.0:
        write_ranges(
            estimator.ranges, PEAK_FACTOR * max(levels.torque, 0.0), levels.speed, ranges, load_count(estimator)
        )
        # peaks fade, and estimates follow only where they are learnt: a factor lies between
        ranges[1:] *= np.where(np.isfinite(ranges[1:]), 10.0, 1.0)
    estimate = state.recursion.estimate
    slack = ROUNDING * np.abs(ranges)
    outside = (estimate < ranges[:, 0] - slack[:, 0]) | (estimate > ranges[:, 1] + slack[:, 1])
    if np.any(outside & (estimate != estimator.first)):
        place = int(np.argmax(outside))
        raise ValueError(
            f"state.estimator.recursion.estimate[{place}] = {estimate[place]} is not allowed: "
            f"it must be from {ranges[place, 0]:g} to {ranges[place, 1]:g}"
        )


def check_candidate_state(estimator: EstimatorParameters, state: CandidateState) -> None:
    """Raise ``ValueError`` where the candidates of an estimator cannot have come to a state."""
    count = estimator.candidates.size + estimator.presliding.size
    for name in ("chosen", "turn"):
        place = getattr(state, name)
        if not 0 <= place < max(count, 1):
            raise ValueError(f"state.estimator.candidates.{name} = {place} is not allowed: there are {count}")
    wanted = {"stribeck_velocity": estimator.begin, "presliding": 0.0}
    if count > 0:
        wanted["stribeck_velocity"] = candidate_velocity(estimator, state.chosen)
        wanted["presliding"] = candidate_distance(estimator, state.chosen)
    for name, value in wanted.items():
        found = getattr(state, name)
        if not math.isclose(found, value, rel_tol=ROUNDING):
            raise ValueError(
                f"state.estimator.candidates.{name} = {found} is not allowed: that of the candidate in use is {value:g}"
            )
    if state.seen < 0.0 or state.waited < 0.0 or np.any(state.errors < 0.0):
        raise ValueError("state.estimator.candidates is not allowed: times and mean squares must be zero or more")


def check_share(name: str, value: Any) -> None:
    """Raise ``ValueError`` where a share is not from 0 to 1."""
    if not (math.isfinite(value) and 0.0 <= value <= 1.0):
        raise ValueError(f"state.{name} = {value} is not allowed: it must be from 0 to 1")
