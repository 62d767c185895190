"""Physical estimates of an adaptive controller: from its coefficients, with standard deviations (delta method)."""

import math

import numpy as np

from adaptive_ff.adaptive.state import AdaptiveParameters, AdaptiveState
from adaptive_ff.friction.columns import COULOMB, INERTIA, PATHS, STICTION, VISCOUS
from adaptive_ff.learning.kalman import LOOP
from controllers import ESTIMATES
from controllers.arrays import NDArray, row_of

Array = NDArray[np.float64]

HELD = 1
"""Place of the torque that the integral holds beside what is fed, among the states of the loop."""

OFFSET = 5
"""Place of the offset among the estimates."""


def write_physical(parameters: AdaptiveParameters, state: AdaptiveState, row: Array) -> None:
    """Write the physical estimates, in the order of their names; the offset where the row has a place for it."""
    hypothesis, mean = parameters.hypothesis, state.estimate.mean
    paths, reach = 0.0, 0.0
    for i in range(hypothesis.distances.size):
        part = mean[LOOP + PATHS + i]
        paths += part
        reach += part * hypothesis.distances[i]
    coulomb = mean[LOOP + COULOMB] + paths
    row[0], row[1], row[2] = mean[LOOP + INERTIA], coulomb, mean[LOOP + STICTION] + paths
    row[3], row[4] = mean[LOOP + VISCOUS], math.exp(mean[mean.size - 2])
    first = LOOP + PATHS + hypothesis.distances.size
    sizes = 2 * int(hypothesis.directions) + 2 * hypothesis.waves.size
    place = OFFSET
    if row.size > OFFSET + sizes + hypothesis.regressors + 2:
        row[place] = state.steady
        place += 1
    for i in range(sizes):
        row[place + i] = mean[first + i]
    place += sizes
    for i in range(hypothesis.regressors):
        row[place + i] = mean[mean.size - 2 - hypothesis.regressors + i]
    row[row.size - 2] = math.exp(mean[mean.size - 1])
    row[row.size - 1] = reach / coulomb if coulomb > 0.0 else 0.0


ESTIMATES[AdaptiveParameters] = write_physical


def fill_slopes(parameters: AdaptiveParameters, state: AdaptiveState, slopes: Array) -> None:
    """Write the derivatives of the physical estimates, a row each, with respect to the states of the filter."""
    hypothesis, mean = parameters.hypothesis, state.estimate.mean
    count, paths, further, last = slopes.shape[0], hypothesis.distances.size, hypothesis.regressors, mean.size - 1
    for row in range(count):
        for column in range(mean.size):
            slopes[row, column] = 0.0
    slopes[0, LOOP + INERTIA], slopes[3, LOOP + VISCOUS] = 1.0, 1.0
    slopes[1, LOOP + COULOMB], slopes[2, LOOP + STICTION] = 1.0, 1.0
    slopes[4, last - 1], slopes[count - 2, last] = math.exp(mean[last - 1]), math.exp(mean[last])
    coulomb, reach = mean[LOOP + COULOMB], 0.0
    for i in range(paths):
        part = mean[LOOP + PATHS + i]
        coulomb += part
        reach += part * hypothesis.distances[i]
        slopes[1, LOOP + PATHS + i], slopes[2, LOOP + PATHS + i] = 1.0, 1.0
    first = LOOP + PATHS + paths
    sizes = 2 * int(hypothesis.directions) + 2 * hypothesis.waves.size
    place = OFFSET
    if count > OFFSET + sizes + further + 2:
        slopes[place, HELD] = 1.0
        place += 1
    for i in range(sizes):
        slopes[place + i, first + i] = 1.0
    place += sizes
    for i in range(further):
        slopes[place + i, last - 1 - further + i] = 1.0
    if coulomb > 0.0:
        reach /= coulomb
        slopes[count - 1, LOOP + COULOMB] = -reach / coulomb
        for i in range(paths):
            slopes[count - 1, LOOP + PATHS + i] = (hypothesis.distances[i] - reach) / coulomb


def write_deviations(parameters: AdaptiveParameters, state: AdaptiveState, slopes: Array, row: Array) -> None:
    """Write the standard deviations of the physical estimates in a row, and their slopes."""
    fill_slopes(parameters, state, slopes)
    covariance = state.estimate.covariance
    for k in range(row.size):
        total = 0.0
        for i in range(state.estimate.mean.size):
            if slopes[k, i] != 0.0:
                for j in range(i + 1):
                    twice = 2.0 if j < i else 1.0
                    total += twice * slopes[k, i] * covariance[row_of(i) + j] * slopes[k, j]
        row[k] = math.sqrt(max(total, 0.0))


def deviations(parameters: AdaptiveParameters, state: AdaptiveState, count: int) -> Array:
    """Return the standard deviations of so many physical estimates."""
    found = np.zeros(count)
    write_deviations(parameters, state, np.zeros((count, state.estimate.mean.size)), found)
    return found
