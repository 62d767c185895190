"""The velocity loop as python-control systems, ready for ``bode_plot``, ``nyquist_plot`` and ``step_response``."""

import math
from dataclasses import replace
from typing import Any, NamedTuple

import numpy as np

from controllers.checks import check_finite, check_positive
from controllers.design.margins import LoopMargins, check_design, loop_margins
from controllers.design.velocity_filter import filter_of, in_z

SLOWEST = 1e-4
"""Where the frequency response begins, over the Nyquist frequency."""


class LoopSystems(NamedTuple):
    """A sampled velocity loop, each part a ``control.TransferFunction`` in ``z``."""

    plant: Any  # from torque (N m) to velocity (rad/s), zero-order hold and delay included
    controller: Any  # from velocity error (rad/s) to torque (N m)
    velocity_filter: Any  # ``F``, from velocity to what is measured of it; 1 for a sensor of velocity
    open_loop: Any  # the product ``L`` of the three
    sensitivity: Any  # ``1/(1 + L)``, from reference to measured error
    closed_loop: Any  # ``L/(1 + L)``, from reference to measured velocity


def loop_systems(
    proportional: float,
    integral: float,
    inertia: float,
    period: float,
    *,
    delay: int = 0,
    friction_slope: float = 0.0,
    velocity: Any = None,
) -> LoopSystems:
    """Return the systems of a PI velocity loop around a sampled joint.

    Parameters
    ----------
    proportional, integral : float
        Gains, N m s/rad and N m/rad; the integral is a backward Euler sum, as the step kernel has it.
    inertia : float
        Inertia ``J``, kg m^2, positive.
    period : float
        Sampling period ``Ts``, s, positive.
    delay : int, optional
        Computation delay, whole periods.
    friction_slope : float, optional
        Slope of the friction curve at the speed that is looked at, N m s/rad: the viscous coefficient at high speed,
        negative where a Stribeck curve falls.
    velocity : NamedTuple, optional
        Estimator of :mod:`controllers.velocity` that makes the measured velocity of positions.

    Returns
    -------
    LoopSystems
        Plant, controller, velocity filter, open loop, sensitivity and closed loop.

    Raises
    ------
    ValueError
        An argument is out of range.
    TypeError
        An argument is no number.
    """
    import control  # here, not above: it loads matplotlib and scipy.signal, a second that designs of gains do not need

    check_positive(inertia=inertia, period=period)
    check_design(delay)
    check_finite(proportional=proportional, integral=integral, friction_slope=friction_slope)
    pole = math.exp(-friction_slope * period / inertia)
    gain = period / inertia if friction_slope == 0.0 else (1.0 - pole) / friction_slope
    plant = control.tf([gain], np.polymul([1.0, -pole], [1.0, *([0.0] * int(delay))]), period)
    if integral == 0.0:
        controller = control.tf([proportional], [1.0], period)  # no pole that a zero cancels
    else:
        controller = control.tf([proportional + integral * period, -proportional], [1.0, -1.0], period)
    measured = control.tf(*in_z(filter_of(velocity)), period)
    open_loop = plant * controller * measured
    numerator, denominator = open_loop.num[0][0], open_loop.den[0][0]
    characteristic = np.polyadd(numerator, denominator)  # not by feedback(): no pole and zero that cancel are left
    return LoopSystems(
        plant,
        controller,
        measured,
        open_loop,
        control.tf(denominator, characteristic, period),
        control.tf(numerator, characteristic, period),
    )


def loop_margins_of(systems: LoopSystems) -> LoopMargins:
    """Return the margins of a loop, its crossover in Hz, also of one whose gains no design has chosen.

    Parameters
    ----------
    systems : LoopSystems
        The loop, see :func:`loop_systems`.

    Raises
    ------
    TypeError
        It is no such loop.
    """
    if not isinstance(systems, LoopSystems):
        raise TypeError(f"systems = {systems!r} is not allowed: it must be what loop_systems returns")
    loop, period = systems.open_loop, systems.open_loop.dt
    found = loop_margins(loop.num[0][0], loop.den[0][0], SLOWEST * math.pi)
    return replace(found, crossover=found.crossover / period)
