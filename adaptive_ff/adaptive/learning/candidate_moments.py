"""Fading second moments of the rows of the candidates, and what an estimate leaves of them.

They are the normal equations of least squares; see :mod:`adaptive_ff.adaptive.learning.candidates`. A row for which the
candidate in use leaves an error that is out of proportion counts for less, as in P. Huber, "Robust estimation of a
location parameter" (Annals of Mathematical Statistics, 1964): a plan that is wrong for a while tells nothing of the
joint.
"""

import numpy as np
from numba.extending import register_jitable
from numpy.typing import NDArray

from adaptive_ff.adaptive.learning.candidate_state import CandidateState
from adaptive_ff.adaptive.learning.estimator_state import EstimatorParameters
from adaptive_ff.friction.bounds import COULOMB, FRICTION_LAG, INERTIA, STICTION, STICTION_ASYMMETRY
from adaptive_ff.learning.torque_form import DAMPING

OUTLIER = 40.0
"""Squared error of a row, in mean squared errors of the candidate in use, from which on the row counts for less.

Its weight is such that it adds no more than this. Else 2 s of a wrong plan would weigh more than all that is known, and
what the plan did then would pass for bristles.
"""

LEAST_LEFT = 0.0
"""Squared error that an estimate leaves at least, over the mean squared torque: nothing in double precision.

In single precision, what rounding leaves of the moments stands here (``export.single``): below it, errors are none.
"""


@register_jitable
def write_own_columns_in_place(candidates: CandidateState, place: int, factor: float) -> None:
    """Write a candidate's own columns into the row: ``g``, ``h`` and micro-damping; friction is times a factor."""
    row, filters = candidates.row, candidates.filters[place]
    row[COULOMB + 1] = factor * filters[0, 0]
    row[STICTION + 1] = factor * filters[1, 0]
    if filters.shape[0] > 2:
        row[STICTION_ASYMMETRY + 1] = factor * filters[2, 0]
    row[row.size - 2] = 0.0
    if candidates.bent.shape[0] > 0:
        bent = place - (candidates.errors.size - candidates.bent.shape[0])
        if bent >= 0:
            row[row.size - 2] = candidates.bent[bent, DAMPING, 0]


@register_jitable
def left_of(row: NDArray[np.float64], estimate: NDArray[np.float64]) -> float:
    """Return what an estimate leaves of the last element of a row, the torque, or of its products with the others."""
    left = row[estimate.size + 1] - estimate[INERTIA] * (row[1] + estimate[FRICTION_LAG] * row[0])
    for i in range(COULOMB, estimate.size):
        left -= estimate[i] * row[i + 1]
    return left  # type: ignore[no-any-return]


@register_jitable
def robust_share(candidates: CandidateState, share: float, factor: float) -> float:
    """Return the share of the row: less of it where the candidate in use leaves an error that is out of proportion."""
    write_own_columns_in_place(candidates, candidates.chosen, factor)
    left = left_of(candidates.row, candidates.estimates[candidates.chosen])
    most = OUTLIER * candidates.errors[candidates.chosen]
    return share * most / (left * left) if 0.0 < most < left * left else share


@register_jitable
def note_moments_in_place(candidates: CandidateState, share: float, first: int, last: int, factor: float) -> None:
    """Take the row into account with a share, for candidates from one place to before another."""
    row, counted = candidates.row, robust_share(candidates, share, factor)
    for i in range(first, last):
        moments = candidates.moments[i]
        write_own_columns_in_place(candidates, i, factor)
        for j in range(row.size):
            for k in range(j + 1):
                moments[j, k] += counted * (row[j] * row[k] - moments[j, k])


@register_jitable
def complete_in_place(matrix: NDArray[np.float64]) -> None:
    """Write the upper triangle of a symmetric matrix, of which the lower one is given."""
    for i in range(matrix.shape[0]):
        for j in range(i):
            matrix[j, i] = matrix[i, j]


@register_jitable
def residual_moments_in_place(
    moments: NDArray[np.float64], estimate: NDArray[np.float64], correlation: NDArray[np.float64]
) -> float:
    """Return the mean squared error that an estimate leaves, and write its mean products with the regressors."""
    inertia, lag, last = estimate[INERTIA], estimate[FRICTION_LAG], estimate.size + 1
    for j in range(last + 1):
        predicted = inertia * (moments[1, j] + lag * moments[0, j])
        for i in range(COULOMB, estimate.size):
            predicted += estimate[i] * moments[i + 1, j]
        correlation[j] = moments[last, j] - predicted
    least: float = LEAST_LEFT * moments[last, last]
    return max(left_of(correlation, estimate), least)


@register_jitable
def write_information(
    estimator: EstimatorParameters,
    moments: NDArray[np.float64],
    estimate: NDArray[np.float64],
    products: NDArray[np.float64],
    information: NDArray[np.float64],
) -> None:
    """Write the moments of the scaled gradient into the first places of a matrix; ``products`` is scratch."""
    inertia, lag, size = estimate[INERTIA], estimate[FRICTION_LAG], estimate.size
    for j in range(size + 2):
        for i in range(size):
            products[i, j] = moments[i + 1, j]
        products[INERTIA, j] += lag * moments[0, j]
        products[FRICTION_LAG, j] += inertia * moments[0, j]
    unit = estimator.torque_scale * estimator.torque_scale
    for i in range(size):
        for j in range(size):
            product = products[i, j + 1]
            if j == INERTIA:
                product += lag * products[i, 0]
            elif j == FRICTION_LAG:
                product += inertia * products[i, 0]
            information[i, j] = estimator.fit_scale[i] * estimator.fit_scale[j] / unit * product
