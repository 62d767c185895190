"""Which Stribeck velocities are tried, and what the candidates tell of how sure the one in use is."""

import math
from collections.abc import Mapping, Sequence
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from adaptive_ff.adaptive.learning.candidate_margins import MARGIN
from adaptive_ff.adaptive.learning.candidate_state import CandidateState
from adaptive_ff.adaptive.learning.candidates import FIRST
from adaptive_ff.adaptive.learning.estimator_state import EstimatorParameters
from adaptive_ff.friction.model import TorqueModel
from controllers.checks import check_positive, checked_array

FACTORS = (0.25, 0.5, 1.0, 2.0, 4.0)
"""Stribeck velocities of the candidates, over the assumed one."""

BENT_FACTORS = (1.0, 3.0, 10.0, 30.0, 100.0)
"""Presliding distances of the candidates, over the assumed Stribeck velocity by the pole of the filters."""

MOST = 10
"""Most candidates: their moments are taken at one sample, all of them."""


class Choice(NamedTuple):
    """What is known of a value that is chosen.

    Attributes
    ----------
    name : str
        Name of the estimate.
    value : float
        The one in use.
    error : float
        How far it may be off, as a standard deviation.
    identifiable : bool
        Whether all other candidates leave clearly more error.
    """

    name: str
    value: float
    error: float
    identifiable: bool


def chosen_names(factors: Sequence[float], bent: Sequence[float]) -> tuple[str, ...]:
    """Return the names of the estimates that are chosen among candidates, or raise ``ValueError`` for no such set."""
    if len(bent) > 0 and len(factors) == 0:
        raise ValueError(f"presliding_factors = {bent} is not allowed without stribeck_factors")
    if len(bent) + len(factors) > MOST:
        raise ValueError(f"presliding_factors = {bent} is not allowed: with stribeck_factors at most {MOST}")
    return (*(["stribeck_velocity"] if len(factors) > 0 else []), *(["presliding"] if len(bent) > 0 else []))


def candidate_distances(unit: float, factors: Sequence[float]) -> NDArray[np.float64]:
    """Return the presliding distances that are tried, rad, or raise ``ValueError`` where the factors are no grid."""
    grid = checked_array("presliding_factors", factors)
    if grid.ndim != 1 or not np.all(np.isfinite(grid)) or np.any(grid <= 0.0) or np.any(np.diff(grid) <= 0.0):
        raise ValueError(f"presliding_factors = {factors} is not allowed: positive, ascending numbers")
    return unit * grid


def candidate_velocities(assumed: float, factors: Sequence[float]) -> NDArray[np.float64]:
    """Return the Stribeck velocities that are tried, rad/s, or raise ``ValueError`` where the factors are no grid."""
    grid = checked_array("stribeck_factors", factors)
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
    given = model.get("stribeck_velocity", assumed)
    check_positive(**{"model.stribeck_velocity": given})
    return float(velocities[np.argmin(np.abs(np.log(velocities / given)))])


def assess_choice(estimator: EstimatorParameters, state: CandidateState) -> tuple[Choice, ...]:
    """Return how sure Stribeck velocity and presliding distance in use are, as far as they are chosen.

    Each lies anywhere in the cells of its grid around the candidates that do not leave clearly more error.
    """
    count, found = estimator.candidates.size, []
    possible = MARGIN * state.errors <= state.errors[state.chosen : state.chosen + 1]
    if state.seen < FIRST * estimator.memory:
        possible[:] = True
    if count > 0:
        own = possible[:count] if np.any(possible[:count]) else estimator.candidates == state.stribeck_velocity
        found.append(Choice("stribeck_velocity", state.stribeck_velocity, *_spread(estimator.candidates, own)))
    if estimator.presliding.size > 0:
        grid = np.concatenate([[0.0], estimator.presliding])
        own = np.concatenate([[bool(np.any(possible[:count]))], possible[count:]])
        found.append(Choice("presliding", state.presliding, *_spread(grid, own)))
    return tuple(found)


def _spread(grid: NDArray[np.float64], possible: NDArray[np.bool_]) -> tuple[float, bool]:
    """Return the standard deviation of a value in the cells that are possible, and whether that is one cell."""
    if grid.size == 1:
        return float(grid[0]), False
    middles = 0.5 * (grid[1:] + grid[:-1])
    edges = np.concatenate([[max(0.0, 2.0 * grid[0] - middles[0])], middles, [2.0 * grid[-1] - middles[-1]]])
    places = np.flatnonzero(possible)
    width = float(edges[places[-1] + 1] - edges[places[0]])
    return width / math.sqrt(12.0), places.size == 1
