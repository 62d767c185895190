"""A motion that tells the parameters of a joint: a Fourier series within limits, by ``scipy.optimize``.

The parametrisation is that of J. Swevers, C. Ganseman, D. Tuekel, J. De Schutter, H. Van Brussel, "Optimal robot
excitation and identification" (IEEE Transactions on Robotics and Automation 13, 1997): finite Fourier series, so that
the motion is smooth, periodic and known exactly. Their criterion, the determinant of the information matrix, tells the
sum of all (logarithmic) intervals and may give up one parameter for others. Here the largest interval is made as small
as possible, each over the one that a minute of multisine gives; so none is given up.

All limits are linear in the coefficients. A direction in their space is therefore scaled until the first limit is
reached, and only directions are searched: every motion that is looked at keeps all limits.
"""

import math
from collections.abc import Callable
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from scipy.linalg import null_space
from scipy.optimize import minimize
from scipy.special import logsumexp

from adaptive_ff.design_studies.information import NAMES, Array, AssumedJoint, information, interval_sizes
from adaptive_ff.errors import InputError
from adaptive_ff.scenario.fourier import Fourier

GRID_PER_CYCLE = 25
"""Points of the grid of times in the shortest cycle of the series."""

FINE_PER_CYCLE = 200
"""The same on which the limits are kept in the end."""

SHARPNESS = 40.0
"""Exponent of the norm that stands for the largest value while searching: smooth, and at most some 15 % more."""

EVENNESS = 12.0
"""The same for the largest interval."""

STEP = 1e-6
"""Step of difference quotients, over the size of the coefficients."""

STARTS, ITERATIONS = 10, 60
"""Random starts of the search, and iterations of each."""

LEAST_HARMONICS, MOST_HARMONICS = 3, 60
"""Least and most harmonics of a series."""


@dataclass(frozen=True)
class MotionLimits:
    """Limits of a motion, each as a size either way; None where there is none.

    Attributes
    ----------
    velocity : float
        Velocity, rad/s.
    position : float or None
        Distance from where the motion starts, rad.
    acceleration : float or None
        Acceleration, rad/s^2.
    torque : float or None
        Torque that the assumed joint needs, N m; more than its stiction.
    """

    velocity: float
    position: float | None = None
    acceleration: float | None = None
    torque: float | None = None


@dataclass(frozen=True, eq=False)
class Excitation:
    """A motion for identification.

    Attributes
    ----------
    reference : Fourier
        The series.
    limits : MotionLimits
        The limits that it keeps.
    largest : dict of float
        Largest size of ``position`` (rad), ``velocity``, ``acceleration`` and ``torque`` (N m) on its way.
    sizes : dict of float
        Interval of each parameter that is to be expected over the one that the motion gives that it is measured by.
    """

    reference: Fourier
    limits: MotionLimits
    largest: dict[str, float]
    sizes: dict[str, float]

    def to_dict(self) -> dict[str, Any]:
        """Return the motion as ``adaptive-ff excite --json`` writes it."""
        sizes = {name: size if math.isfinite(size) else None for name, size in self.sizes.items()}
        return {
            "reference": self.reference.model_dump(),
            "limits": vars(self.limits),
            "largest": self.largest,
            "intervals_over_multisine": sizes,
        }

    def with_sizes(self, sizes: dict[str, float]) -> "Excitation":
        """Return the motion with sizes of its intervals that were found in another way."""
        return replace(self, sizes=sizes)

    def columns(self, step: float) -> dict[str, Array]:
        """Return time, position, velocity and acceleration of one period on a grid of a step (s)."""
        time = np.arange(math.floor(self.reference.period / step + 1e-9) + 1, dtype=np.float64) * step
        series = _Series(self.reference.period, len(self.reference.sines), time)
        coefficients = np.array([*self.reference.cosines, *self.reference.sines])
        return {
            "time": time,
            **{name: series[name] @ coefficients for name in ("position", "velocity", "acceleration")},
        }


class _Series(dict[str, Array]):
    """Matrices that give position, velocity and acceleration of a series on a grid from its coefficients."""

    def __init__(self, period: float, harmonics: int, time: Array) -> None:
        turns = 2.0 * math.pi / period * np.arange(1, harmonics + 1)
        cosine, sine = np.cos(np.outer(time, turns)), np.sin(np.outer(time, turns))
        super().__init__(
            position=np.hstack([sine / turns, (1.0 - cosine) / turns]),
            velocity=np.hstack([cosine, sine]),
            acceleration=np.hstack([-sine * turns, cosine * turns]),
        )


def find_excitations(
    joint: AssumedJoint,
    limits: MotionLimits,
    measure: Array,
    *,
    period: float = 10.0,
    fastest: float = 2.0,
    seed: int = 0,
    starts: int = STARTS,
    progress: Callable[[float], None] | None = None,
) -> list[Excitation]:
    """Find motions that tell the parameters of a joint, one for each random start of the search.

    Parameters
    ----------
    joint : AssumedJoint
        What is assumed of the joint; a factor of two wrong is fine.
    limits : MotionLimits
        What the motion must keep.
    measure : ndarray, shape (5,)
        Sizes of the intervals that the motion's are measured by, see ``information.interval_sizes``.
    period : float, optional
        Length of the motion, s; it begins and ends at rest and in the same place.
    fastest : float, optional
        Largest frequency of the series, Hz.
    seed : int, optional
        Seed of the random starts.
    starts : int, optional
        Number of random starts.
    progress : callable, optional
        Is called with the share done, from 0 to 1.

    Raises
    ------
    InputError
        A limit or an argument is out of range.
    """
    harmonics = _check(joint, limits, period, fastest)
    count = harmonics * GRID_PER_CYCLE
    series = _Series(period, harmonics, np.arange(count) * period / count)
    # at rest at the start, with no acceleration: two equations between the coefficients
    start = np.vstack([series["velocity"][0], series["acceleration"][0]])
    free = null_space(start)
    velocity = series["velocity"] @ free
    bounds = _bounds(series, joint, limits) @ free
    reference = np.log(measure)

    def sizes(directions: Array) -> Array:
        scaled = directions / np.array([_smooth_largest(bounds @ one) for one in directions])[:, None]
        found = information(joint, scaled @ velocity.T, period / count)
        return np.log(interval_sizes(found)) - reference

    def cost(directions: Array) -> Array:
        value: Array = np.asarray(logsumexp(EVENNESS * sizes(directions), axis=-1) / EVENNESS)
        return value

    def cost_and_slope(direction: Array) -> tuple[float, Array]:
        step = STEP * float(np.linalg.norm(direction))
        values = cost(np.vstack([direction, direction + step * np.eye(direction.size)]))
        return float(values[0]), (values[1:] - values[0]) / step

    motions = []
    for turn in range(starts):
        drawn = np.random.default_rng([seed, turn]).standard_normal(2 * harmonics)
        first = free.T @ (drawn / np.sqrt(np.tile(np.arange(1, harmonics + 1), 2)))
        found = minimize(
            cost_and_slope, first / np.linalg.norm(first), jac=True, method="BFGS", options={"maxiter": ITERATIONS}
        )
        motions.append(_finished(joint, limits, free @ found.x, period, sizes(found.x[None, :])[0]))
        if progress is not None:
            progress((turn + 1) / starts)
    return motions


def _finished(joint: AssumedJoint, limits: MotionLimits, direction: Array, period: float, sizes: Array) -> Excitation:
    harmonics = direction.size // 2
    fine = _Series(
        period, harmonics, np.arange(8 * harmonics * GRID_PER_CYCLE) * period / (8 * harmonics * GRID_PER_CYCLE)
    )
    on_grid = float(np.max(np.abs(_bounds(fine, joint, limits) @ direction)))
    # between the points a trigonometric polynomial is larger by no more than this (H. Ehlich, K. Zeller, 1964)
    coefficients = direction * math.cos(math.pi / FINE_PER_CYCLE) / on_grid
    # decimals that a person reads; rounded towards zero, so that no limit is passed
    coefficients = np.trunc(coefficients * 1e9 / limits.velocity) * limits.velocity / 1e9
    motion = {name: fine[name] @ coefficients for name in ("position", "velocity", "acceleration")}
    torque = np.abs(joint.inertia * motion["acceleration"] + joint.viscous * motion["velocity"]) + joint.stiction
    largest = {name: float(np.max(np.abs(values))) for name, values in {**motion, "torque": torque}.items()}
    cosines, sines = coefficients[:harmonics].tolist(), coefficients[harmonics:].tolist()
    reference = Fourier(kind="fourier", period=period, cosines=cosines, sines=sines)
    return Excitation(reference, limits, largest, dict(zip(NAMES, np.exp(sizes).tolist(), strict=True)))


def _bounds(series: _Series, joint: AssumedJoint, limits: MotionLimits) -> Array:
    """Return the matrix that gives what must stay between -1 and 1, shape (rows, coefficients)."""
    rows = [series["velocity"] / limits.velocity]
    if limits.position is not None:
        rows.append(series["position"] / limits.position)
    if limits.acceleration is not None:
        rows.append(series["acceleration"] / limits.acceleration)
    if limits.torque is not None:  # friction takes at most stiction and the viscous torque
        needed = joint.inertia * series["acceleration"] + joint.viscous * series["velocity"]
        rows.append(needed / (limits.torque - joint.stiction))
    return np.vstack(rows)


def _smooth_largest(values: Array) -> float:
    sizes = np.abs(values)
    largest = float(np.max(sizes))
    beyond: float = float(np.sum((sizes / largest) ** SHARPNESS)) ** (1.0 / SHARPNESS)
    return largest * beyond


def _check(joint: AssumedJoint, limits: MotionLimits, period: float, fastest: float) -> int:
    """Return the number of harmonics, or refuse."""
    given = {**vars(limits), "period": period, "fastest": fastest}
    for name, value in given.items():
        if value is not None and not (math.isfinite(value) and value > 0.0):
            raise InputError(f"{name} = {value} is not allowed: it must be positive and finite")
    if limits.torque is not None and limits.torque <= joint.stiction:
        raise InputError(
            f"torque = {limits.torque:g} N m is not allowed: it must be more than the stiction, {joint.stiction:g} N m"
        )
    harmonics = math.floor(fastest * period + 1e-9)
    if not LEAST_HARMONICS <= harmonics <= MOST_HARMONICS:
        raise InputError(
            f"period = {period:g} s and fastest = {fastest:g} Hz make {harmonics} harmonics; there must be from "
            f"{LEAST_HARMONICS} to {MOST_HARMONICS}"
        )
    return harmonics
