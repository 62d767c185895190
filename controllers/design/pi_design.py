"""Design of the PI velocity loop by robustness margin, with python-control."""

import math
import warnings
from collections.abc import Callable
from dataclasses import asdict, dataclass
from functools import cache, lru_cache
from typing import Any

import numpy as np

from controllers.checks import PI_SENSITIVITY, check_positive
from controllers.design.margins import LoopMargins, OpenLoop, check_design, largest_setting, loop_margins
from controllers.design.sampled_loop import SampledLoop, open_loop
from controllers.design.systems import LoopSystems, loop_systems
from controllers.design.velocity_filter import NO_FILTER, VelocityFilter, filter_of

INTEGRAL_RATIO = 5.0
"""Ratio of the crossover of the proportional loop to the corner of the integral part."""

SLOWEST = 1e-4
"""Bandwidth times period from which the search for the fastest loop starts."""


@dataclass(frozen=True)
class PIDesign(LoopMargins):
    """A designed PI loop and the margins it reaches.

    Attributes
    ----------
    proportional : float
        Proportional gain ``Kp = 2 pi bandwidth J``, N m s/rad.
    integral : float
        Integral gain ``Ki = Kp 2 pi bandwidth / 5``, N m/rad.
    bandwidth : float
        Open-loop crossover that the gains were made for, Hz.
    crossover, maximum_sensitivity, gain_margin, phase_margin : float
        Margins of the sampled loop, all its parts included; the crossover in Hz, the phase margin in degrees.
    inertia : float
        Inertia that it is for, kg m^2.
    period : float
        Sampling period, s.
    delay : int
        Computation delay, whole periods.
    velocity : NamedTuple or None
        Estimator of :mod:`controllers.velocity` that makes the measured velocity of positions.
    """

    proportional: float
    integral: float
    bandwidth: float
    inertia: float
    period: float
    delay: int
    velocity: Any = None

    def systems(self, friction_slope: float = 0.0) -> LoopSystems:
        """Return plant, controller, open loop, sensitivity and closed loop as python-control systems.

        Parameters
        ----------
        friction_slope : float, optional
            Slope of the friction curve, N m s/rad; negative where it falls.
        """
        gains = (self.proportional, self.integral, self.inertia, self.period)
        return loop_systems(*gains, delay=self.delay, friction_slope=friction_slope, velocity=self.velocity)


def pi_gains(inertia: float, bandwidth: float) -> tuple[float, float]:
    """Return the gains ``(Kp, Ki)`` of a loop with a crossover in Hz for an inertia in kg m^2.

    Raises
    ------
    ValueError
        A value is not positive and finite.
    TypeError
        A value is no number.
    """
    check_positive(inertia=inertia, bandwidth=bandwidth)
    crossover = 2.0 * math.pi * bandwidth
    proportional = crossover * inertia
    return proportional, proportional * crossover / INTEGRAL_RATIO


def design_pi(
    inertia: float,
    period: float,
    bandwidth: float | None = None,
    *,
    delay: int = 0,
    maximum_sensitivity: float = PI_SENSITIVITY,
    friction: Callable[[float], float] | None = None,
    velocity: Any = None,
) -> PIDesign:
    """Design a PI velocity loop for a sampled inertia.

    The plant is the inertia behind a zero-order hold and whole periods of delay; the controller has its integral as
    a backward Euler sum, as the step kernel has. What makes a velocity of an encoder's positions is part of the loop.

    Parameters
    ----------
    inertia : float
        Inertia ``J``, kg m^2, positive.
    period : float
        Sampling period ``Ts``, s, positive.
    bandwidth : float, optional
        Open-loop crossover, Hz, positive. By default the largest one that the margin allows.
    delay : int, optional
        Computation delay, whole periods.
    maximum_sensitivity : float, optional
        Bound on ``max |1/(1 + L)|``, more than 1.
    friction : callable, optional
        Friction torque (N m) of the joint when it slides at a speed (rad/s). Where the curve falls more steeply than
        ``Kp``, the loop hunts by itself, and a warning says so.
    velocity : NamedTuple, optional
        Estimator that makes the measured velocity of positions, such as :func:`controllers.low_pass_velocity` returns.

    Returns
    -------
    PIDesign
        Gains and the margins reached.

    Raises
    ------
    ValueError
        An argument is out of range, or the margin does not allow the bandwidth; the message names the largest
        bandwidth that it does allow.
    TypeError
        An argument is no number, the friction not callable, or the estimator of no known class.

    Warns
    -----
    UserWarning
        The gain cannot hold the falling part of the friction curve.
    """
    check_positive(inertia=inertia)
    if friction is not None and not callable(friction):
        raise TypeError(f"friction = {friction!r} is not allowed: it must be a function of the speed")
    _check_loop(period, delay, maximum_sensitivity)
    bound = (period, delay, maximum_sensitivity, velocity)
    if bandwidth is None:
        bandwidth = fastest_bandwidth(*bound)
    check_positive(bandwidth=bandwidth)
    relative = max(bandwidth * period, SLOWEST)  # margins no longer depend on a bandwidth slower than that
    if relative > 0.5 or _margins(relative, int(delay), filter_of(velocity)).maximum_sensitivity > maximum_sensitivity:
        largest = fastest_bandwidth(*bound)
        if bandwidth > largest * (1.0 + 1e-6):
            filtered = "" if filter_of(velocity) == NO_FILTER else " and velocity filter"
            raise ValueError(
                f"bandwidth = {bandwidth:g} Hz is not allowed: with a period of {period:g} s, {int(delay)} periods of "
                f"delay{filtered} and a maximum sensitivity of {maximum_sensitivity:g} it must be at most "
                f"{largest:.7g} Hz"
            )
    proportional, integral = pi_gains(inertia, bandwidth)
    if friction is not None:
        _warn_of_hunting(friction, proportional)
    margins = _margins(relative, int(delay), filter_of(velocity))
    return PIDesign(
        **{**asdict(margins), "crossover": margins.crossover * bandwidth / relative},
        proportional=proportional,
        integral=integral,
        bandwidth=bandwidth,
        inertia=inertia,
        period=period,
        delay=int(delay),
        velocity=velocity,
    )


def fastest_bandwidth(
    period: float, delay: int = 0, maximum_sensitivity: float = PI_SENSITIVITY, velocity: Any = None
) -> float:
    """Return the largest bandwidth (Hz) for which the maximum sensitivity stays within a bound.

    Parameters
    ----------
    period : float
        Sampling period, s, positive.
    delay : int, optional
        Computation delay, whole periods.
    maximum_sensitivity : float, optional
        Bound on the maximum sensitivity, more than 1.
    velocity : NamedTuple, optional
        Estimator that makes the measured velocity of positions.

    Raises
    ------
    ValueError
        An argument is out of range, or no bandwidth meets the bound.
    TypeError
        An argument is no number, or the estimator of no known class.
    """
    _check_loop(period, delay, maximum_sensitivity)
    return _fastest_relative(int(delay), float(maximum_sensitivity), filter_of(velocity)) / period


def _check_loop(period: float, delay: int, maximum_sensitivity: float) -> None:
    check_positive(period=period)
    check_design(delay, maximum_sensitivity)


@cache
def _fastest_relative(delay: int, maximum_sensitivity: float, velocity: VelocityFilter) -> float:
    """Return the largest bandwidth times period within a bound on the maximum sensitivity."""
    least = _margins(SLOWEST, delay, velocity).maximum_sensitivity
    if least > maximum_sensitivity:
        raise ValueError(
            f"maximum_sensitivity = {maximum_sensitivity:g} is not allowed: even the slowest loop has {least:.3f}"
        )
    return largest_setting(lambda relative: _loop(relative, delay, velocity), maximum_sensitivity, SLOWEST, 0.5)


def _loop(relative_bandwidth: float, delay: int, velocity: VelocityFilter) -> OpenLoop:
    """Return numerator and denominator of the open loop with inertia 1 and period 1, and where its response begins."""
    loop = SampledLoop(*pi_gains(1.0, relative_bandwidth), delay, velocity)
    return *open_loop(loop), 1e-2 * 2.0 * math.pi * relative_bandwidth


@lru_cache(maxsize=256)
def _margins(relative_bandwidth: float, delay: int, velocity: VelocityFilter) -> LoopMargins:
    """Return the margins for inertia 1 and period 1; a real loop behaves alike at the same bandwidth times period."""
    return loop_margins(*_loop(relative_bandwidth, delay, velocity))


def _warn_of_hunting(friction: Callable[[float], float], proportional: float) -> None:
    speeds = np.geomspace(1e-6, 100.0, 4001)
    torques = np.array([friction(speed) for speed in speeds])
    fall = float(np.max(-np.diff(torques) / np.diff(speeds)))
    if fall > proportional:
        warnings.warn(
            f"the friction curve falls by up to {fall:.4g} N m s/rad, more than the proportional gain of "
            f"{proportional:.4g} N m s/rad can hold: the loop will hunt at low speed",
            stacklevel=3,
        )
