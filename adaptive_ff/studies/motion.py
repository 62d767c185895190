"""A motion for identification: its limits, its information, and the search for one by that.

*Information* is that of a joint while it slides, ``u = J w' + F(w) - tau dF/dw w'``, along a periodic motion that is
followed exactly; it gives the intervals that the parameters would have, up to a common factor. Each sample counts by
how far it passes the gate that identification has: the joint must have slid one way, faster than a fraction of the
Stribeck velocity, for a while. Everything is smooth in the motion.

*Search*: all limits are linear in the coefficients of a Fourier series. A direction in their space is scaled until the
first limit is reached, and only directions are searched: every motion that is looked at keeps all limits. What is made
small is the largest interval, each over one that it is measured by, so that no parameter is given up for others.
"""

import math
from dataclasses import dataclass
from functools import cached_property
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray
from scipy.linalg import null_space
from scipy.optimize import minimize
from scipy.special import logsumexp

from adaptive_ff.errors import InputError
from adaptive_ff.scenario.waves import Fourier

Array = NDArray[np.float64]

NAMES = ("inertia", "coulomb", "stiction", "viscous", "friction_lag")  # parameters whose intervals are given
GATE_FRACTION = 0.4  # speed of the gate of the identification over the Stribeck velocity
GATE_WIDTH = 0.1  # width of its smooth edge, in Stribeck velocities
SIGN_FRACTION = 0.1  # speed over the Stribeck velocity at which a smooth sign turns
SMALLEST = 1e-12  # added to the scaled information: the interval of a parameter without any is huge, but finite
GRID_PER_CYCLE = 25  # points of the grid of times in the shortest cycle of the series
FINE_PER_CYCLE = 200  # the same on which the limits are kept in the end
SHARPNESS = 40.0  # exponent of the norm that stands for the largest value: smooth, and at most some 15 % more
EVENNESS = 12.0  # the same for the largest interval
STEP = 1e-6  # step of difference quotients, over the size of the coefficients
ITERATIONS = 60  # iterations of one search

PLATEAUS = ((0.45, 0.7, 0.32), (0.9, 1.4, 0.21), (3.0, 6.0, 0.43))
"""Speeds over the Stribeck velocity, from and to, and fractions of the time, of the plateaus of a start.

The most informative measure over free speeds has its weight there and, for some 5 % of the time, at the limit.
"""


class AssumedJoint(NamedTuple):
    """What is assumed of a joint before it is identified; a motion is planned with it."""

    inertia: float  # inertia, kg m^2
    # Coulomb friction and stiction, N m
    coulomb: float
    stiction: float
    viscous: float  # viscous coefficient, N m s/rad
    stribeck_velocity: float  # stribeck velocity, rad/s
    hold: float  # for how long the joint must have slid before identification uses a sample, s
    stribeck_shape: float = 1.0  # exponent of the Stribeck curve


def information(joint: AssumedJoint, velocity: Array, step: float) -> Array:
    """Return the information matrices of periodic motions (rad/s), shape (m, n), on a grid of times with a step (s).

    Of shape (m, 5, 5), of the parameters ``NAMES``, each over a size of its own, for noise of unit density.
    """
    bend = joint.stribeck_velocity
    scaled, shape = np.abs(velocity) / bend, joint.stribeck_shape
    sign, falling = np.tanh(velocity / (SIGN_FRACTION * bend)), np.exp(-(scaled**shape))
    derive = 2j * np.pi * np.fft.rfftfreq(velocity.shape[-1], step)
    spectrum = np.fft.rfft(velocity, axis=-1)
    acceleration = np.fft.irfft(derive * spectrum, velocity.shape[-1], axis=-1)
    steepness = shape * np.maximum(scaled, SIGN_FRACTION) ** (shape - 1.0) / bend
    slope = joint.viscous - (joint.stiction - joint.coulomb) * steepness * falling
    unit = max(joint.stiction, joint.inertia * bend / joint.hold)
    rows = np.stack(
        [
            joint.inertia * acceleration,
            unit * sign * (1.0 - falling),
            unit * sign * falling,
            unit / bend * velocity,
            joint.hold * slope * acceleration,
        ],
        axis=-1,
    )
    weighted = rows * _passing(joint, velocity, step)[..., None]
    return np.asarray(np.swapaxes(weighted, -1, -2) @ rows * step)


def interval_sizes(found: Array) -> Array:
    """Return the sizes of the intervals of the parameters, shape (m, 5), from information matrices, shape (m, 5, 5)."""
    trace = np.trace(found, axis1=-2, axis2=-1)[..., None, None]
    try:
        inverse = np.linalg.inv(found + SMALLEST * trace * np.eye(len(NAMES)))
    except np.linalg.LinAlgError as error:
        raise InputError(
            "the motion is too small to show anything of the joint; allow a larger position, velocity or acceleration"
        ) from error
    return np.asarray(np.sqrt(np.diagonal(inverse, axis1=-2, axis2=-1)))


def _passing(joint: AssumedJoint, velocity: Array, step: float) -> Array:
    """Return by how much each sample passes the gate, from 0 to 1, shape (m, n)."""
    bend = joint.stribeck_velocity
    fast = 1.0 / (1.0 + np.exp(-(np.abs(velocity) / bend - GATE_FRACTION) / GATE_WIDTH))
    passing = fast
    longest = max(1, round(joint.hold / step))
    for back in sorted({max(1, longest // 3), max(1, 2 * longest // 3), longest}):
        before = np.roll(velocity, back, axis=-1)
        one_way = 0.5 + 0.5 * np.tanh(velocity * before / (0.5 * SIGN_FRACTION * bend**2))
        passing = passing * np.roll(fast, back, axis=-1) * one_way
    return np.asarray(passing)


@dataclass(frozen=True)
class MotionLimits:
    """Limits of a motion, each as a size either way; None where there is none."""

    velocity: float  # velocity, rad/s
    position: float | None = None  # distance from where the motion starts, rad
    acceleration: float | None = None  # acceleration, rad/s^2
    torque: float | None = None  # torque that the assumed joint needs, N m; more than its stiction


@dataclass(frozen=True, eq=False)
class Excitation:
    """A motion for identification."""

    reference: Fourier  # the series
    limits: MotionLimits  # the limits that it keeps
    # largest size of ``position`` (rad), ``velocity``, ``acceleration`` and ``torque`` (N m) on its way
    largest: dict[str, float]
    # interval of each parameter that is to be expected over the one that the motion gives that it is measured by
    sizes: dict[str, float]

    @property
    def coefficients(self) -> Array:
        """Coefficients of the series, cosines first."""
        return np.array([*self.reference.cosines, *self.reference.sines])

    @property
    def widest(self) -> float:
        """The largest of ``sizes``; infinite where one is unknown."""
        return max(math.inf if math.isnan(size) else size for size in self.sizes.values())

    def to_dict(self) -> dict[str, Any]:
        """Return the motion as ``adaptive-ff excite --json`` writes it."""
        sizes = {name: size if math.isfinite(size) else None for name, size in self.sizes.items()}
        return {
            "reference": self.reference.model_dump(),
            "limits": vars(self.limits),
            "largest": self.largest,
            "intervals_over_multisine": sizes,
        }

    def columns(self, step: float) -> dict[str, Array]:
        """Return time, position, velocity and acceleration of one period on a grid of a step (s)."""
        time = np.arange(math.floor(self.reference.period / step + 1e-9) + 1, dtype=np.float64) * step
        rows = fourier_rows(self.reference.period, len(self.reference.sines), time)
        return {"time": time, **{name: row @ self.coefficients for name, row in rows.items()}}


def fourier_rows(period: float, harmonics: int, time: Array) -> dict[str, Array]:
    """Return matrices that give position, velocity and acceleration of a series at times (s) from its coefficients."""
    turns = 2.0 * math.pi / period * np.arange(1, harmonics + 1)
    cosine, sine = np.cos(np.outer(time, turns)), np.sin(np.outer(time, turns))
    return {
        "position": np.hstack([sine / turns, (1.0 - cosine) / turns]),
        "velocity": np.hstack([cosine, sine]),
        "acceleration": np.hstack([-sine * turns, cosine * turns]),
    }


class MotionSearch:
    """The Fourier series of a period and a largest frequency that keep the limits of a joint."""

    def __init__(self, joint: AssumedJoint, limits: MotionLimits, period: float, harmonics: int) -> None:
        self.joint, self.limits, self.period, self.harmonics = joint, limits, period, harmonics
        count = harmonics * GRID_PER_CYCLE
        self._time: Array = np.arange(count) * period / count
        series = fourier_rows(period, harmonics, self._time)
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
        fractions = np.array(PLATEAUS)[order, 2] * generator.uniform(0.7, 1.3, len(PLATEAUS))
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
            return np.asarray(logsumexp(EVENNESS * (self._sizes(directions) - reference), axis=-1) / EVENNESS)

        def cost_and_slope(direction: Array) -> tuple[float, Array]:
            step = STEP * float(np.linalg.norm(direction))
            values = cost(np.vstack([direction, direction + step * np.eye(direction.size)]))
            return float(values[0]), (values[1:] - values[0]) / step

        found = minimize(cost_and_slope, start, jac=True, method="BFGS", options={"maxiter": ITERATIONS})
        return _unit(found.x)

    def direction(self, motion: Excitation) -> Array:
        """Return the direction of a motion."""
        return _unit(self._free.T @ motion.coefficients)

    def sizes(self, direction: Array) -> Array:
        """Return the interval of each parameter by information, shape (5,)."""
        return np.asarray(np.exp(self._sizes(direction[None, :])[0]))

    def motion(self, direction: Array, measure: Array) -> Excitation:
        """Return the motion of a direction, which keeps the limits between the points of the grid as well."""
        limits, joint, harmonics = self.limits, self.joint, self.harmonics
        free, (fine, bounds) = self._free @ direction, self._fine
        on_grid = float(np.max(np.abs(bounds @ free)))
        # between the points a trigonometric polynomial is larger by no more than this (H. Ehlich, K. Zeller, 1964)
        coefficients = free * math.cos(math.pi / FINE_PER_CYCLE) / on_grid
        # decimals that a person reads; rounded towards zero, so that no limit is passed
        coefficients = np.trunc(coefficients * 1e9 / limits.velocity) * limits.velocity / 1e9
        motion = {name: row @ coefficients for name, row in fine.items()}
        torque = np.abs(joint.inertia * motion["acceleration"] + joint.viscous * motion["velocity"]) + joint.stiction
        largest = {name: float(np.max(np.abs(values))) for name, values in {**motion, "torque": torque}.items()}
        cosines, sines = coefficients[:harmonics].tolist(), coefficients[harmonics:].tolist()
        reference = Fourier(kind="fourier", period=self.period, cosines=cosines, sines=sines)
        sizes = self.sizes(direction) / measure
        return Excitation(reference, limits, largest, dict(zip(NAMES, sizes.tolist(), strict=True)))

    @cached_property
    def _fine(self) -> tuple[dict[str, Array], Array]:
        count = self.harmonics * FINE_PER_CYCLE
        rows = fourier_rows(self.period, self.harmonics, np.arange(count) * self.period / count)
        return rows, _bounds(rows, self.joint, self.limits)

    def _sizes(self, directions: Array) -> Array:
        scaled = directions / _smooth_largest(directions @ self._bounds.T)[:, None]
        found = information(self.joint, scaled @ self._velocity.T, float(self._time[1]))
        return np.log(interval_sizes(found))


def _unit(direction: Array) -> Array:
    return np.asarray(direction / np.linalg.norm(direction))


def _bounds(series: dict[str, Array], joint: AssumedJoint, limits: MotionLimits) -> Array:
    """Return the matrix that gives what must stay between -1 and 1, shape (rows, coefficients)."""
    # friction takes at most stiction and the viscous torque
    needed = joint.inertia * series["acceleration"] + joint.viscous * series["velocity"]
    most = {**vars(limits), "torque": None if limits.torque is None else limits.torque - joint.stiction}
    return np.vstack([{**series, "torque": needed}[name] / one for name, one in most.items() if one is not None])


def _smooth_largest(values: Array) -> Array:
    """Return about the largest size of each row, which is smooth in the values and not less."""
    sizes = np.abs(values)
    largest = np.max(sizes, axis=-1)
    beyond = np.sum((sizes / largest[:, None]) ** SHARPNESS, axis=-1) ** (1.0 / SHARPNESS)
    return np.asarray(largest * beyond)
