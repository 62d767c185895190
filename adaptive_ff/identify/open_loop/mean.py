"""Mean of models for an open-loop simulation, each with a share by how well it simulates what it has not seen.

Choosing one of models that validate alike hangs on the last digits; their mean does not. A structure has the share

    p_m ~ <E_m>^(-B/2)

with its mean squared error ``<E_m>`` over ``B`` blocks that were held out: with normal errors of unknown size, one for
each block, that is its pseudo-likelihood (S. Geisser, W. Eddy, "A predictive approach to model selection", Journal of
the American Statistical Association 74, 1979; as weights of a mean: Y. Yao, A. Vehtari, D. Simpson, A. Gelman, "Using
stacking to average Bayesian predictive distributions", Bayesian Analysis 13, 2018). Of each structure the mean of its
fits without each block counts (bagging: L. Breiman, "Bagging predictors", Machine Learning 24, 1996), which scatter by
where a fit ends.

The mean is that of the parameters, not of the simulated positions, so it is a joint as well. What a model must not do,
which is to have friction that drives it, or a negative inertia, it does not if none of those it is the mean of does.
"""

import math
from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from adaptive_ff.identify.open_loop.simulation import OpenLoopModel, Record
from adaptive_ff.identify.open_loop.slopes import parameters_of, with_parameters
from adaptive_ff.logs.derivatives import Array


class Validated(NamedTuple):
    """A structure of the model, fitted without each block of the training record.

    Attributes
    ----------
    knots : int
        Knots of the force over position.
    by_direction : bool
        Whether viscous friction differs by direction.
    weight : float
        Weight of the shrinkage; zero where nothing depends on the position.
    models : tuple of OpenLoopModel
        Its fits, each without one block.
    squares : tuple of float
        Their mean squared errors on this block, rad^2.
    parameters : float
        Effective number of parameters.
    """

    knots: int
    by_direction: bool
    weight: float
    models: tuple[OpenLoopModel, ...]
    squares: tuple[float, ...]
    parameters: float

    @property
    def error(self) -> float:
        """Its error on blocks that were held out, rad."""
        return math.sqrt(float(np.mean(self.squares)))


def shares_of(squares: Array) -> Array:
    """Return the shares, shape (n,), of structures with these squares on blocks that were held out, shape (n, blocks).

    Where structures leave nothing, these have equal shares.
    """
    left = np.mean(squares, axis=1)
    least = float(np.min(left))
    shares = (left == 0.0).astype(np.float64) if least == 0.0 else (least / left) ** (0.5 * squares.shape[1])
    return np.asarray(shares / np.sum(shares))


def mean_model(models: Sequence[OpenLoopModel], shares: Array) -> OpenLoopModel:
    """Return the model with the mean of the parameters; a single force counts at every knot of the others."""
    finest = max(models, key=lambda model: model.force.size)
    knots = finest.force.size
    rows = [parameters_of(_with_knots(model, knots)) for model in models]
    return with_parameters(finest, np.asarray(shares @ np.array(rows)))


def mean_of_all(structures: Sequence[Validated]) -> tuple[OpenLoopModel, Array]:
    """Return the mean of the fits of all structures, and the share of each structure."""
    shares = shares_of(np.array([one.squares for one in structures]))
    blocks = len(structures[0].models)
    models = [model for one in structures for model in one.models]
    return mean_model(models, np.repeat(shares / blocks, blocks)), shares


def held_out_squares(structures: Sequence[Validated], record: Record, length: int, skipped: int) -> Array:
    """Return the mean squared error of the mean on each block, rad^2, of fits and shares without that block.

    The shares are those by the other blocks; the fits that these were held out from have seen the block.
    """
    squares = np.array([one.squares for one in structures])
    made = np.empty(squares.shape[1])
    for block in range(made.size):
        shares = shares_of(np.delete(squares, block, axis=1))
        mean = mean_model([one.models[block] for one in structures], shares)
        unseen = mean.errors(record, np.array([block * length]), length)[:, skipped:]
        made[block] = float(np.mean(unseen**2))
    return made


def _with_knots(model: OpenLoopModel, knots: int) -> OpenLoopModel:
    if model.force.size not in (1, knots):
        raise ValueError(f"a force with {model.force.size} knots has no mean with one of {knots}, only that with 1 has")
    return model if model.force.size == knots else model._replace(force=np.full(knots, model.force[0]))
