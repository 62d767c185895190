"""Robustness margins of a sampled loop, with python-control."""

import math
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import control
import numpy as np
from numpy.typing import NDArray
from scipy.optimize import brentq

FREQUENCIES = 2000
"""Points of the frequency response from the slowest frequency to the Nyquist frequency."""


@dataclass(frozen=True)
class LoopMargins:
    """Margins of a loop.

    Attributes
    ----------
    crossover : float
        Frequency of the last crossing of gain one, as a share of the sampling frequency; not a number without one.
    maximum_sensitivity : float
        Largest ``|1/(1 + L)|``; infinite where the closed loop is unstable.
    gain_margin : float
        Factor by which the loop gain may grow.
    phase_margin : float
        Phase margin, degrees; not a number without a crossover.
    """

    crossover: float
    maximum_sensitivity: float
    gain_margin: float
    phase_margin: float

    @property
    def stable(self) -> bool:
        """Whether the closed loop is stable."""
        return math.isfinite(self.maximum_sensitivity)


def loop_margins(numerator: NDArray[Any], denominator: NDArray[Any], slowest: float) -> LoopMargins:
    """Return the margins of an open loop.

    Parameters
    ----------
    numerator, denominator : ndarray
        Polynomials in ``z``, falling powers.
    slowest : float
        Where the frequency response begins, rad a sample, well below the crossover.
    """
    poles = np.roots(np.polyadd(numerator, denominator))
    omega = np.geomspace(slowest, math.pi, FREQUENCIES)
    value = np.squeeze(control.frequency_response(control.tf(numerator, denominator, 1.0), omega).complex)
    crossings = np.nonzero(np.abs(value) >= 1.0)[0]
    last = int(crossings[-1]) if crossings.size else -1
    # where the loop is real and negative beyond the crossover: the imaginary part changes its sign, or ends at Nyquist
    turns = np.nonzero((np.diff(np.sign(value.imag)) != 0.0) & (value.real[1:] < 0.0))[0] + 1
    behind = [*turns[turns > last], *([FREQUENCIES - 1] if value.real[-1] < 0.0 else [])]
    return LoopMargins(
        float(omega[last]) / (2.0 * math.pi) if crossings.size else math.nan,
        float(np.max(1.0 / np.abs(1.0 + value))) if bool(np.all(np.abs(poles) < 1.0)) else math.inf,
        1.0 / float(np.abs(value[behind[0]])) if behind else math.inf,
        math.degrees(float(np.angle(-value[last]))) if crossings.size else math.nan,
    )


def maximum_sensitivity(numerator: NDArray[Any], denominator: NDArray[Any], slowest: float) -> float:
    """Return the maximum sensitivity of :func:`loop_margins` alone, to the bit, for searches that need nothing else."""
    closed = np.polyadd(numerator, denominator)
    if not bool(np.all(np.abs(np.roots(closed)) < 1.0)):
        return math.inf
    points = np.exp(1j * np.geomspace(slowest, math.pi, FREQUENCIES))
    with np.errstate(all="ignore"):
        value = _polynomial(numerator, points) / _polynomial(denominator, points)
    return float(np.max(1.0 / np.abs(1.0 + value)))


def _polynomial(coefficients: NDArray[Any], points: NDArray[Any]) -> NDArray[Any]:
    """Evaluate a polynomial, falling powers, by Horner's rule; leading zeros are left out as python-control does."""
    first = int(np.flatnonzero(coefficients)[0])
    value: NDArray[Any] = np.polyval(coefficients[first:], points)
    return value


def largest_setting(sensitivity: Callable[[float], float], bound: float, start: float, end: float) -> float:
    """Return the largest setting up to which the maximum sensitivity stays within a bound.

    Parameters
    ----------
    sensitivity : callable
        Maximum sensitivity at a setting.
    bound : float
        The bound.
    start, end : float
        The setting to begin with, where the bound must hold, and the largest one to return.
    """

    def reserve(setting: float) -> float:
        return 1.0 / sensitivity(setting) - 1.0 / bound

    slow = start
    while slow < end:
        fast = min(1.2 * slow, end)
        if reserve(fast) < 0.0:
            return float(brentq(reserve, slow, fast, xtol=1e-9))
        slow = fast
    return end
