"""Figures of merit of a run."""

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from adaptive_ff.scenario.series import largest_size

START = 5.0
"""Length of the start, s of motion."""

CALM = 2.0
"""Time after which a joint whose reference stands still is expected to stand still, s."""


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


METRIC_UNITS = {**dict.fromkeys(Metrics.__annotations__, "rad/s"), "torque_variation": "N m"}
"""Units of the figures of merit that every run has."""

POSITION_UNITS = dict.fromkeys(PositionMetrics.__annotations__, "rad")
"""The same of those that a run with a position loop has as well."""


def evaluate(
    reference: NDArray[np.float64],
    velocity: NDArray[np.float64],
    torque: NDArray[np.float64],
    period: float,
    last_change: float,
) -> Metrics:
    """Evaluate reference and true velocity (rad/s) on the solver's grid of a period (s), and realised torque (N m).

    The last change of friction comes at a time in s, zero without one.
    """
    error = reference - velocity
    settled = error[settled_part(error.size, period, last_change)]
    start = error[start_part(period, first_motion(reference))]
    variation = float(np.sum(np.abs(np.diff(torque))))
    return Metrics(rms(error), largest_size(error), rms(start), rms(settled), largest_size(settled), variation)


def evaluate_position(error: NDArray[np.float64], period: float, last_change: float) -> PositionMetrics:
    """Evaluate position errors (rad) on the solver's grid of a period (s), as :func:`evaluate` does."""
    settled = error[settled_part(error.size, period, last_change)]
    return PositionMetrics(rms(error), largest_size(error), rms(settled), largest_size(settled))


def standstill_range(
    time: NDArray[np.float64], reference: NDArray[np.float64], velocity: NDArray[np.float64]
) -> float | None:
    """Return the peak-to-peak true velocity at standstill, rad/s; None where the reference never stands still.

    Counted is where the reference has been zero for two seconds and more. Series and times (s) on the solver's grid.
    """
    last_motion = np.maximum.accumulate(np.where(reference != 0.0, time, -np.inf))
    calm = (reference == 0.0) & (time - np.maximum(last_motion, time[0]) > CALM)
    return float(np.ptp(velocity[calm])) if np.any(calm) else None


def first_motion(reference: NDArray[np.float64]) -> int:
    """Return the first place at which a reference is not zero; zero where it never moves."""
    return int(np.argmax(reference != 0.0))


def settled_start(last_change: float, end: float) -> float:
    """Return when the settled part begins: half-way from the last change of friction to the end, all in s."""
    return 0.5 * (last_change + end)


def rms(values: NDArray[np.float64]) -> float:
    """Return the root of the mean square."""
    return math.sqrt(np.mean(np.square(values)))


def step_at(size: int, period: float, time: float) -> int:
    """Return the step of a grid of a size and a period (s) at a time (s) or after it; at its end the last one."""
    return min(size - 1, math.ceil(time / period - 1e-6))


def settled_part(size: int, period: float, last_change: float) -> slice:
    """Return where a run on a grid of a size and a period (s) is settled after its last change (s)."""
    return slice(step_at(size, period, settled_start(last_change, (size - 1) * period)), size)


def start_part(period: float, begin: int) -> slice:
    """Return where a run on a grid of a period (s) that begins to move at a step starts."""
    return slice(begin, begin + round(START / period) + 1)
