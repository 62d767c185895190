"""Structures of the model that are compared in open loop, each fitted without each block of the training record."""

from collections.abc import Callable, Sequence

import numpy as np

from adaptive_ff.adaptive.learning.friction_map import NO_MAP, MapParameters, coefficient_count
from adaptive_ff.adaptive.learning.map_settings import map_parameters
from adaptive_ff.identify.open_loop.mean import Validated
from adaptive_ff.identify.open_loop.shrinkage import fit_path
from adaptive_ff.identify.open_loop.simulation import FIRST, OpenLoopModel, Record
from adaptive_ff.identify.open_loop.slopes import Training
from adaptive_ff.logs.derivatives import Array

KNOTS = (1, 65)
"""Numbers of knots that are compared: an offset, and a force whose detail the shrinkage limits."""

WEIGHTS = (16.0, 5.0, 1.6, 0.5, 0.16, 0.05)
"""Weights of the shrinkage that are compared, from strong to weak."""

FEWEST_HATS = 4
"""Hats below which no fewer are tried."""

BLOCKS = 5
"""Blocks of the training record; simulations of the training are as long as one."""

SETTLING = 20
"""Samples that do not count at the start of a simulation, as in the benchmark."""


def structures(start: Array, offset: float, record: Record, periods: Sequence[float], hats: int) -> list[OpenLoopModel]:
    """Return the models that fits start from: without and with each map of friction, with each number of knots.

    Parameters
    ----------
    start : ndarray, shape (4,)
        Parameters of ``FIRST``, as the torque of the training record has them.
    offset : float
        Force at every knot, N m.
    record : Record
        The training record.
    periods : sequence of float
        Known periods of the map, rad.
    hats : int
        Largest number of its hats.
    """
    return [
        _begin(np.concatenate([start, np.full(knots, offset)]), variation, record)
        for variation in (NO_MAP, *_maps(periods, hats, record))
        for knots in KNOTS
    ]


def _maps(periods: Sequence[float], hats: int, record: Record) -> list[MapParameters]:
    """Return the maps of friction over position that are compared: with all periods, and each number of hats."""
    if not hats:
        return [map_parameters(periods, 0, None, 0.0, 1.0)] if periods else []
    ends = float(np.min(record.position)), float(np.max(record.position))
    numbers = [hats]
    while numbers[-1] // 2 >= FEWEST_HATS:
        numbers.append(numbers[-1] // 2)
    return [map_parameters(periods, number, ends, 0.0, 1.0) for number in numbers]


def _begin(values: Array, variation: MapParameters, record: Record) -> OpenLoopModel:
    """Return the model that a fit starts from: that of the torque, without anything over the position."""
    low, high = float(np.min(record.position)), float(np.max(record.position))
    inertia, coulomb, viscous, asymmetry = (float(value) for value in values[:4])
    nothing = np.zeros(coefficient_count(variation))
    return OpenLoopModel(inertia, coulomb, viscous, asymmetry, low, high, values[4:], variation, nothing)


def weights_of(begin: OpenLoopModel) -> tuple[float, ...]:
    """Return the weights of the shrinkage that a structure is fitted with."""
    return WEIGHTS if begin.force.size > 1 or begin.coefficients.size else (0.0,)


def work_of(begin: OpenLoopModel) -> int:
    """Return how long the fits of a structure take, in units of one parameter of one fit."""
    return len(weights_of(begin)) * (len(FIRST) + begin.force.size + begin.coefficients.size)


def validated(
    begin: OpenLoopModel, record: Record, *, by_direction: bool, watch: Callable[[float], None]
) -> list[Validated]:
    """Return a structure with each weight of the shrinkage, fitted without each block.

    Parameters
    ----------
    begin : OpenLoopModel
        Where the fits start.
    record : Record
        The log of the training.
    by_direction : bool
        Whether viscous friction may differ by direction.
    watch : callable
        Is called with the share done, after each block.
    """
    knots, weights = begin.force.size, weights_of(begin)
    length = record.position.size // BLOCKS
    blocks = np.arange(BLOCKS) * length
    fits, held = [], np.empty((len(weights), BLOCKS))
    for block in range(BLOCKS):
        training = Training(record, np.delete(blocks, block), length, SETTLING)
        fits.append(fit_path(begin, training, weights, by_direction=by_direction))
        for place, fitted in enumerate(fits[-1]):
            unseen = fitted.model.errors(record, blocks[block : block + 1], length)[:, SETTLING:]
            held[place, block] = float(np.mean(unseen**2))
        watch((block + 1) / BLOCKS)
    made = []
    for weight, squares, same in zip(weights, held, zip(*fits, strict=True), strict=True):
        models, parameters = tuple(one.model for one in same), float(np.mean([one.parameters for one in same]))
        made.append(Validated(knots, by_direction, weight, models, tuple(squares.tolist()), parameters))
    return made
