"""Recursive least squares with a forgetting factor, equations (11)-(13), in a symmetric form and as printed.

Below (10) the paper writes the prediction as ``u(k) x P(k-1)``; it is ``X'(k) P(k-1)``. What rounding does depends on
how (13), ``R(k) = (I - gamma X') R(k-1) / lambda``, is evaluated:

- as printed, with the product of two matrices, an error of rounding fades while the data excite all parameters,
  symmetric or not; ``R`` is symmetric only up to rounding;
- as ``(R - gamma (R X)') / lambda``, which saves a product because (12) has it already, the update is symmetric in
  itself, so nothing acts on an asymmetry that is there: it grows as ``1/lambda^k``, and the recursion diverges;
- here one triangle of the latter is computed and copied: no asymmetry, least work.

Without excitation all of them wind up; ``python -m benchmarks.paper`` compares them. Source of the recursion: M. Morf,
T. Kailath, L. Ljung, 1976, as cited in the paper; rounding: M. Verhaegen, "Round-off error propagation in four
generally-applicable, recursive, least-squares estimation schemes" (Automatica 25, 1989).
"""

import math
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from controllers.arrays import MutableArray


class RLSState(NamedTuple):
    """State of the recursion; its arrays are changed in place."""

    estimate: MutableArray  # shape (n,); parameters ``P``
    covariance: MutableArray  # shape (n, n); covariance ``R``
    gain: MutableArray  # shape (n,); gain ``gamma`` of the last equation, (12)


def initial_rls_state(first: NDArray[np.float64], covariance: NDArray[np.float64]) -> RLSState:
    """Return the state for a first estimate, shape (n,), and its covariance, shape (n, n); both are copied."""
    return RLSState(first.copy(), covariance.copy(), np.zeros(first.size))


def trace(matrix: NDArray[np.float64]) -> float:
    """Return the sum of the diagonal of a square matrix."""
    total = 0.0
    for i in range(matrix.shape[0]):
        total += matrix[i, i]
    return total


def begin_anew_in_place(state: RLSState, variance: float) -> bool:
    """Begin with an estimate of zero and a covariance of a multiple of the identity where one is not finite.

    Returns
    -------
    bool
        Whether that was so.
    """
    total = trace(state.covariance)
    for i in range(state.estimate.size):
        total += state.estimate[i]
    if math.isfinite(total):
        return False
    for i in range(state.estimate.size):
        state.estimate[i] = 0.0
        state.gain[i] = 0.0
        for j in range(state.estimate.size):
            state.covariance[i, j] = variance if i == j else 0.0
    return True


def update_rls_in_place(
    state: RLSState, regressors: NDArray[np.float64], output: float, forgetting_factor: float
) -> float:
    """Take one equation into account.

    Parameters
    ----------
    state : RLSState
        The state; its arrays are changed in place.
    regressors : ndarray, shape (n,)
        Regressors ``X(k)``.
    output : float
        Regressed output ``w(k)``.
    forgetting_factor : float
        ``lambda``, in (0, 1].

    Returns
    -------
    float
        The prediction error before the update, ``e(k)``.
    """
    estimate, covariance, projected = state.estimate, state.covariance, state.gain
    error, denominator = output, forgetting_factor
    for i in range(estimate.size):
        total = 0.0
        for j in range(estimate.size):
            total += covariance[i, j] * regressors[j]
        projected[i] = total  # R(k-1) X(k)
        error -= regressors[i] * estimate[i]
        denominator += regressors[i] * total
    for i in range(estimate.size):
        gain = projected[i] / denominator  # gamma, (12)
        estimate[i] += gain * error  # (11)
        for j in range(i + 1):
            entry = (covariance[i, j] - gain * projected[j]) / forgetting_factor  # (13)
            covariance[i, j] = entry
            covariance[j, i] = entry
    for i in range(estimate.size):
        projected[i] /= denominator  # only now: (13) above needs R X, not the gain
    return error
