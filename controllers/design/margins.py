"""Robustness margins of a sampled loop."""

import math
from collections.abc import Callable
from dataclasses import asdict, dataclass
from typing import Any

import numpy as np
import scipy
from numpy.typing import NDArray

from controllers.checks import check_numbers

FREQUENCIES = 2000
"""Points of the frequency response from the slowest frequency to the Nyquist frequency."""


OpenLoop = tuple[NDArray[Any], NDArray[Any], float]
"""Numerator and denominator of an open loop in ``z``, falling powers, and where its response begins, rad a sample."""


MOST_DELAY = 1000
"""Most periods of delay that a loop is designed for; each makes its polynomials longer."""


def check_design(delay: int, maximum_sensitivity: float = 2.0) -> None:
    """Raise ``ValueError`` for a delay of no whole periods or a bound not above 1, ``TypeError`` for no number."""
    check_numbers(delay=delay, maximum_sensitivity=maximum_sensitivity)
    if not (0 <= delay <= MOST_DELAY and delay % 1 == 0):
        rule = f"it must be a whole number of periods, from zero to {MOST_DELAY}"
        raise ValueError(f"delay = {delay} is not allowed: {rule}")
    if not 1.0 < maximum_sensitivity < math.inf:
        rule = "it must be more than 1, and finite"
        raise ValueError(f"maximum_sensitivity = {maximum_sensitivity} is not allowed: {rule}")


@dataclass(frozen=True)
class LoopMargins:
    """Margins of a loop."""

    crossover: float  # last crossing of gain one as a fraction of the sampling frequency; not a number without one
    maximum_sensitivity: float  # largest ``|1/(1 + L)|``; infinite where the closed loop is unstable
    gain_margin: float  # factor by which the loop gain may grow
    phase_margin: float  # phase margin, degrees; not a number without a crossover

    @property
    def stable(self) -> bool:
        """Whether the closed loop is stable."""
        return math.isfinite(self.maximum_sensitivity)


def in_hertz(margins: LoopMargins, period: float) -> dict[str, float]:
    """Return margins by name, the crossover in Hz for a sampling period in s."""
    return {**asdict(margins), "crossover": margins.crossover / period}


def loop_margins(numerator: NDArray[Any], denominator: NDArray[Any], slowest: float) -> LoopMargins:
    """Return the margins of an open loop."""
    poles = np.roots(np.polyadd(numerator, denominator))
    omega = np.geomspace(slowest, math.pi, FREQUENCIES)
    points = np.exp(1j * omega)
    with np.errstate(all="ignore"):
        value = np.polyval(numerator, points) / np.polyval(denominator, points)
    crossings = np.nonzero(np.abs(value) >= 1.0)[0]
    last = int(crossings[-1]) if crossings.size else -1
    # where the loop is real and negative beyond the crossover: at either end, or the imaginary part changes its sign
    turns = np.nonzero(np.diff(np.sign(value.imag)))[0] + 1
    behind = [each for each in (0, *turns, FREQUENCIES - 1) if each > last and value.real[each] < 0.0]
    return LoopMargins(
        float(omega[last]) / (2.0 * math.pi) if crossings.size else math.nan,
        float(np.max(1.0 / np.abs(1.0 + value))) if bool(np.all(np.abs(poles) < 1.0)) else math.inf,
        1.0 / float(np.abs(value[behind[0]])) if behind else math.inf,
        math.degrees(float(np.angle(-value[last]))) if crossings.size else math.nan,
    )


def largest_setting(opened: Callable[[float], OpenLoop], bound: float, start: float, end: float) -> float:
    """Return the largest setting up to which the maximum sensitivity stays within a bound."""

    def reserve(setting: float) -> float:
        return 1.0 / loop_margins(*opened(setting)).maximum_sensitivity - 1.0 / bound

    slow = start
    while slow < end:
        fast = min(1.2 * slow, end)
        if reserve(fast) < 0.0:
            return float(scipy.optimize.brentq(reserve, slow, fast, xtol=1e-9))
        slow = fast
    return end
