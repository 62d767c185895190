"""Recursive least squares with a forgetting factor, equations (11)-(13), in a symmetric form and as printed.

Below (10) the paper writes the prediction as ``u(k) x P(k-1)``; it is ``X'(k) P(k-1)``. What rounding does depends on
how (13), ``R(k) = (I - gamma X') R(k-1) / lambda``, is evaluated:

- as printed, with the product of two matrices (``update_rls_printed``), an error of rounding fades while the data
  excite all parameters, symmetric or not; ``R`` is symmetric only up to rounding;
- as ``(R - gamma (R X)') / lambda``, which saves a product because (12) has it already, the update is symmetric in
  itself, so nothing acts on an asymmetry that is there: it grows as ``1/lambda^k``, and the recursion diverges;
- here (``update_rls``) one triangle of the latter is computed and copied: no asymmetry, least work.

Without excitation all of them wind up. Source of the recursion: M. Morf, T. Kailath, L. Ljung, 1976, as cited in the
paper; rounding: M. Verhaegen, "Round-off error propagation in four generally-applicable, recursive, least-squares
estimation schemes" (Automatica 25, 1989).
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
    return update_rls_within(estimate, covariance, regressors, output, forgetting_factor, np.empty(estimate.size))


@register_jitable
def project(
    estimate: NDArray[np.float64],
    covariance: NDArray[np.float64],
    regressors: NDArray[np.float64],
    output: float,
    forgetting_factor: float,
    projected: NDArray[np.float64],
) -> tuple[float, float]:
    """Fill in ``R(k-1) X(k)``; return the prediction error ``e(k)`` and the denominator of (12)."""
    error = output
    denominator = forgetting_factor
    for i in range(estimate.size):
        total = 0.0
        for j in range(estimate.size):
            total += covariance[i, j] * regressors[j]
        projected[i] = total
        error -= regressors[i] * estimate[i]
        denominator += regressors[i] * total
    return error, denominator


@register_jitable
def update_rls_within(
    estimate: NDArray[np.float64],
    covariance: NDArray[np.float64],
    regressors: NDArray[np.float64],
    output: float,
    forgetting_factor: float,
    projected: NDArray[np.float64],
) -> float:
    """Do :func:`update_rls` without allocating memory; ``projected``, shape (n,), is filled with ``R(k-1) X(k)``."""
    size = estimate.size
    error, denominator = project(estimate, covariance, regressors, output, forgetting_factor, projected)
    for i in range(size):
        gain = projected[i] / denominator  # gamma, (12)
        estimate[i] += gain * error  # (11)
        for j in range(i + 1):
            entry = (covariance[i, j] - gain * projected[j]) / forgetting_factor  # (13)
            covariance[i, j] = entry
            covariance[j, i] = entry
    return error


@register_jitable
def update_rls_printed(
    estimate: NDArray[np.float64],
    covariance: NDArray[np.float64],
    regressors: NDArray[np.float64],
    output: float,
    forgetting_factor: float,
) -> float:
    """Take one equation into account, (11)-(13) as the paper prints them, in some n^3 operations.

    Arguments and result are those of ``update_rls``, which is the one to use.
    """
    size = estimate.size
    gain = np.empty(size)  # R(k-1) X(k), then gamma
    error, denominator = project(estimate, covariance, regressors, output, forgetting_factor, gain)
    for i in range(size):
        gain[i] /= denominator  # (12)
        estimate[i] += gain[i] * error  # (11)
    updated = np.empty((size, size))
    for i in range(size):
        for j in range(size):
            total = 0.0
            for k in range(size):
                kept = 1.0 if i == k else 0.0
                total += (kept - gain[i] * regressors[k]) * covariance[k, j]
            updated[i, j] = total / forgetting_factor  # (13)
    covariance[:, :] = updated
    return error
