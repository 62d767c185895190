"""Whether a restored state is one that an adaptive controller can have come to."""

from typing import Any

import numpy as np

from adaptive_ff.adaptive.state import AdaptiveParameters, AdaptiveState
from adaptive_ff.learning.kalman import LOOP
from controllers.plausibility import LARGEST_VELOCITY, MOST_TIME, largest_torque

ROUNDING = 1e-9
"""How far an estimate may lie beyond its range, relative to it."""

SIZES = ("held", "steady", "sliding")
"""Torques of the state, N m."""


def check_adaptive_state(parameters: AdaptiveParameters, state: AdaptiveState) -> None:
    """Raise ``ValueError`` where a controller cannot have come to a state.

    Every number must be finite, a probability or gain from 0 to 1, a square not negative, a torque plausible, and an
    estimate within its bounds; that covariances are symmetric and positive semi-definite is checked for every state.
    """
    largest = largest_torque(parameters.feedback.proportional, parameters.feedback.integral)
    _check_finite(state, "state")
    for name, value in (("weight", state.weight), ("fed_gain", state.fed_gain), ("observer.gain", state.observer.gain)):
        if not 0.0 <= value <= 1.0:
            raise ValueError(f"state.{name} = {value} is not allowed: it must be from 0 to 1")
    squares = {"error": state.observer.error, "brought": state.observer.brought, "means": state.noise.means}
    for name, value in squares.items():
        if value < 0.0:
            raise ValueError(f"state: {name} = {value} is not allowed: it must be zero or more")
    torques = {name: getattr(state, name) for name in SIZES} | {"observer.torque": state.observer.torque}
    for name, value in torques.items():
        if abs(value) > largest:
            raise ValueError(f"state.{name} = {value} N m is not allowed: at most {largest:g} is plausible")
    if not 0.0 < state.unit <= largest:
        raise ValueError(f"state.unit = {state.unit} N m is not allowed: it must be above 0 and at most {largest:g}")
    for name in ("filtered", "last_reference"):
        if abs(getattr(state, name)) > LARGEST_VELOCITY:
            raise ValueError(
                f"state.{name} = {getattr(state, name)} is not allowed: at most {LARGEST_VELOCITY:g} rad/s"
            )
    interval, span = state.interval, parameters.machine.span
    longest = MOST_TIME * parameters.period * span
    if not (0 <= interval.samples <= span and 0.0 <= interval.duration <= longest):
        raise ValueError(f"state.interval is not allowed: samples = {interval.samples} must be from 0 to {span}")
    for name, array in {**state.response._asdict(), "psi": state.psi, "sums": state.sums}.items():
        if np.any(np.abs(array) > largest):
            raise ValueError(f"state: {name} is not allowed: its numbers must be at most {largest:g}")
    if np.any(np.abs(state.estimate.covariance) > largest * largest):
        raise ValueError(f"state.estimate.covariance is not allowed: no deviation is beyond {largest:g}")
    friction = state.friction
    follows = any(np.any(np.abs(part) > 1.0 / ROUNDING) for part in (friction.lagged, friction.bent))
    if follows or max(abs(friction.direction), abs(friction.held)) > 1.0:
        raise ValueError("state.friction is not allowed: what follows a lag or a path is of the size of one")
    coefficients = state.estimate.mean[LOOP:]
    lowest, highest = parameters.prior.lowest, parameters.prior.highest
    slack = ROUNDING * np.maximum(1.0, np.abs(coefficients))
    outside = (coefficients < lowest - slack) | (coefficients > highest + slack)
    outside[:-2] |= np.abs(coefficients[:-2]) > largest
    if np.any(outside):
        place = int(np.argmax(outside))
        raise ValueError(
            f"state.estimate.mean[{LOOP + place}] = {coefficients[place]} is not allowed: "
            f"it must be from {lowest[place]:g} to {min(highest[place], largest):g}"
        )


def _check_finite(value: Any, where: str) -> None:
    for key, item in value._asdict().items():
        if hasattr(item, "_asdict"):
            _check_finite(item, f"{where}.{key}")
        elif not np.all(np.isfinite(np.asarray(item, dtype=np.float64))):
            raise ValueError(f"{where}.{key} is not allowed: its numbers must be finite")
