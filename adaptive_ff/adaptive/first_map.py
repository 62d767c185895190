"""What a controller knows of friction over position before it has learnt, and how sure that is: its first state.

Coefficients ``c_i`` with standard deviations ``s_i``, shares of the friction, begin with the information of the first
model's parameters (:data:`adaptive_ff.adaptive.learning.estimator_state.PRIOR`), in the units of the map,

    D_i = PRIOR (Kp Vs)^2/s_i^2

so they are corrected, and fade with the map's memory, as if that had been learnt. The share that is fed begins with the
evidence that a map of this certainty would have left. Of the squared map ``S``, the mean of ``m^2`` over position, the
mean ``V`` of its variance is not the joint's, so with the Coulomb friction ``Fc`` of the model

    <x^2> = Fc^2 S,    <x y> = <y^2> = Fc^2 max(S - V, 0)

A map that is vaguer than it is large is not fed; it is learnt as every other. What is measured takes the place of this
evidence within a memory of the estimator.
"""

import copy
import math
from collections.abc import Sequence
from functools import partial

import numpy as np
from numpy.typing import NDArray

from adaptive_ff.adaptive.learning.estimator_state import PRIOR, EstimatorParameters
from adaptive_ff.adaptive.learning.friction_map import (
    DOUBT,
    FIRST,
    FULL_SLOPE,
    LARGEST_COEFFICIENT,
    LEAST_SLOPE,
    POSITION,
    MapParameters,
    MapState,
    initial_map,
    map_value,
)
from adaptive_ff.adaptive.supervised_state import SupervisedParameters, SupervisedState
from adaptive_ff.adaptive.supervised_step import initial_supervised_state
from adaptive_ff.friction.bounds import COULOMB
from adaptive_ff.regression.known_loads import INPUT, VALUE
from controllers.checks import checked_array

LEAST_DEVIATION = 0.01
"""Least standard deviation of a coefficient: a map that is surer would not fade."""

POINTS = 4000
"""Positions among which that is sought where a map says nothing."""

Array = NDArray[np.float64]


def with_first_map(
    estimator: EstimatorParameters, coefficients: Sequence[float] | None, deviation: float | Sequence[float]
) -> "partial[SupervisedState] | None":
    """Return what makes the first state of a controller with a first map; None where there is no such map.

    Parameters
    ----------
    estimator : EstimatorParameters
        The estimator, whose map has the same periods and hats.
    coefficients : sequence of float or None
        Cosine and sine of each period, then the hats; shares of the friction.
    deviation : float or sequence of float
        Standard deviation of all of them, or of each; infinite where nothing is known.

    Raises
    ------
    ValueError
        The map is not allowed.
    """
    if coefficients is None:  # a wrong one is not taken in silence, though it is of no use
        _checked_deviation(deviation, np.size(deviation))
        return None
    spread = _checked_deviation(deviation, _count(estimator))
    known = _checked(estimator, coefficients)
    return partial(_initial_state, _begun(estimator, known, spread))


def _initial_state(begun: MapState, parameters: SupervisedParameters) -> SupervisedState:
    state = initial_supervised_state(parameters)
    return state._replace(estimator=state.estimator._replace(friction_map=copy.deepcopy(begun)))


def _count(estimator: EstimatorParameters) -> int:
    """Return how many numbers a map of friction over position has."""
    return int(2 * estimator.friction_map.waves.size + estimator.friction_map.hats)


def _checked(estimator: EstimatorParameters, coefficients: Sequence[float]) -> Array:
    count = _count(estimator)
    if count == 0:
        raise ValueError("position_map is not allowed without position_periods or position_hats")
    if not (estimator.given and estimator.first[COULOMB] > 0.0):
        raise ValueError(
            "position_map is not allowed without a model that has Coulomb friction: its numbers are shares of that"
        )
    known = _numbers("position_map", coefficients, count)
    for place, value in enumerate(known.tolist()):
        if not abs(value) <= LARGEST_COEFFICIENT:
            raise ValueError(
                f"position_map[{place}] = {value:g} is not allowed: it must be from {-LARGEST_COEFFICIENT:g} to "
                f"{LARGEST_COEFFICIENT:g}"
            )
    return known


def _checked_deviation(deviation: float | Sequence[float], count: int) -> Array:
    one_for_all = np.ndim(deviation) == 0
    spread = _numbers("map_deviation", [deviation] * count if one_for_all else deviation, count)
    for place, value in enumerate(spread.tolist()):
        if not value >= 0.0:
            where = "map_deviation" if one_for_all else f"map_deviation[{place}]"
            raise ValueError(
                f"{where} = {value:g} is not allowed: it must be zero or more, or inf for what is not known"
            )
    return np.maximum(spread, LEAST_DEVIATION)


def _numbers(name: str, values: object, count: int) -> Array:
    try:
        array = checked_array(name, values)
    except TypeError as error:
        raise ValueError(f"{name} = {values!r} is not allowed: it must be {count} numbers") from error
    if array.shape != (count,):
        raise ValueError(
            f"{name} has shape {array.shape}; it must be ({count},): cosine and sine of each of position_periods, then "
            "position_hats"
        )
    return array


def _begun(estimator: EstimatorParameters, known: Array, spread: Array) -> MapState:
    """Return the state of a map that begins with coefficients of a certainty."""
    mapped, squared = estimator.friction_map, float(estimator.first[COULOMB]) ** 2
    state = initial_map(mapped)
    place = state.coefficients.size - known.size  # behind that of the load, which is learnt anew
    state.coefficients[place:] = np.where(np.isfinite(spread), known, 0.0)
    state.before[:] = state.coefficients
    state.information[place:] = PRIOR * (estimator.torque_scale / spread) ** 2
    size, doubt = _mean_squares(mapped, state.coefficients[place:], spread)
    explained = max(size - doubt, 0.0)
    state.signals[POSITION, [INPUT, VALUE]] = _silent_position(mapped, state.coefficients)
    if explained == 0.0:
        return state
    slope = explained / (size + DOUBT * explained)
    return state._replace(
        share=min(max((slope - LEAST_SLOPE) / (FULL_SLOPE - LEAST_SLOPE), 0.0), 1.0),
        seen=FIRST * estimator.memory,
        xx=squared * size,
        xy=squared * explained,
        yy=squared * explained,
        friction=squared,
    )


def _mean_squares(mapped: MapParameters, known: Array, spread: Array) -> tuple[float, float]:
    """Return the mean square of a map over position, and of its standard deviation."""
    waves = 2 * mapped.waves.size
    sized = np.isfinite(spread[:waves])
    size, doubt = (0.5 * float(np.sum(numbers[:waves][sized] ** 2)) for numbers in (known, spread))
    visited = np.isfinite(spread[waves:])
    if np.any(visited):
        size += float(np.mean(known[waves:][visited] ** 2))
        doubt += float(np.mean(spread[waves:][visited] ** 2))
    return size, doubt


def _silent_position(mapped: MapParameters, coefficients: Array) -> float:
    """Return a position (rad) at which a map says least: there its filters stand until a position is given."""
    lowest, highest = 0.0, 0.0
    if mapped.waves.size:
        highest = 2.0 * math.pi / float(np.min(mapped.waves))
    if mapped.hats:
        lowest, highest = mapped.lowest, mapped.lowest + mapped.spacing * (mapped.hats - 1)
    positions = np.linspace(lowest, highest, POINTS)
    said = [map_value(mapped, coefficients, position, 0.0) for position in positions.tolist()]
    return float(positions[np.argmin(np.abs(said))])
