"""Recursive least squares with a forgetting factor, the paper's (11)-(13), as an estimator of one's own regression.

The recursion is ``rls.update_rls_in_place``, which is symmetric in rounding. Without excitation the paper's ``R`` grows
without bound; here forgetting pauses while a variance in it is more than ``LARGEST_GROWTH`` times the first one.
"""

import math
from typing import NamedTuple

import numpy as np
from numba.extending import register_jitable
from numpy.typing import ArrayLike, NDArray

from adaptive_ff.estimation.recursive_estimator import RecursiveEstimator, make_settings
from adaptive_ff.estimation.updates import CORRECTIONS, EstimationState, Settings, initial_spread, initial_state
from adaptive_ff.learning.rls import initial_rls_state, update_rls_in_place

LARGEST_GROWTH = 1e6
"""Largest growth of a variance beyond the first one, up to one more forgetting factor."""


class LeastSquaresParameters(NamedTuple):
    """Parameters of the estimator: its settings."""

    settings: Settings


def initial_least_squares_state(block: LeastSquaresParameters) -> EstimationState:
    """Return the state of an estimator that has seen nothing."""
    settings = block.settings
    return initial_state(settings, initial_rls_state(settings.first, initial_spread(settings)))


@register_jitable
def correct_least_squares_in_place(
    block: LeastSquaresParameters,
    state: EstimationState,
    regressors: NDArray[np.float64],
    instruments: NDArray[np.float64],
    output: float,
    error: float,
    duration: float,
) -> None:
    """Do (11)-(13)."""
    settings, covariance = block.settings, state.recursion.covariance
    factor = math.exp(-duration / settings.memory)
    for i in range(regressors.size):
        first = settings.deviation[i] / settings.noise
        if covariance[i, i] > LARGEST_GROWTH * first * first:
            factor = 1.0
    update_rls_in_place(state.recursion, regressors, output, factor)


CORRECTIONS[LeastSquaresParameters] = correct_least_squares_in_place


class LeastSquares(RecursiveEstimator):
    """Recursive least squares.

    Parameters
    ----------
    first : array_like, shape (n,)
        First estimate.
    period : float
        Nominal time between equations, s.
    first_deviation : float or array_like, shape (n,)
        How far, as a standard deviation, each parameter may be from the first estimate. With ``noise`` it makes the
        paper's ``R(0)``: ``(first_deviation / noise)^2`` on the diagonal.
    noise : float
        Expected standard deviation of an equation's error, unit of the output.
    memory : float, optional
        Memory, s: an equation counts ``exp(-age/memory)``, the paper's ``lambda`` is ``exp(-period/memory)``. By
        default nothing is forgotten.

    Raises
    ------
    ValueError
        A value is out of range.

    Examples
    --------
    >>> from adaptive_ff.estimation import LeastSquares
    >>> estimator = LeastSquares([0.0, 0.0], 0.01, first_deviation=100.0, noise=0.1)
    >>> for speed in (0.1, 0.2, 0.3, 0.4):
    ...     error = estimator.update([1.0, speed], 60.0 + 80.0 * speed)
    >>> [round(float(value), 2) for value in estimator.estimate]
    [60.0, 80.0]
    """

    def __init__(
        self,
        first: ArrayLike,
        period: float,
        *,
        first_deviation: ArrayLike,
        noise: float,
        memory: float = math.inf,
    ) -> None:
        settings = make_settings(first, first_deviation, noise, memory)
        super().__init__(LeastSquaresParameters(settings), period, initial_least_squares_state)
