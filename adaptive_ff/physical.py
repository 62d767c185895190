"""Estimates kept physically possible."""

import numpy as np
from numba.extending import register_jitable
from numpy.typing import NDArray

from adaptive_ff.model import TorqueModel

INERTIA, COULOMB, STICTION, VISCOUS, FRICTION_LAG = range(5)

INERTIA_RANGE = 10.0
"""The inertia is believed to lie within this factor of the one that the feedback was designed for."""

LARGEST_LAG = 10.0
"""Largest friction lag that is believed, in time constants ``J/Kp`` of the feedback."""


@register_jitable(forceinline=True)
def confine(estimate: NDArray[np.float64], inertia: float, largest_lag: float) -> None:
    """Move an estimate to the nearest possible one, parameter by parameter.

    Parameters
    ----------
    estimate : ndarray, shape (5,)
        Inertia (kg m^2), Coulomb friction, stiction (N m), viscous coefficient (N m s/rad), friction lag (s);
        changed in place.
    inertia : float
        The inertia that the designer assumes, kg m^2.
    largest_lag : float
        Largest friction lag, s.
    """
    estimate[INERTIA] = min(max(estimate[INERTIA], inertia / INERTIA_RANGE), inertia * INERTIA_RANGE)
    estimate[COULOMB] = max(estimate[COULOMB], 0.0)
    estimate[STICTION] = max(estimate[STICTION], 0.0)
    estimate[VISCOUS] = max(estimate[VISCOUS], 0.0)
    estimate[FRICTION_LAG] = min(max(estimate[FRICTION_LAG], 0.0), largest_lag)


@register_jitable(forceinline=True)
def torque_model(estimate: NDArray[np.float64], stribeck_velocity: float, stribeck_shape: float) -> TorqueModel:
    """Return the model that an estimate stands for; stiction is at least Coulomb friction in it."""
    return TorqueModel(
        estimate[INERTIA],
        estimate[COULOMB],
        max(estimate[STICTION], estimate[COULOMB]),
        estimate[VISCOUS],
        estimate[FRICTION_LAG],
        stribeck_velocity,
        stribeck_shape,
    )


@register_jitable(forceinline=True)
def write_model(model: TorqueModel, row: NDArray[np.float64]) -> None:
    """Write the identified parameters of a model into a row of five."""
    row[INERTIA] = model.inertia
    row[COULOMB] = model.coulomb
    row[STICTION] = model.stiction
    row[VISCOUS] = model.viscous
    row[FRICTION_LAG] = model.friction_lag
