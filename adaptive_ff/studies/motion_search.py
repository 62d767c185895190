"""Search for a motion by its information: directions of Fourier coefficients, scaled until a limit is reached.

All limits are linear in the coefficients. A direction in their space is therefore scaled until the first limit is
reached, and only directions are searched: every motion that is looked at keeps all limits. What is made small is the
largest interval, each over one that it is measured by, so that no parameter is given up for others.
"""

import math
from functools import cached_property

import numpy as np
from scipy.linalg import null_space
from scipy.optimize import minimize
from scipy.special import logsumexp

from adaptive_ff.scenario.waves import Fourier
from adaptive_ff.studies.information import NAMES, Array, AssumedJoint, information, interval_sizes
from adaptive_ff.studies.motion import Excitation, MotionLimits, Series

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

ITERATIONS = 60
"""Iterations of one search."""

PLATEAUS = ((0.45, 0.7, 0.32), (0.9, 1.4, 0.21), (3.0, 6.0, 0.43))
"""Speeds over the Stribeck velocity, from and to, and fractions of the time, of the plateaus of a start.

Were every sample free of the others, the most informative measure over speeds would have its weight there and, for some
5 % of the time, at the limit.
"""


class MotionSearch:
    """The Fourier series of a period and a largest frequency that keep the limits of a joint."""

    def __init__(self, joint: AssumedJoint, limits: MotionLimits, period: float, harmonics: int) -> None:
        self.joint, self.limits, self.period, self.harmonics = joint, limits, period, harmonics
        count = harmonics * GRID_PER_CYCLE
        self._time: Array = np.arange(count) * period / count
        series = Series(period, harmonics, self._time)
        # at rest at the start, with no acceleration: two equations between the coefficients
        self._free = null_space(np.vstack([series["velocity"][0], series["acceleration"][0]]))
        self._velocity = series["velocity"] @ self._free
        self._bounds = _bounds(series, joint, limits) @ self._free

    def random_start(self, generator: np.random.Generator) -> Array:
        """Return a direction with all frequencies, the slow ones more."""
        drawn = generator.standard_normal(2 * self.harmonics)
        return _unit(self._free.T @ (drawn / np.sqrt(np.tile(np.arange(1, self.harmonics + 1), 2))))

    def plateau_start(self, generator: np.random.Generator) -> Array:
        """Return the direction of a motion that dwells at the speeds ``PLATEAUS`` one way, and goes back fast."""
        bend, burst = self.joint.stribeck_velocity, generator.uniform(0.3, 1.0) * self.limits.velocity
        order = generator.permutation(len(PLATEAUS))
        speeds = np.array([generator.uniform(low, high) for low, high, _ in PLATEAUS])[order] * bend
        fractions = np.array([fraction for _, _, fraction in PLATEAUS])[order] * generator.uniform(
            0.7, 1.3, len(PLATEAUS)
        )
        fractions /= fractions.sum()
        mean, back = float(speeds @ fractions), 2.0 / math.pi * burst  # of half a sine
        forth = self.period * back / (mean + back)
        edges = forth * np.cumsum(fractions)
        wanted = speeds[np.minimum(np.searchsorted(edges, self._time, side="right"), len(PLATEAUS) - 1)]
        fast = self._time >= forth
        wanted[fast] = -burst * np.sin(math.pi * (self._time[fast] - forth) / (self.period - forth))
        return _unit(np.linalg.lstsq(self._velocity, wanted, rcond=None)[0])

    def search(self, start: Array, measure: Array) -> Array:
        """Return a direction whose largest interval over a measure is less than that of the start."""
        reference = np.log(measure)

        def cost(directions: Array) -> Array:
            sizes = self._sizes(directions) - reference
            value: Array = np.asarray(logsumexp(EVENNESS * sizes, axis=-1) / EVENNESS)
            return value

        def cost_and_slope(direction: Array) -> tuple[float, Array]:
            step = STEP * float(np.linalg.norm(direction))
            values = cost(np.vstack([direction, direction + step * np.eye(direction.size)]))
            return float(values[0]), (values[1:] - values[0]) / step

        found = minimize(cost_and_slope, start, jac=True, method="BFGS", options={"maxiter": ITERATIONS})
        return _unit(found.x)

    def direction(self, motion: Excitation) -> Array:
        """Return the direction of a motion."""
        return _unit(self._free.T @ np.array([*motion.reference.cosines, *motion.reference.sines]))

    def sizes(self, direction: Array) -> Array:
        """Return the interval of each parameter by information, shape (5,)."""
        return np.asarray(np.exp(self._sizes(direction[None, :])[0]))

    def motion(self, direction: Array, measure: Array) -> Excitation:
        """Return the motion of a direction, which keeps the limits between the points of the grid as well."""
        limits, joint, harmonics = self.limits, self.joint, self.harmonics
        fine, free = self._fine, self._free @ direction
        on_grid = float(np.max(np.abs(self._fine_bounds @ free)))
        # between the points a trigonometric polynomial is larger by no more than this (H. Ehlich, K. Zeller, 1964)
        coefficients = free * math.cos(math.pi / FINE_PER_CYCLE) / on_grid
        # decimals that a person reads; rounded towards zero, so that no limit is passed
        coefficients = np.trunc(coefficients * 1e9 / limits.velocity) * limits.velocity / 1e9
        motion = {name: fine[name] @ coefficients for name in ("position", "velocity", "acceleration")}
        torque = np.abs(joint.inertia * motion["acceleration"] + joint.viscous * motion["velocity"]) + joint.stiction
        largest = {name: float(np.max(np.abs(values))) for name, values in {**motion, "torque": torque}.items()}
        cosines, sines = coefficients[:harmonics].tolist(), coefficients[harmonics:].tolist()
        reference = Fourier(kind="fourier", period=self.period, cosines=cosines, sines=sines)
        sizes = self.sizes(direction) / measure
        return Excitation(reference, limits, largest, dict(zip(NAMES, sizes.tolist(), strict=True)))

    @cached_property
    def _fine(self) -> Series:
        count = self.harmonics * FINE_PER_CYCLE
        return Series(self.period, self.harmonics, np.arange(count) * self.period / count)

    @cached_property
    def _fine_bounds(self) -> Array:
        return _bounds(self._fine, self.joint, self.limits)

    def _sizes(self, directions: Array) -> Array:
        scaled = directions / _smooth_largest(directions @ self._bounds.T)[:, None]
        found = information(self.joint, scaled @ self._velocity.T, float(self._time[1]))
        return np.log(interval_sizes(found))


def _unit(direction: Array) -> Array:
    return np.asarray(direction / np.linalg.norm(direction))


def _bounds(series: Series, joint: AssumedJoint, limits: MotionLimits) -> Array:
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


def _smooth_largest(values: Array) -> Array:
    """Return about the largest size of each row, which is smooth in the values and not less."""
    sizes = np.abs(values)
    largest = np.max(sizes, axis=-1)
    beyond = np.sum((sizes / largest[:, None]) ** SHARPNESS, axis=-1) ** (1.0 / SHARPNESS)
    return np.asarray(largest * beyond)
