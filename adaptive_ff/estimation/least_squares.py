"""Recursive least squares with a forgetting factor, the paper's (11)-(13), as an estimator of one's own regression.

The recursion is ``rls.update_rls_within``, which is symmetric in rounding. Without excitation the paper's ``R`` grows
without bound; here forgetting pauses while a variance in it is more than ``LARGEST_GROWTH`` times the first one.
"""

import math
from typing import NamedTuple

import numpy as np
from numba.extending import register_jitable
from numpy.typing import ArrayLike, NDArray

from adaptive_ff.estimation.recursive_estimator import RecursiveEstimator, make_settings
from adaptive_ff.estimation.rls import update_rls_within
from adaptive_ff.estimation.updates import CORRECTIONS, Progress, Settings, initial_progress

LARGEST_GROWTH = 1e6
"""Largest growth of a variance beyond the first one, up to one more forgetting factor."""


class LeastSquaresParameters(NamedTuple):
    """Parameters of the estimator: what it is told."""

    settings: Settings


class LeastSquaresState(NamedTuple):
    """State of the estimator.

    Attributes
    ----------
    progress : Progress
        Estimate, its covariance, level of the error.
    covariance : ndarray, shape (n, n)
        ``R`` of (13), in units of the inverse of the variance of the noise that was told; changed in place.
    """

    progress: Progress
    covariance: NDArray[np.float64]


def initial_least_squares_state(block: LeastSquaresParameters) -> LeastSquaresState:
    """Return the state of an estimator that has seen nothing."""
    progress = initial_progress(block.settings)
    return LeastSquaresState(progress, progress.spread.copy())


@register_jitable(forceinline=True)
def correct_least_squares(
    block: LeastSquaresParameters,
    state: LeastSquaresState,
    regressors: NDArray[np.float64],
    instruments: NDArray[np.float64],
    output: float,
    error: float,
    duration: float,
) -> None:
    """Do (11)-(13), and fill in the gain (12)."""
    settings = block.settings
    factor = math.exp(-duration / settings.memory)
    for i in range(regressors.size):
        first = settings.deviation[i] / settings.noise
        if state.covariance[i, i] > LARGEST_GROWTH * first * first:
            factor = 1.0
    update_rls_within(state.progress.estimate, state.covariance, regressors, output, factor, settings.gain)
    denominator = factor
    for i in range(regressors.size):
        denominator += regressors[i] * settings.gain[i]
    for i in range(regressors.size):
        settings.gain[i] /= denominator


CORRECTIONS[LeastSquaresParameters] = correct_least_squares


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
