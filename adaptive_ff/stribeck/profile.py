"""The fit of a Stribeck curve and its intervals: search by Levenberg-Marquardt, profile likelihood.

An interval is where the sum of squares, minimised over all other parameters, stays below the bound of Student's t
(D. Bates, D. Watts, "Nonlinear Regression Analysis and Its Applications", Wiley, 1988, chapter 6). It needs no symmetry
and has no end where the data give none.
"""

import math
from typing import NamedTuple

import numpy as np
from scipy.optimize import least_squares

from adaptive_ff.stribeck.problem import (
    BEND,
    FLAT,
    Array,
    Points,
    Problem,
    Solved,
    bend_slopes,
    make_problem,
    solve_linear,
)

SHAPE_STARTS = (0.5, 1.0, 2.0, 4.0, 8.0)
"""Shape factors from which the search starts; of each, the best Stribeck velocity is followed to its minimum."""

VELOCITY_STARTS = 12
"""Number of Stribeck velocities that are tried, over the range of the points."""

FINE, COARSE = 1e-12, 1e-6
"""Tolerances of the search for the estimates, and for the ends of intervals."""

FARTHEST = 5.0
"""Natural logarithm of the factor beyond which the end of an interval counts as infinite; Vs and delta are searched as
far beyond the speeds of the points and one."""

END_TOLERANCE = 0.01
"""Error allowed in the distance between an estimate and the end of its interval, relative."""

LARGEST_STEPS = 40
"""Steps to the end of an interval."""


class _Trials:
    """Residuals of a problem and their slopes, as functions of what is searched."""

    def __init__(self, problem: Problem) -> None:
        self.problem = problem
        self.searched = np.isnan(problem.bend)
        low, high = float(problem.log_speed.min()), float(problem.log_speed.max())
        self.lowest = np.array([low - FARTHEST, -FARTHEST])[self.searched]
        self.highest = np.array([high + FARTHEST, FARTHEST])[self.searched]
        self._last: tuple[Array, Solved] | None = None

    def bend(self, free: Array) -> Array:
        bend = self.problem.bend.copy()
        bend[self.searched] = np.clip(free, self.lowest, self.highest)
        return bend

    def residuals(self, free: Array) -> Array:
        solved = solve_linear(self.problem, self.bend(free))
        self._last = free.copy(), solved
        return solved.residuals

    def slopes(self, free: Array) -> Array:
        if self._last is None or not np.array_equal(self._last[0], free):
            self.residuals(free)
        assert self._last is not None
        bend = self.bend(free)
        slopes: Array = bend_slopes(self.problem, bend, self._last[1])[:, self.searched]
        slopes *= bend[self.searched] == free  # beyond the range searched nothing changes
        return slopes


def minimise(problem: Problem, start: Array, tolerance: float) -> tuple[Array, float]:
    """Follow a start (``log Vs``, ``log delta``) to its minimum by Levenberg-Marquardt.

    Parameters
    ----------
    problem : Problem
        The problem.
    start : ndarray, shape (2,)
        The start.
    tolerance : float
        Relative change of the sum of squares, or of the step, at which the search ends.

    Returns
    -------
    bend : ndarray, shape (2,)
        ``log Vs`` and ``log delta`` at the minimum.
    squares : float
        Weighted sum of squares there.
    """
    trials = _Trials(problem)
    result = least_squares(
        trials.residuals, start[trials.searched], trials.slopes, method="lm", ftol=tolerance, xtol=tolerance
    )
    return trials.bend(result.x), 2.0 * float(result.cost)


def search(problem: Problem) -> tuple[Array, float]:
    """Return the best minimum (bend and weighted sum of squares) found from several starts."""
    velocities = np.linspace(problem.log_speed.min(), problem.log_speed.max(), VELOCITY_STARTS)
    found = []
    for shape in SHAPE_STARTS:
        starts = [np.array([velocity, math.log(shape)]) for velocity in velocities]
        squares = [float(np.sum(solve_linear(problem, start).residuals ** 2)) for start in starts]
        found.append(minimise(problem, starts[int(np.argmin(squares))], FINE))
    return min(found, key=lambda minimum: minimum[1])


class Estimated(NamedTuple):
    """A parameter (Vs, delta as logarithms) whose interval is sought.

    Attributes
    ----------
    name : str
        Its name.
    value : float
        Its estimate.
    step : float
        Where the end of the interval is expected, as a distance; positive.
    """

    name: str
    value: float
    step: float


def interval_end(points: Points, parameter: Estimated, bend: Array, squares: float, rise: float, side: float) -> float:
    """Return the end of an interval, infinite where there is none.

    Parameters
    ----------
    points : Points
        The points.
    parameter : Estimated
        The parameter.
    bend, squares : ndarray and float
        The best fit.
    rise : float
        By how much the sum of squares rises to the end of the interval.
    side : float
        1 for the upper end, -1 for the lower.
    """
    reach, limit = FARTHEST, side * math.inf
    if parameter.name not in BEND:
        reach = math.exp(FARTHEST) * (abs(parameter.value) + parameter.step)
        if side < 0.0 and parameter.name != "offset":
            reach, limit = parameter.value, 0.0  # none is negative
    inside, outside = (0.0, 0.0), (math.inf, math.inf)  # distance and share of the rise, as a root
    distance = min(parameter.step, 1.0) if parameter.name in BEND else parameter.step
    for trial in range(LARGEST_STEPS):
        distance = min(distance, reach)
        held = make_problem(points, parameter.name, parameter.value + side * distance)
        moved, there = minimise(held, bend, COARSE)
        share = math.sqrt(max(there - squares, 0.0) / rise)
        if abs(share - 1.0) < END_TOLERANCE:
            break
        if share < 1.0:
            inside, bend = (distance, share), moved
            if distance == reach:
                return limit
        else:
            outside = (distance, share)
        if math.isinf(outside[0]):
            distance *= min(max(1.0 / max(share, FLAT), 1.2 if trial else 1.0), 2.0)
        else:
            part = (1.0 - inside[1]) / (outside[1] - inside[1])
            distance = inside[0] + min(max(part, 0.1), 0.98) * (outside[0] - inside[0])
    return parameter.value + side * distance
