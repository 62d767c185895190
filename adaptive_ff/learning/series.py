"""The paper's discrete-time series model, equation (4), with its misprints corrected.

Backward differences in (2) give, with ``D = J tau + J Ts + sigma Ts^2``,

    w(k) = a1 w(k-1) - a2 w(k-2) + b0 u(k) - b1 u(k-1) - c1 g(w(k-1)) - d1 h(w(k-1))

The paper prints ``a1 = (J tau + J Ts)/D``, ``b0 = (Ts^2 + tau Ts^2)/D`` and ``b1 = tau Ts^2/D``. These cannot be
right: with all torques zero a constant velocity must solve (4), so ``a1 - a2 = 1``; and ``b1/b0`` must not depend on
the unit of time.
Used here: ``a1 = (2 J tau + J Ts)/D``, ``b0 = (Ts^2 + tau Ts)/D``, ``b1 = tau Ts/D``.
"""

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from adaptive_ff.friction.model import TorqueModel, stiction_fraction


class SeriesCoefficients(NamedTuple):
    """Coefficients of (4), in the order of the regression."""

    a1: float
    a2: float
    b0: float
    b1: float
    c1: float
    d1: float


COEFFICIENTS = SeriesCoefficients._fields


def series_coefficients(model: TorqueModel, period: float) -> SeriesCoefficients:
    """Return the coefficients of (4) for a joint sampled with a period in s."""
    inertia, lag = model.inertia, model.friction_lag
    denominator = inertia * lag + inertia * period + model.viscous * period**2
    return SeriesCoefficients(
        (2.0 * inertia * lag + inertia * period) / denominator,
        inertia * lag / denominator,
        (period**2 + lag * period) / denominator,
        lag * period / denominator,
        model.coulomb * period**2 / denominator,
        model.stiction * period**2 / denominator,
    )


def series_regressors(
    row: NDArray[np.float64],
    velocities: tuple[float, float],
    torques: tuple[float, float],
    stribeck_velocity: float,
    stribeck_shape: float,
) -> None:
    """Write the regressors ``X(k)`` of (4) into a row of six.

    Parameters
    ----------
    row : ndarray, shape (6,)
        Filled in.
    velocities : tuple of float
        ``w(k-1)`` and ``w(k-2)``, rad/s.
    torques : tuple of float
        ``u(k)`` and ``u(k-1)``, N m. With a held torque, ``u(k)`` is the one that acted over the period that ends
        at ``k``.
    stribeck_velocity, stribeck_shape : float
        ``Vs`` (rad/s) and ``delta`` of (5) and (6).
    """
    last = velocities[0]
    fraction = stiction_fraction(abs(last), stribeck_velocity, stribeck_shape)
    sign = 0.0
    if last > 0.0:
        sign = 1.0
    elif last < 0.0:
        sign = -1.0
    row[0] = last
    row[1] = -velocities[1]
    row[2] = torques[0]
    row[3] = -torques[1]
    row[4] = -sign * (1.0 - fraction)  # g, (5)
    row[5] = -sign * fraction  # h, (6)


def write_physical(coefficients: NDArray[np.float64], period: float, row: NDArray[np.float64]) -> bool:
    """Map coefficients of (4) to physical parameters.

    The map is over-determined by one (six coefficients, five parameters): the inertia is taken from ``a1 - 2 a2``.

    Parameters
    ----------
    coefficients : ndarray, shape (6,)
        ``a1, a2, b0, b1, c1, d1``.
    period : float
        Sampling period ``Ts``, s.
    row : ndarray, shape (5,)
        Filled with ``J, Fc, Fs, sigma, tau``; left as it is where there is no map.

    Returns
    -------
    bool
        Whether there is a map: ``b0 > b1`` and all results are finite.
    """
    a1, a2, b0, b1 = coefficients[0], coefficients[1], coefficients[2], coefficients[3]
    span = b0 - b1
    if not span > 0.0:
        return False
    denominator = period * period / span
    inertia = (a1 - 2.0 * a2) * denominator / period
    lag = b1 * denominator / period
    viscous = (1.0 - a1 + a2) / span
    coulomb = coefficients[4] / span
    stiction = coefficients[5] / span
    if not np.isfinite(inertia + lag + viscous + coulomb + stiction):
        return False
    row[0], row[1], row[2], row[3], row[4] = inertia, coulomb, stiction, viscous, lag
    return True
