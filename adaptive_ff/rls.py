"""Recursive least squares with a forgetting factor, equations (11)-(13), in a symmetric form.

Below (10) the paper writes the prediction as ``u(k) x P(k-1)``; it is ``X'(k) P(k-1)``. Its (13), evaluated as
printed, ``R(k) = (I - gamma X') R(k-1) / lambda``, loses symmetry by rounding and can diverge; here only one triangle
is computed and copied. Source of the recursion: M. Morf, T. Kailath, L. Ljung, 1976, as cited in the paper.
"""

import numpy as np
from numba.extending import register_jitable
from numpy.typing import NDArray


@register_jitable
def update_rls(
    estimate: NDArray[np.float64],
    covariance: NDArray[np.float64],
    regressors: NDArray[np.float64],
    output: float,
    forgetting_factor: float,
) -> float:
    """Take one equation into account.

    Parameters
    ----------
    estimate : ndarray, shape (n,)
        Parameters ``P``; changed in place.
    covariance : ndarray, shape (n, n)
        Covariance ``R``; changed in place.
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
    size = estimate.size
    projected = np.empty(size)  # R(k-1) X(k)
    error = output
    denominator = forgetting_factor
    for i in range(size):
        total = 0.0
        for j in range(size):
            total += covariance[i, j] * regressors[j]
        projected[i] = total
        error -= regressors[i] * estimate[i]
        denominator += regressors[i] * total
    for i in range(size):
        gain = projected[i] / denominator  # gamma, (12)
        estimate[i] += gain * error  # (11)
        for j in range(i + 1):
            entry = (covariance[i, j] - gain * projected[j]) / forgetting_factor  # (13)
            covariance[i, j] = entry
            covariance[j, i] = entry
    return error
