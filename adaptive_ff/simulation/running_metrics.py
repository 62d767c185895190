"""Figures of merit of a run whose series come in parts and are not kept."""

import math

import numpy as np
from numpy.typing import NDArray

from adaptive_ff.scenario.series import largest_size
from adaptive_ff.simulation.metrics import START, Metrics, PositionMetrics, settled_start


class Total:
    """Root of the mean square and largest size of a series between two places, from its parts.

    Parameters
    ----------
    first, stop : int
        Place of the first value that counts, and of the first behind it.
    """

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


class RunningMetrics:
    """What :func:`~adaptive_ff.simulation.metrics.evaluate` computes, to rounding, from parts of a run in order.

    Parameters
    ----------
    size : int
        Size of the solver's grid.
    period : float
        Its period, s.
    begin : int
        Solver step at which the motion begins.
    last_change : float
        Time of the last change of friction, s; zero without one.
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


def _step_from(period: float, time: float) -> int:
    """Return the first step of a grid at a time (s) or later, as a search in the grid's times finds it."""
    step = max(0, int(time / period) - 1)
    while step * period < time:
        step += 1
    return step
