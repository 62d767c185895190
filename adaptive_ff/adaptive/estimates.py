"""Physical estimates of an adaptive controller: from its coefficients, with standard deviations (delta method)."""

import math

import numpy as np

from adaptive_ff.adaptive.prior import map_place
from adaptive_ff.adaptive.state import AdaptiveParameters, AdaptiveState
from adaptive_ff.friction.columns import COULOMB, INERTIA, PATHS, STICTION, VISCOUS
from adaptive_ff.learning.kalman import LOOP
from controllers import ESTIMATES
from controllers.arrays import NDArray
from controllers.triangle import unpacked

Array = NDArray[np.float64]

HELD = 1
"""Place of the torque that the integral holds beside what is fed, among the states of the loop."""

OFFSET = 5
"""Place of the offset among the estimates."""


def write_physical(block: AdaptiveParameters, state: AdaptiveState, row: Array) -> None:
    """Write the physical estimates, in the order of their names; the offset where the row has a place for it."""
    hypothesis, mean = block.hypothesis, state.mean
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


def mixture_covariance(state: AdaptiveState) -> Array:
    """Return the covariance of the two members together: the mean of theirs, and what their means differ by."""
    apart = state.loud.mean - state.quiet.mean
    weight = state.weight
    mixed = (1.0 - weight) * state.quiet.covariance + weight * state.loud.covariance
    return unpacked(mixed) + weight * (1.0 - weight) * np.outer(apart, apart)


def jacobian(block: AdaptiveParameters, state: AdaptiveState, count: int) -> Array:
    """Return the derivatives of so many physical estimates with respect to the states of the filter."""
    hypothesis, mean = block.hypothesis, state.mean
    paths, further = hypothesis.distances.size, hypothesis.regressors
    slopes = np.zeros((count, mean.size))
    slopes[0, LOOP + INERTIA] = slopes[3, LOOP + VISCOUS] = 1.0
    over = slice(LOOP + PATHS, LOOP + PATHS + paths)
    slopes[1, LOOP + COULOMB] = slopes[2, LOOP + STICTION] = 1.0
    slopes[1:3, over] = 1.0
    slopes[4, -2], slopes[-2, -1] = math.exp(mean[-2]), math.exp(mean[-1])
    sizes = map_place(hypothesis) - PATHS - paths
    place = OFFSET
    if count > OFFSET + sizes + further + 2:
        slopes[place, HELD] = 1.0
        place += 1
    slopes[place : place + sizes, LOOP + PATHS + paths : LOOP + PATHS + paths + sizes] = np.eye(sizes)
    place += sizes
    slopes[place : place + further, mean.size - 2 - further : mean.size - 2] = np.eye(further)
    coulomb = float(mean[LOOP + COULOMB] + mean[over].sum())
    if coulomb > 0.0:
        reach = float(hypothesis.distances @ mean[over]) / coulomb
        slopes[-1, over] = (hypothesis.distances - reach) / coulomb
        slopes[-1, LOOP + COULOMB] = -reach / coulomb
    return slopes


def deviations(block: AdaptiveParameters, state: AdaptiveState, count: int) -> Array:
    """Return the standard deviations of so many physical estimates."""
    slopes = jacobian(block, state, count)
    found: Array = np.sqrt(np.maximum(np.einsum("ij,jk,ik->i", slopes, mixture_covariance(state), slopes), 0.0))
    return found
