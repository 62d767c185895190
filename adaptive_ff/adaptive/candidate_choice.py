"""Which Stribeck velocities are tried, and what the candidates tell of how sure the one in use is."""

import math
from collections.abc import Mapping, Sequence
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from adaptive_ff.adaptive.candidate_state import CandidateState
from adaptive_ff.adaptive.candidates import FIRST, MARGIN
from adaptive_ff.adaptive.estimator_state import EstimatorParameters
from adaptive_ff.model.friction import TorqueModel

FACTORS = (0.25, 0.5, 1.0, 2.0, 4.0)
"""Stribeck velocities of the candidates, over the assumed one."""

MOST = 9
"""Most candidates: their moments are taken at one sample, all of them."""


class AssessedVelocity(NamedTuple):
    """What is known of the Stribeck velocity.

    Attributes
    ----------
    error : float
        How far it may be off, as a standard deviation, rad/s.
    identifiable : bool
        Whether all other candidates leave clearly more error.
    """

    error: float
    identifiable: bool


def candidate_velocities(assumed: float, factors: Sequence[float]) -> NDArray[np.float64]:
    """Return the Stribeck velocities that are tried, rad/s, or raise ``ValueError`` where the factors are no grid."""
    grid = np.array(factors, dtype=float)
    if grid.ndim != 1 or grid.size > MOST or not np.all(np.isfinite(grid)):
        raise ValueError(f"stribeck_factors = {factors} is not allowed: it must be at most {MOST} finite numbers")
    if grid.size > 0 and not (grid[0] > 0.0 and np.all(np.diff(grid) > 0.0) and 1.0 in grid):
        raise ValueError(f"stribeck_factors = {factors} is not allowed: positive, ascending numbers with 1 among them")
    return assumed * grid


def begin_velocity(
    velocities: NDArray[np.float64], assumed: float, model: TorqueModel | Mapping[str, float] | None
) -> float:
    """Return the Stribeck velocity to begin with, rad/s: the candidate next to that of a model, where one is given."""
    if velocities.size == 0 or model is None or isinstance(model, TorqueModel):
        return assumed
    given = float(model.get("stribeck_velocity", assumed))
    if not (math.isfinite(given) and given > 0.0):
        raise ValueError(f"model.stribeck_velocity = {given} is not allowed: it must be positive and finite")
    return float(velocities[np.argmin(np.abs(np.log(velocities / given)))])


def assess_velocity(estimator: EstimatorParameters, state: CandidateState) -> AssessedVelocity:
    """Return how sure the Stribeck velocity in use is.

    It lies anywhere in the cells of the grid around the candidates that do not leave clearly more error.
    """
    velocities = estimator.candidates
    possible = MARGIN * state.errors <= state.errors[state.chosen]
    if state.seen < FIRST * estimator.memory:
        possible[:] = True
    middles = np.sqrt(velocities[1:] * velocities[:-1])
    if middles.size == 0:
        return AssessedVelocity(float(velocities[0]), False)
    ends = velocities[0] ** 2 / middles[0], velocities[-1] ** 2 / middles[-1]
    edges = np.concatenate([ends[:1], middles, ends[1:]])
    places = np.flatnonzero(possible)
    width = float(edges[places[-1] + 1] - edges[places[0]])
    return AssessedVelocity(width / math.sqrt(12.0), places.size == 1)
