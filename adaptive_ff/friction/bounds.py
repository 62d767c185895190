"""Estimates kept physically possible."""

import math

import numpy as np
from numpy.typing import NDArray

from adaptive_ff.friction.model import TorqueModel

INERTIA, COULOMB, STICTION, VISCOUS, FRICTION_LAG, OFFSET, STICTION_ASYMMETRY, VISCOUS_ASYMMETRY = range(8)
"""Places in an estimate, which may end before the offset, or after it."""

INERTIA_RANGE = 10.0
"""The inertia is assumed to lie within this factor of the one that the feedback was designed for."""

LARGEST_LAG = 10.0
"""Largest possible friction lag, in time constants ``J/Kp`` of the feedback ..."""

LARGEST_LAG_AT_LEAST = 0.1
"""... but at least this, s: with a fast loop, even the lag of a common joint is many of its time constants."""

VISCOUS_UNIT = 0.2
"""Unit of the viscous coefficient, as a fraction of the proportional gain."""


def possible_ranges(inertia: float, largest_lag: float, size: int) -> NDArray[np.float64]:
    """Return the least and the largest possible value of each parameter of an estimate.

    Parameters
    ----------
    inertia : float
        The inertia that the designer assumes, kg m^2.
    largest_lag : float
        Largest friction lag, s.
    size : int
        Number of parameters.

    Returns
    -------
    ndarray, shape (size, 2)
        In the order and units of the estimate.
    """
    ranges = np.array([[0.0, math.inf]] * OFFSET + [[-math.inf, math.inf]] * (size - OFFSET))
    ranges[INERTIA] = inertia / INERTIA_RANGE, inertia * INERTIA_RANGE
    ranges[FRICTION_LAG] = 0.0, largest_lag
    return ranges


def largest_lag(response: float) -> float:
    """Return the largest possible friction lag (s), for a time constant ``J/Kp`` (s) of the feedback."""
    return max(LARGEST_LAG * response, LARGEST_LAG_AT_LEAST)


def confine_in_place(estimate: NDArray[np.float64], ranges: NDArray[np.float64]) -> None:
    """Move an estimate to the nearest possible one, parameter by parameter."""
    for i in range(estimate.size):
        estimate[i] = min(max(estimate[i], ranges[i, 0]), ranges[i, 1])


def torque_model(
    estimate: NDArray[np.float64],
    lag: float,
    stribeck_velocity: float,
    stribeck_shape: float,
    loads: int = 0,
    rise: float = 1.0,
) -> TorqueModel:
    """Return the model that an estimate stands for, with a friction lag (s) that may be another one.

    The last parameters, so many as there are known loads, are no part of the model. Stiction may be below Coulomb
    friction: friction then rises from standstill on, as that of a joint that creeps, of gears whose friction saturates,
    and of simulations that smooth the sign by a hyperbolic tangent. It counts to ``rise`` of it; at zero, stiction
    is at least Coulomb friction. The viscous coefficient is not negative in either direction.
    """
    stiction = max(estimate[STICTION], estimate[COULOMB] + rise * (estimate[STICTION] - estimate[COULOMB]))
    size = estimate.size - loads
    offset, adhesion, slope = 0.0, 0.0, 0.0
    if size > OFFSET:
        offset = estimate[OFFSET]
    if size > STICTION_ASYMMETRY:
        excess = abs(stiction - estimate[COULOMB])
        adhesion = min(max(estimate[STICTION_ASYMMETRY], -excess), excess)
        slope = min(max(estimate[VISCOUS_ASYMMETRY], -estimate[VISCOUS]), estimate[VISCOUS])
    return TorqueModel(
        inertia=estimate[INERTIA],
        coulomb=estimate[COULOMB],
        stiction=stiction,
        viscous=estimate[VISCOUS],
        friction_lag=lag,
        stribeck_velocity=stribeck_velocity,
        stribeck_shape=stribeck_shape,
        offset=offset,
        stiction_asymmetry=adhesion,
        viscous_asymmetry=slope,
        presliding=0.0,
        micro_damping=0.0,
    )


def write_model(model: TorqueModel, row: NDArray[np.float64], loads: int = 0) -> None:
    """Write the identified parameters of a model into a row of as many as are identified, but for its last, loads."""
    size = row.size - loads
    row[INERTIA] = model.inertia
    row[COULOMB] = model.coulomb
    row[STICTION] = model.stiction
    row[VISCOUS] = model.viscous
    row[FRICTION_LAG] = model.friction_lag
    if size > OFFSET:
        row[OFFSET] = model.offset
    if size > STICTION_ASYMMETRY:
        row[STICTION_ASYMMETRY] = model.stiction_asymmetry
        row[VISCOUS_ASYMMETRY] = model.viscous_asymmetry
