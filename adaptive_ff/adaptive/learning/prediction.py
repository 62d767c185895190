"""What an estimate predicts from a row of the torque-form regression, and the gradient of that by its parameters.

A row holds ``w''_f, w'_f, g_f, h_f, w_f, -u'_f``, the columns of offset, friction by direction and known loads where
they are estimated, and last the derivatives of the loads; see :mod:`adaptive_ff.adaptive.learning.estimator`.
"""

import numpy as np
from numba.extending import register_jitable
from numpy.typing import NDArray

from adaptive_ff.adaptive.learning.estimator_state import EstimatorParameters
from adaptive_ff.friction.bounds import COULOMB, FRICTION_LAG, INERTIA, OFFSET, STICTION_ASYMMETRY


@register_jitable
def add_friction(torque: float, estimate: NDArray[np.float64], row: NDArray[np.float64]) -> float:
    """Add to a torque (N m) the filtered friction, without the offset, that an estimate predicts from regressors."""
    for i in range(COULOMB, FRICTION_LAG):
        torque += estimate[i] * row[i + 1]
    loads = row.size - estimate.size - 1
    for i in range(OFFSET + 1, estimate.size - loads):
        torque += estimate[i] * row[i + 1]
    return torque


@register_jitable
def add_loads(torque: float, estimate: NDArray[np.float64], row: NDArray[np.float64]) -> float:
    """Add to a torque (N m) what an estimate predicts of known loads and their derivatives from regressors."""
    loads = row.size - estimate.size - 1
    for i in range(estimate.size - loads, estimate.size):
        torque += estimate[i] * (row[i + 1] + estimate[FRICTION_LAG] * row[i + 1 + loads])
    return torque


@register_jitable
def predict_torque(estimate: NDArray[np.float64], row: NDArray[np.float64]) -> float:
    """Return the filtered torque (N m) that an estimate predicts from a row of regressors."""
    lag = estimate[FRICTION_LAG]
    prediction = add_friction(estimate[INERTIA] * (row[1] + lag * row[0]) + lag * row[5], estimate, row)
    if estimate.size - (row.size - estimate.size - 1) > OFFSET:
        prediction += estimate[OFFSET] * row[OFFSET + 1]
    return add_loads(prediction, estimate, row)


@register_jitable
def write_gradient(
    estimator: EstimatorParameters,
    estimate: NDArray[np.float64],
    row: NDArray[np.float64],
    gradient: NDArray[np.float64],
) -> None:
    """Write the scaled gradient of the predicted torque by the parameters."""
    for i in range(gradient.size):
        gradient[i] = row[i + 1]
    gradient[INERTIA] += estimate[FRICTION_LAG] * row[0]
    gradient[FRICTION_LAG] += estimate[INERTIA] * row[0]
    loads = row.size - estimate.size - 1
    for i in range(estimate.size - loads, estimate.size):
        gradient[i] += estimate[FRICTION_LAG] * row[i + 1 + loads]
        gradient[FRICTION_LAG] += estimate[i] * row[i + 1 + loads]
    for i in range(gradient.size):
        gradient[i] *= estimator.scale[i] / estimator.torque_scale


@register_jitable
def scale_inertia_in_place(row: NDArray[np.float64], ratio: float) -> None:
    """Multiply the regressors of the inertia by the ratio of the present inertia to the one that is estimated."""
    row[0] *= ratio
    row[1] *= ratio


@register_jitable
def scale_friction_in_place(row: NDArray[np.float64], factor: float, loads: int) -> None:
    """Multiply the regressors of friction, but for the offset and the last ones, of loads, by a factor."""
    for i in range(COULOMB + 1, FRICTION_LAG + 1):
        row[i] *= factor
    for i in range(STICTION_ASYMMETRY + 1, row.size - 2 * loads):
        row[i] *= factor
