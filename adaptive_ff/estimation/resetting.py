"""Recursive estimation with exponential resetting: forgetting that cannot wind up.

The information matrix ``M`` (the inverse of the covariance ``R`` of the paper's (11)-(13), per unit of memory) is a
fading mean of what the instruments ``z`` saw, drawn towards a floor ``M_floor``:

    M(k) = lambda M(k-1) + (1 - lambda) (M_floor + z z')
    P(k) = P(k-1) + (1 - lambda) M(k)^-1 z (y - x' P(k-1))

Without excitation ``M`` returns to the floor, so the gain stays bounded; with ``z = x`` and no floor it is recursive
least squares. With an instrument ``z`` that noise does not touch, its fixed point is the instrumental-variable
estimate, which noise in the regressors ``x`` does not bias. The gain keeps ``z z'`` instead of the usual ``z x'``:
then ``M`` is symmetric and positive definite by construction, and the gain is bounded for every data.

The floor follows J. Lai and D. S. Bernstein, "Exponential resetting and cyclic resetting recursive least squares" (IEEE
Control Systems Letters, 2023); instruments follow P. Young, "Recursive Estimation and Time-Series Analysis"
(Springer, 2011).
"""

import math
from typing import NamedTuple

import numpy as np
from numba.extending import register_jitable
from numpy.typing import NDArray

from adaptive_ff.estimation.quadratic import write_unit_in_place
from controllers.arrays import MutableArray


class ResettingState(NamedTuple):
    """State of the recursion; its arrays are changed in place.

    Attributes
    ----------
    estimate : ndarray, shape (n,)
        Parameters ``P``, in units of their own: who corrects them scales the gain.
    information : ndarray, shape (n, n)
        Information matrix ``M`` of the scaled parameters.
    instrument : ndarray, shape (n,)
        Instrument ``z`` of the last equation, scaled; equal to the regressors for plain least squares.
    gain : ndarray, shape (n,)
        ``(1 - lambda) M^-1 z`` of the last equation, times the number that the update was given.
    factor : ndarray, shape (n, n)
        Cholesky factor of the information matrix, in its lower triangle.
    """

    estimate: MutableArray
    information: MutableArray
    instrument: MutableArray
    gain: MutableArray
    factor: MutableArray


def initial_resetting_state(first: NDArray[np.float64], information: NDArray[np.float64]) -> ResettingState:
    """Return the state for a first estimate, shape (n,), and its information, shape (n, n); both are copied."""
    size = first.size
    return ResettingState(first.copy(), information.copy(), np.zeros(size), np.zeros(size), np.zeros((size, size)))


@register_jitable
def factor_in_place(matrix: NDArray[np.float64]) -> None:
    """Overwrite the lower triangle of a symmetric positive definite matrix by its Cholesky factor."""
    for i in range(matrix.shape[0]):
        for j in range(i):
            total = matrix[i, j]
            for k in range(j):
                total -= matrix[i, k] * matrix[j, k]
            matrix[i, j] = total / matrix[j, j]
        total = matrix[i, i]
        for k in range(i):
            total -= matrix[i, k] * matrix[i, k]
        matrix[i, i] = math.sqrt(total)


@register_jitable
def total_of(vector: NDArray[np.float64]) -> float:
    """Return the sum of a vector: it is not finite where one of its numbers is not."""
    total = 0.0
    for i in range(vector.size):
        total += vector[i]
    return total


@register_jitable
def solve_in_place(factor: NDArray[np.float64], vector: NDArray[np.float64]) -> None:
    """Overwrite a vector by the solution of the equations whose matrix has the given Cholesky factor."""
    size = vector.size
    for i in range(size):
        total = vector[i]
        for k in range(i):
            total -= factor[i, k] * vector[k]
        vector[i] = total / factor[i, i]
    for i in range(size - 1, -1, -1):
        total = vector[i]
        for k in range(i + 1, size):
            total -= factor[k, i] * vector[k]
        vector[i] = total / factor[i, i]


@register_jitable
def move_parameter_in_place(
    factor: NDArray[np.float64], index: int, distance: float, correction: NDArray[np.float64], work: NDArray[np.float64]
) -> None:
    """Move one parameter by a distance, the others along with it so that the fit suffers least.

    Without the others, what the data say only of sums of parameters would be lost.

    Parameters
    ----------
    factor : ndarray, shape (n, n)
        Cholesky factor of the information matrix.
    index : int
        The parameter.
    distance : float
        By how much it moves.
    correction : ndarray, shape (n,)
        Changed in place by the moves of all parameters.
    work : ndarray, shape (n,)
        Scratch.
    """
    write_unit_in_place(work, index)
    solve_in_place(factor, work)
    share = distance / work[index]
    for i in range(work.size):
        correction[i] += share * work[i]


@register_jitable
def prediction_variance_in_place(state: ResettingState) -> float:
    """Return ``z' M^-1 z``: the variance of a prediction, in variances of the error over the length of the memory.

    Factor and gain of the last equation are overwritten; the next update writes them anew.
    """
    size = state.instrument.size
    for i in range(size):
        for j in range(i + 1):
            state.factor[i, j] = state.information[i, j]
        state.gain[i] = state.instrument[i]
    factor_in_place(state.factor)
    solve_in_place(state.factor, state.gain)
    total = 0.0
    for i in range(size):
        total += state.instrument[i] * state.gain[i]
    return total


@register_jitable
def update_resetting_in_place(state: ResettingState, floor: float, keep: float, error: float) -> None:
    """Take one equation into account, of which the instrument is in the state; the estimate is left to the caller.

    Parameters
    ----------
    state : ResettingState
        The state; information, its factor and the gain are changed in place.
    floor : float
        The floor ``M_floor`` is this positive number times the identity.
    keep : float
        Forgetting factor ``lambda``, in (0, 1).
    error : float
        Prediction error ``y - x' P`` for the correction of the parameters in ``state.gain``; 1 for the gain itself.
    """
    information, instrument, factor = state.information, state.instrument, state.factor
    size = instrument.size
    share = 1.0 - keep
    for i in range(size):
        for j in range(i + 1):
            entry = keep * information[i, j] + share * instrument[i] * instrument[j]
            if i == j:
                entry += share * floor
            information[i, j] = entry
            information[j, i] = entry
            factor[i, j] = entry
        state.gain[i] = share * error * instrument[i]
    factor_in_place(factor)
    solve_in_place(factor, state.gain)
