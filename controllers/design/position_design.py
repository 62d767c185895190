"""Design of the position loop by robustness margin, with python-control."""

import math
from dataclasses import dataclass
from typing import Any

import numpy as np

from controllers.checks import PI_SENSITIVITY, check_positive
from controllers.design.margins import LoopMargins, OpenLoop, check_design, in_hertz, largest_setting, loop_margins
from controllers.design.pi_design import pi_gains
from controllers.design.velocity_filter import VelocityFilter, filter_of, in_z

BANDWIDTH_FRACTION = 1.0 / 6.0
"""Default position gain, as a fraction of the angular bandwidth of the velocity loop."""

LEAST_GAIN = 2e-3 * math.pi
"""Position gain at which the search for the largest begins, as a fraction of the bandwidth of the velocity loop."""


@dataclass(frozen=True)
class PositionDesign(LoopMargins):
    """A designed position loop and the margins of the cascade.

    Attributes
    ----------
    gain : float
        Position gain ``Kv``, 1/s.
    crossover, maximum_sensitivity, gain_margin, phase_margin : float
        Margins of the position loop; the crossover in Hz, the phase margin in degrees.
    """

    gain: float


def default_position_gain(bandwidth: float) -> float:
    """Return the position gain (1/s) for a bandwidth of the velocity loop (Hz)."""
    check_positive(bandwidth=bandwidth)
    return BANDWIDTH_FRACTION * 2.0 * math.pi * bandwidth


def design_position_loop(
    period: float,
    bandwidth: float,
    gain: float | None = None,
    *,
    delay: int = 0,
    maximum_sensitivity: float = PI_SENSITIVITY,
    velocity: Any = None,
) -> PositionDesign:
    """Design a position loop around the PI velocity loop of :func:`controllers.design_pi`.

    The joint is an inertia behind a zero-order hold and whole periods of delay, its position measured at the samples.

    Parameters
    ----------
    period : float
        Sampling period, s.
    bandwidth : float
        Bandwidth of the velocity loop, Hz: its open-loop crossover.
    gain : float, optional
        Position gain, 1/s; by default a sixth of the angular bandwidth, ``2 pi bandwidth/6``.
    delay : int, optional
        Computation delay, whole periods.
    maximum_sensitivity : float, optional
        Bound on ``max |1/(1 + L)|`` of the position loop, more than 1.
    velocity : NamedTuple, optional
        Estimator of :mod:`controllers.velocity` that makes the velocity loop's velocity of positions.

    Raises
    ------
    ValueError
        An argument is out of range, or the margin does not allow the gain; the message names the largest one that it
        does allow.
    TypeError
        An argument is no number.
    """
    check_positive(period=period, bandwidth=bandwidth)
    check_design(delay, maximum_sensitivity)
    gain = default_position_gain(bandwidth) if gain is None else gain
    check_positive(gain=gain)
    relative, filtered = bandwidth * period, filter_of(velocity)

    def opened(setting: float) -> OpenLoop:
        return _opened(relative, setting, int(delay), filtered)

    reached = loop_margins(*opened(gain * period))
    if not reached.maximum_sensitivity <= maximum_sensitivity:
        start = LEAST_GAIN * relative
        if not loop_margins(*opened(start)).maximum_sensitivity <= maximum_sensitivity:
            raise ValueError(
                f"bandwidth = {bandwidth:g} Hz is not allowed: with {int(delay)} periods of {period:g} s of delay no "
                f"position gain keeps a maximum sensitivity of {maximum_sensitivity:g}"
            )
        largest = largest_setting(opened, maximum_sensitivity, start, 1.0)
        raise ValueError(
            f"gain = {gain:g} 1/s is not allowed: with a velocity loop of {bandwidth:g} Hz, a period of {period:g} s, "
            f"{int(delay)} periods of delay and a maximum sensitivity of {maximum_sensitivity:g} it must be at most "
            f"{largest / period:.6g} 1/s"
        )
    return PositionDesign(**in_hertz(reached, period), gain=gain)


def _opened(relative_bandwidth: float, setting: float, delay: int, velocity: VelocityFilter) -> OpenLoop:
    """Return the open loop for inertia 1 and period 1.

    With the velocity loop ``L_v = (Kp + Ki z/(z - 1)) z^-d/(z - 1)`` closed and the position ``(z + 1)/(2 (z - 1)^2)``
    of the held torque, ``L = Kv (z + 1)/2 B/((z - 1) ((z - 1)^2 z^d + F B))`` with ``B = (Kp + Ki) z - Kp`` and the
    velocity filter ``F``.
    """
    proportional, integral = pi_gains(1.0, relative_bandwidth)
    feedback = np.array([proportional + integral, -proportional])
    above, below = in_z(velocity)
    closed = np.polyadd(np.polymul(below, [1.0, -2.0, 1.0, *([0.0] * delay)]), np.polymul(above, feedback))
    numerator = setting * np.polymul(np.polymul([0.5, 0.5], feedback), below)
    return numerator, np.polymul(np.array([1.0, -1.0]), closed), 1e-2 * min(setting, 1.0)
