"""Figures of merit of a run."""

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from adaptive_ff.scenario.series import chunks, largest_size

START = 5.0
"""Length of the start, s of motion."""

CALM = 2.0
"""Time after which a joint whose reference stands still is expected to stand still, s."""

FEW = 4096
"""Steps of a reference that are searched for its first motion at a time; most begin to move at once."""

METRIC_UNITS = {
    "rms_error": "rad/s",
    "max_error": "rad/s",
    "rms_error_start": "rad/s",
    "rms_error_settled": "rad/s",
    "max_error_settled": "rad/s",
    "torque_variation": "N m",
}
"""Units of the figures of merit that every run has."""

POSITION_UNITS = {
    "rms_position_error": "rad",
    "max_position_error": "rad",
    "rms_position_error_settled": "rad",
    "max_position_error_settled": "rad",
}
"""The same of those that a run with a position loop has as well."""


@dataclass(frozen=True)
class Metrics:
    """How well a run tracked. Errors are reference minus true velocity on the solver's grid, rad/s."""

    # over the whole run
    rms_error: float
    max_error: float
    rms_error_start: float  # over the first 5 s of motion
    # over the last half of the time after the last change of friction, or of the run without one
    rms_error_settled: float
    max_error_settled: float
    torque_variation: float  # sum of ``|du|`` of the realised torque over the run, N m


@dataclass(frozen=True)
class PositionMetrics:
    """How well a run with a position loop followed its path, planned minus true position on the solver's grid, rad."""

    # over the whole run
    rms_position_error: float
    max_position_error: float
    # over the last half of the time after the last change of the joint, or of the run without one
    rms_position_error_settled: float
    max_position_error_settled: float


class Total:
    """Root of the mean square and largest size of a series between two places, the second not counted, in parts."""

    def __init__(self, first: int, stop: int) -> None:
        self._first, self._stop = first, stop
        self._sum = self.largest = 0.0

    def add(self, place: int, values: NDArray[np.float64]) -> None:
        """Add a part of the series that begins at a place."""
        counted = values[max(0, self._first - place) : max(0, self._stop - place)]
        if counted.size:
            self._sum += float(np.sum(np.square(counted)))
            self.largest = max(largest_size(counted), self.largest)

    @property
    def rms(self) -> float:
        """Root of the mean square."""
        return math.sqrt(self._sum / (self._stop - self._first))


class RunMetrics:
    """Figures of merit of a run whose series come in parts, in order; a whole run is one part.

    ``size`` and ``period`` (s) are those of the solver's grid, ``begin`` is the step at which the motion begins, and
    the last change of friction comes at a time in s, zero without one.
    """

    def __init__(self, size: int, period: float, begin: int, last_change: float) -> None:
        end = begin * period + START
        last = _step_from(period, end)
        behind = last + 1 if last * period == end else last  # the end itself belongs to the start
        settled = _step_from(period, settled_start(last_change, (size - 1) * period))
        self._whole, self._start = Total(0, size), Total(begin, min(behind, size))
        self._settled = Total(settled, size)
        self._position, self._settled_position = Total(0, size), Total(settled, size)
        self._variation = 0.0
        self._torque: float | None = None

    def add(self, place: int, error: NDArray[np.float64], torque: NDArray[np.float64]) -> None:
        """Add a part: errors (rad/s) on the solver's grid from a place on, and the torque at its samples (N m)."""
        for total in (self._whole, self._start, self._settled):
            total.add(place, error)
        if torque.size:
            jump = 0.0 if self._torque is None else abs(float(torque[0]) - self._torque)
            self._variation += jump + float(np.sum(np.abs(np.diff(torque))))
            self._torque = float(torque[-1])

    def add_position(self, place: int, error: NDArray[np.float64]) -> None:
        """Add position errors (rad) on the solver's grid from a place on."""
        self._position.add(place, error)
        self._settled_position.add(place, error)

    @property
    def metrics(self) -> Metrics:
        """Figures of merit of all parts."""
        return Metrics(
            self._whole.rms,
            self._whole.largest,
            self._start.rms,
            self._settled.rms,
            self._settled.largest,
            self._variation,
        )

    @property
    def position_metrics(self) -> PositionMetrics:
        """Figures of merit of the position."""
        whole, settled = self._position, self._settled_position
        return PositionMetrics(whole.rms, whole.largest, settled.rms, settled.largest)


def evaluate(
    time: NDArray[np.float64],
    reference: NDArray[np.float64],
    velocity: NDArray[np.float64],
    torque: NDArray[np.float64],
    last_change: float,
) -> Metrics:
    """Evaluate reference and true velocity (rad/s) on the solver's grid of times (s), and realised torque (N m)."""
    metrics = RunMetrics(time.size, float(time[1] - time[0]), first_motion(reference), last_change)
    metrics.add(0, reference - velocity, torque)
    return metrics.metrics


def standstill_range(
    time: NDArray[np.float64], reference: NDArray[np.float64], velocity: NDArray[np.float64]
) -> float | None:
    """Return the peak-to-peak true velocity at standstill, rad/s; None where the reference never stands still.

    Counted is where the reference has been zero for two seconds and more. Arrays as for :func:`evaluate`.
    """
    last_motion = np.maximum.accumulate(np.where(reference != 0.0, time, -np.inf))
    calm = (reference == 0.0) & (time - np.maximum(last_motion, time[0]) > CALM)
    return float(np.ptp(velocity[calm])) if np.any(calm) else None


def first_motion(reference: NDArray[np.float64]) -> int:
    """Return the first place at which a reference is not zero; zero where it never moves."""
    for part in chunks(reference.size, FEW):
        moving = reference[part] != 0.0
        if np.any(moving):
            return int(part.start + np.argmax(moving))
    return 0


def settled_start(last_change: float, end: float) -> float:
    """Return when the settled part begins: half-way from the last change of friction to the end, all in s."""
    return 0.5 * (last_change + end)


def rms(values: NDArray[np.float64]) -> float:
    """Return the root of the mean square."""
    return math.sqrt(np.mean(np.square(values)))


def _step_from(period: float, time: float) -> int:
    """Return the first step of a grid at a time (s) or later, as a search in the grid's times finds it."""
    step = max(0, int(time / period) - 1)
    while step * period < time:
        step += 1
    return step
