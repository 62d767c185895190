"""Long series: in chunks, what is lost between their samples, and sums of sines."""

import math
from collections.abc import Iterator

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]

CHUNK = 2**18  # values of a series that are computed at a time


def chunks(size: int, length: int = CHUNK) -> Iterator[slice]:
    """Yield a series in chunks, so that what is computed on the way takes no room that grows with its length."""
    for begin in range(0, size, length):
        yield slice(begin, min(begin + length, size))


def largest_size(values: NDArray[np.float64]) -> float:
    """Return the largest absolute value."""
    return max(float(np.max(values)), -float(np.min(values)))


@np.errstate(over="ignore", invalid="ignore")
def size_and_lost_fraction(series: NDArray[np.float64], steps: NDArray[np.int64]) -> tuple[float, float]:
    """Return the rms of a series on an even grid, and the fraction that straight lines between samples lose."""
    samples, lost = steps.size - 1, 0.0
    for part in chunks(samples, max(1, CHUNK * samples // series.size)):
        ends = steps[part.start : part.stop + 1]
        between = np.interp(np.arange(ends[0], ends[-1] + 1), ends, series[ends])
        lost += float(np.sum(np.square(series[ends[0] : ends[-1] + 1] - between)))
    size = math.sqrt(float(np.einsum("i,i->", series, series)) / series.size)
    return size, math.sqrt(lost / series.size) / size if size > 0.0 else 0.0


def sum_of_sines(omegas: Array, phases: Array, weights: Array, time: Array) -> Array:
    """Return ``sum_i weight_i sin(omega_i t + phase_i)`` on an even grid of times (s).

    By the sine of a sum, ``t`` being the begin of a row of some hundred times and the time in it: right to some units
    in the last place of the weights, and far faster than as many sines.
    """
    total = np.empty_like(time)
    for part in chunks(time.size):
        times = time[part]
        length = math.isqrt(times.size) + 1
        inside, begins = times[:length] - times[0], times[::length]
        table, one, other = np.zeros((3, begins.size, length))
        for omega, phase, weight in zip(omegas.tolist(), phases.tolist(), weights.tolist(), strict=True):
            angles, starts = omega * inside, omega * begins + phase
            np.einsum("i,j->ij", np.sin(starts), np.cos(angles), out=one)  # twice as fast as np.outer
            one += np.einsum("i,j->ij", np.cos(starts), np.sin(angles), out=other)
            one *= weight
            table += one
        total[part] = table.ravel()[: times.size]
    return total
