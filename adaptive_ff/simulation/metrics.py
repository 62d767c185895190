"""Figures of merit of a run."""

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from adaptive_ff.scenario.series import blocks, largest_size

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
    """How well a run tracked. Errors are reference minus true velocity on the solver's grid, rad/s.

    Attributes
    ----------
    rms_error, max_error : float
        Over the whole run.
    rms_error_start : float
        Over the first 5 s of motion.
    rms_error_settled, max_error_settled : float
        Over the last half of the time after the last change of friction, or of the run without one.
    torque_variation : float
        Sum of ``|du|`` of the realised torque over the run, N m.
    """

    rms_error: float
    max_error: float
    rms_error_start: float
    rms_error_settled: float
    max_error_settled: float
    torque_variation: float


@dataclass(frozen=True)
class PositionMetrics:
    """How well a run with a position loop followed its path, as planned minus true position on the solver's grid, rad.

    Attributes
    ----------
    rms_position_error, max_position_error : float
        Over the whole run.
    rms_position_error_settled, max_position_error_settled : float
        Over the last half of the time after the last change of the joint, or of the run without one.
    """

    rms_position_error: float
    max_position_error: float
    rms_position_error_settled: float
    max_position_error_settled: float


def evaluate_position(time: NDArray[np.float64], error: NDArray[np.float64], last_change: float) -> PositionMetrics:
    """Evaluate a position error (rad) on the solver's grid of times (s); see :func:`evaluate`."""
    settled = error[int(np.searchsorted(time, settled_start(last_change, float(time[-1])))) :]
    return PositionMetrics(rms(error), largest_size(error), rms(settled), largest_size(settled))


def evaluate(
    time: NDArray[np.float64],
    reference: NDArray[np.float64],
    velocity: NDArray[np.float64],
    torque: NDArray[np.float64],
    last_change: float,
) -> Metrics:
    """Evaluate a run.

    Parameters
    ----------
    time, reference, velocity : ndarray, shape (steps + 1,)
        Time (s), reference and true velocity (rad/s) on the solver's grid.
    torque : ndarray, shape (samples,)
        Realised torque, N m.
    last_change : float
        Time of the last change of friction, s; zero without one.
    """
    error = reference - velocity
    begin = first_motion(reference)
    start = slice(begin, int(np.searchsorted(time, time[begin] + START, side="right")))
    settled = slice(int(np.searchsorted(time, settled_start(last_change, float(time[-1])))), None)
    largest, largest_settled = largest_size(error), largest_size(error[settled])
    squares = np.square(error, out=error)
    return Metrics(
        root_of_mean(squares),
        largest,
        root_of_mean(squares[start]),
        root_of_mean(squares[settled]),
        largest_settled,
        float(np.sum(np.abs(np.diff(torque)))),
    )


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
    for part in blocks(reference.size, FEW):
        moving = reference[part] != 0.0
        if np.any(moving):
            return int(part.start + np.argmax(moving))
    return 0


def settled_start(last_change: float, end: float) -> float:
    """Return when the settled part begins: half-way from the last change of friction to the end, all in s."""
    return 0.5 * (last_change + end)


def rms(values: NDArray[np.float64]) -> float:
    """Return the root of the mean square."""
    return root_of_mean(np.square(values))


def root_of_mean(squares: NDArray[np.float64]) -> float:
    """Return the root of the mean."""
    return math.sqrt(np.mean(squares))
