"""What a model of friction lacks, as a part of the errors of its parameters.

What chance leaves of a torque is no function of the motion. What a model lacks is: the same error at the same speed, in
every stroke. Errors by the correlation of the residuals (Newey and West) take it for noise that strokes average out.
So it is looked for, as a discrepancy of the model (M. Kennedy, A. O'Hagan, "Bayesian calibration of computer models",
Journal of the Royal Statistical Society B 63, 2001): with the columns ``X`` of the model, the residual is

    r = (I - X X+) (B c + e),    cov(c) = s^2 I

where ``B`` are functions of the state, hats over the speed by direction of motion and by whether the joint accelerates.
``s^2`` follows from the squares of ``r`` along ``(I - X X+) B``, less those that chance explains, and the parameters
get ``s^2 (X+ B) (X+ B)'`` besides.
"""

import math

import numpy as np

from adaptive_ff.identify.rows.regressors import Problem
from adaptive_ff.learning.batch_least_squares import spread_along
from adaptive_ff.logs.derivatives import Array

HATS = 5
"""Hats over the speed, for each direction and sign of the acceleration: at the largest, at halves of it and at rest."""

CHANCE = 2.0
"""Standard deviations of what chance explains that do not count as discrepancy.

Chosen with logs that none is reported of: with 0, 1 and 2, of 119 logs of :mod:`benchmarks.coverage_driven` 99, 97 and
95 hold the inertia (86 without a discrepancy), with half widths of 6.6, 5.6 and 5.3 % (3.6), and of 100 of
:mod:`benchmarks.coverage`, which lack next to nothing, inertia is held in 100 (0) and 98 (2), and 38 (0) and 37 (2)
instead of 36 are flagged.
"""

FEWEST = 4
"""Rows that a function must have."""

INDEPENDENT = 1e-6
"""Singular value, over the largest, below which functions count as dependent."""


def state_functions(problem: Problem) -> Array:
    """Return the functions of the state on the regressed rows, shape (rows, functions), those that have rows."""
    velocity, acceleration = (
        np.concatenate([getattr(piece, name)[piece.slides] for piece in problem.pieces])
        for name in ("velocity", "acceleration")
    )
    speed = np.abs(velocity)
    knots = np.concatenate([[0.0], float(np.max(speed)) * 2.0 ** np.arange(2.0 - HATS, 1.0)])
    hats = [np.interp(speed, knots, height) for height in np.eye(HATS)]
    accelerates = velocity * acceleration > 0.0
    parts = [(velocity * side > 0.0) & (accelerates == faster) for side in (1.0, -1.0) for faster in (True, False)]
    made = [hat * part for part in parts for hat in hats]
    return np.column_stack([one for one in made if np.count_nonzero(one) >= FEWEST] or [np.zeros_like(speed)])


def discrepancy_covariance(
    functions: Array, columns: Array, inverse: Array, residuals: Array, correlated: int
) -> Array:
    """Return what a discrepancy adds to the covariance of the parameters, shape (n, n).

    Parameters
    ----------
    functions : ndarray, shape (m, k)
        Functions of the state.
    columns : ndarray, shape (m, n)
        Columns of the model, linearly independent.
    inverse : ndarray, shape (n, n)
        What makes them orthonormal, see :class:`~adaptive_ff.learning.batch_least_squares.LeastSquaresFit`.
    residuals : ndarray, shape (m,)
        What the model leaves.
    correlated : int
        Over how many rows residuals are correlated.
    """
    size = columns.shape[1]
    orthogonal = columns @ inverse
    along = orthogonal.T @ functions
    directions, singular, _ = np.linalg.svd(functions - orthogonal @ along, full_matrices=False)
    seen = singular > INDEPENDENT * float(np.linalg.norm(functions))
    if not np.any(seen):
        return np.zeros((size, size))
    directions = directions[:, seen]
    explained = float(np.sum(np.square(directions.T @ residuals)))
    chance = float(np.trace(spread_along(directions, residuals, correlated, size)))
    beyond = explained - chance * (1.0 + CHANCE * math.sqrt(2.0 / directions.shape[1]))
    moved = inverse @ along
    return np.asarray(max(beyond, 0.0) / float(np.sum(singular[seen] ** 2)) * (moved @ moved.T))
