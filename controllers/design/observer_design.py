"""Design of a loop with an observer by robustness margin, with python-control.

Every observer here compares the torque that acted with the velocity that it made, and passes the difference through a
filter ``Q`` of its own. With ``q = z^-1``, a nominal inertia and period of 1 and ``d`` periods of delay, the torque is

    u = C (r - w) + Q (q^(1+d) u - (1 - q) w),    C = Kp + Ki/(1 - q),

where the observer knows the *realised* torque, delay included. Where the feedback uses the observer's velocity instead
of the measured one, ``Q`` is replaced by ``S = Q - C R``, with ``R`` the fraction of the same difference by which the
two velocities differ. The open loop is that of :mod:`controllers.design.sampled_loop`.

Margins are those of the joint that the designer assumes. The anti-windup of the PI loop is left out; it does nothing
within the torque limit unless a delay makes the realised torque differ from the last command.
"""

import math
from collections.abc import Callable
from dataclasses import dataclass
from functools import cache
from typing import Any

import numpy as np

from controllers.checks import check_numbers, check_positive
from controllers.design.kalman_gains import scaled_disturbance_gains
from controllers.design.margins import LoopMargins, OpenLoop, check_design, in_hertz, largest_setting, loop_margins
from controllers.design.sampled_loop import Compensation, SampledLoop, open_loop, sampled_loop
from controllers.design.velocity_filter import filter_of
from controllers.observers.inertia_observer import double_pole_gains

SLOWEST = 0.1
"""Bandwidth from which the search for the fastest observer starts, as a fraction of the crossover of the feedback."""


@dataclass(frozen=True)
class ObserverDesign(LoopMargins):
    """A designed observer and the margins of the whole loop.

    Attributes
    ----------
    bandwidth : float
        Bandwidth of the observer, Hz.
    crossover, maximum_sensitivity, gain_margin, phase_margin : float
        Margins of the sampled loop, observer and delay included; the crossover in Hz, the phase margin in degrees.
    """

    bandwidth: float


def on_measured_velocity(velocity_gain: float, disturbance_gain: float) -> Compensation:
    """Return ``Q`` of an observer with gains free of units (see :mod:`controllers.observers.inertia_observer`).

    With gains ``l1`` and ``l2``, ``Q = l2/((1 - q)(1 - (1 - l1) q) + l2 q)``; a disturbance observer has ``l1 = 1``.
    """
    kept = 1.0 - velocity_gain
    return Compensation(np.array([disturbance_gain]), np.array([kept, disturbance_gain - 1.0 - kept, 1.0]))


def on_observed_velocity(loop: SampledLoop, velocity_gain: float, disturbance_gain: float) -> Compensation:
    """Return ``S`` of an observer whose velocity goes to the feedback; see :func:`on_measured_velocity`."""
    direct = on_measured_velocity(velocity_gain, disturbance_gain)
    return Compensation(np.polysub(direct.numerator, (1.0 - velocity_gain) * loop.feedback), direct.denominator)


def disturbance_observer_compensation(loop: SampledLoop, angle: float) -> Compensation:
    """Return ``S`` of a disturbance observer with a bandwidth in radians a sample."""
    return on_measured_velocity(1.0, -math.expm1(-angle))


def extended_state_compensation(loop: SampledLoop, angle: float) -> Compensation:
    """Return ``S`` of an extended state observer with a bandwidth in radians a sample."""
    return on_observed_velocity(loop, *double_pole_gains(1.0, angle, 1.0))


def kalman_compensation(loop: SampledLoop, angle: float) -> Compensation:
    """Return ``S`` of a Kalman filter of the disturbance with a bandwidth in radians a sample."""
    return on_measured_velocity(*scaled_disturbance_gains(angle))


def _opened(loop: SampledLoop, angle: float, compensation: Callable[[SampledLoop, float], Compensation]) -> OpenLoop:
    return *open_loop(loop, compensation(loop, angle)), 0.1 * min(loop.proportional, angle, 1.0)


@cache
def fastest_angle(loop: SampledLoop, bound: float, compensation: Callable[[SampledLoop, float], Compensation]) -> float:
    """Return the largest bandwidth, rad a sample, that a bound on the maximum sensitivity allows."""
    start = SLOWEST * min(loop.proportional, 1.0)
    least = loop_margins(*_opened(loop, start, compensation)).maximum_sensitivity
    if least > bound:
        raise ValueError(
            f"maximum_sensitivity = {bound:g} is not allowed: with the slowest observer the loop has "
            f"{least:.4g} already"
        )
    return largest_setting(lambda angle: _opened(loop, angle, compensation), bound, start, math.pi)


def design_observer(
    inertia: float,
    period: float,
    gains: tuple[float, float],
    bandwidth: float | None,
    delay: int,
    maximum_sensitivity: float,
    compensation: Callable[[SampledLoop, float], Compensation],
    velocity: Any = None,
) -> ObserverDesign:
    """Design an observer for a sampled inertia."""
    check_positive(inertia=inertia, period=period, proportional=gains[0])
    check_numbers(integral=gains[1])
    if not 0.0 <= gains[1] < math.inf:
        raise ValueError(f"integral = {gains[1]} is not allowed: it must be zero or more and finite")
    check_design(delay, maximum_sensitivity)
    loop = sampled_loop(gains[0] * period / inertia, gains[1] * period**2 / inertia, int(delay), filter_of(velocity))
    if bandwidth is None:
        angle = fastest_angle(loop, float(maximum_sensitivity), compensation)
        bandwidth = angle / (2.0 * math.pi * period)
    else:
        check_numbers(bandwidth=bandwidth)
        angle = 2.0 * math.pi * bandwidth * period
    if not 0.0 < bandwidth <= 0.5 / period:
        raise ValueError(f"bandwidth = {bandwidth} is not allowed: it must be positive, at most {0.5 / period:g} Hz")
    reached = loop_margins(*_opened(loop, angle, compensation))
    return ObserverDesign(**in_hertz(reached, period), bandwidth=bandwidth)
