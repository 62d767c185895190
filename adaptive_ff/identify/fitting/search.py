"""The search for a friction lag and a speed at which friction bends: least squares by steps of Gauss and Newton."""

import math
from collections.abc import Mapping

import numpy as np

from adaptive_ff.identify.fitting.fitted import LOGARITHMIC, Fitted
from adaptive_ff.identify.rows.regressors import Problem, design, measured_torque
from adaptive_ff.identify.terms import BENT
from adaptive_ff.logs.derivatives import Array

INSIDE = 1e-3
"""Distance of the start of a search from the ends of the range, over the range."""

STEPS, LONGEST, CLOSE = 12, 0.05, 1e-4
"""Steps of the search at most, and the longest and shortest of them, over the range."""

SLOPE_STEP = 1e-4
"""Step of the difference quotients by a searched parameter, over its range."""


def lag_profile(problem: Problem, fitted: Fitted, lags: Array) -> Array:
    """Return the relative error of the torque over friction lags (s), all linear terms fitted anew at each."""
    target = measured_torque(problem)
    others = {name: value for name, value in fitted.searched.items() if name != "friction_lag"}
    errors: list[float] = []
    for lag in lags.tolist():
        matrix = design(problem, fitted.linear, {**others, "friction_lag": lag})
        errors.append(float(np.linalg.norm(left_by_linear_terms(matrix, target)) / np.linalg.norm(target)))
    return np.array(errors)


def _ranges(problem: Problem, names: list[str]) -> list[tuple[float, float]]:
    """Return where each searched parameter is looked for, the Stribeck velocity as a logarithm."""
    known = {"friction_lag": (-problem.longest_lag, problem.longest_lag)}
    for term, speeds in problem.speeds.items():
        known[BENT[term]] = (math.log(speeds[0]), math.log(speeds[-1]))
    return [known[name] for name in names]


def searched_values(names: list[str], point: Array) -> dict[str, float]:
    """Return the searched parameters by name; those that are searched as logarithms as they are."""
    pairs = zip(names, point.tolist(), strict=True)
    return {name: math.exp(value) if name in LOGARITHMIC else value for name, value in pairs}


def search(problem: Problem, linear: list[str], names: list[str], target: Array, start: Mapping[str, float]) -> Array:
    """Return the searched parameters at the least squares, by steps of Gauss and Newton within their ranges."""
    if not names:
        return np.empty(0)
    low, high = np.array(_ranges(problem, names)).T
    span = high - low
    point = np.array([math.log(start[name]) if name in BENT.values() else start[name] for name in names])
    point = np.clip(point, low + INSIDE * span, high - INSIDE * span)
    squares = math.inf
    step = np.zeros_like(point)
    for _ in range(STEPS):
        matrix = design(problem, linear, searched_values(names, point))
        values = _solve(matrix, target)
        residual = target - matrix @ values
        now = float(residual @ residual)
        if now > squares:  # too far: back by half
            step *= 0.5
            point = point - step
            continue
        squares = now
        slopes = [slope_by(problem, linear, names, point, values, place) for place in range(len(names))]
        solved = _solve(np.column_stack([matrix, *slopes]), residual)
        step = np.clip(point + np.clip(solved[len(linear) :], -LONGEST * span, LONGEST * span), low, high) - point
        if np.all(np.abs(step) < CLOSE * span):
            break
        point = point + step
    return np.asarray(point)


def _solve(matrix: Array, target: Array) -> Array:
    """Return the least squares by scaled normal equations: good enough to search with, and quick."""
    scale = np.linalg.norm(matrix, axis=0)
    scale[scale == 0.0] = 1.0
    scaled = matrix / scale
    solved: Array = np.linalg.lstsq(scaled.T @ scaled, scaled.T @ target, rcond=1e-13)[0] / scale
    return solved


def left_by_linear_terms(matrix: Array, target: Array) -> Array:
    """Return what the least squares of the columns leave of a series."""
    residual: Array = target - matrix @ _solve(matrix, target)
    return residual


def slope_by(problem: Problem, linear: list[str], names: list[str], point: Array, values: Array, place: int) -> Array:
    """Return the derivative of the fitted torque by a searched parameter, the linear ones held."""
    low, high = _ranges(problem, names)[place]
    step = np.zeros_like(point)
    step[place] = SLOPE_STEP * (high - low)
    after, before = (design(problem, linear, searched_values(names, point + side * step)) for side in (1.0, -1.0))
    slope: Array = (after - before) @ values / (2.0 * step[place])
    return slope
