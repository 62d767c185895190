"""The velocity loop as python-control systems, ready for ``bode_plot``, ``nyquist_plot`` and ``step_response``."""

import math
from typing import Any, NamedTuple

import control
import numpy as np

from controllers.checks import check_finite, check_positive
from controllers.design.arguments import check_whole_delay

POINTS = 4000
"""Points of the frequency response from a ten thousandth of the Nyquist frequency to it."""


class LoopSystems(NamedTuple):
    """A sampled velocity loop, each part a ``control.TransferFunction`` in ``z``."""

    plant: Any  # from torque (N m) to velocity (rad/s), zero-order hold and delay included
    controller: Any  # from velocity error (rad/s) to torque (N m)
    open_loop: Any  # their product ``L``
    sensitivity: Any  # ``1/(1 + L)``, from reference to error
    closed_loop: Any  # ``L/(1 + L)``, from reference to velocity


class Margins(NamedTuple):
    """Margins of a loop with given gains."""

    stable: bool  # whether the closed loop is stable
    crossover: float  # frequency of the last crossing of gain one, Hz; not a number where there is none
    maximum_sensitivity: float  # largest ``|1/(1 + L)|``; infinite where the loop is unstable
    gain_margin: float  # factor by which the gain of a stable loop may grow
    phase_margin: float  # phase margin of a stable loop, degrees; not a number without a crossover


def loop_systems(
    proportional: float, integral: float, inertia: float, period: float, *, delay: int = 0, friction_slope: float = 0.0
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

    Returns
    -------
    LoopSystems
        Plant, controller, open loop, sensitivity and closed loop.

    Raises
    ------
    ValueError
        An argument is out of range.
    TypeError
        An argument is no number.
    """
    check_positive(inertia=inertia, period=period)
    check_whole_delay(delay)
    check_finite(proportional=proportional, integral=integral, friction_slope=friction_slope)
    pole = math.exp(-friction_slope * period / inertia)
    gain = period / inertia if friction_slope == 0.0 else (1.0 - pole) / friction_slope
    plant = control.tf([gain], np.polymul([1.0, -pole], [1.0, *([0.0] * int(delay))]), period)
    if integral == 0.0:
        controller = control.tf([proportional], [1.0], period)  # no pole that a zero cancels
    else:
        controller = control.tf([proportional + integral * period, -proportional], [1.0, -1.0], period)
    open_loop = plant * controller
    numerator, denominator = open_loop.num[0][0], open_loop.den[0][0]
    characteristic = np.polyadd(numerator, denominator)  # not by feedback(): no pole and zero that cancel are left
    return LoopSystems(
        plant,
        controller,
        open_loop,
        control.tf(denominator, characteristic, period),
        control.tf(numerator, characteristic, period),
    )


def loop_margins_of(systems: LoopSystems) -> Margins:
    """Return the margins of a loop, also of one whose gains no design has chosen.

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
    period = systems.open_loop.dt
    stable = bool(np.all(np.abs(systems.closed_loop.poles()) < 1.0))
    omega = np.geomspace(1e-4, 1.0, POINTS) * math.pi / period
    loop = np.squeeze(control.frequency_response(systems.open_loop, omega).complex)
    above = np.nonzero(np.abs(loop) >= 1.0)[0]
    last = int(above[-1]) if above.size else -1
    # where the loop is real and negative beyond the crossover: the imaginary part changes its sign there
    turns = np.nonzero((np.diff(np.sign(loop.imag)) != 0.0) & (loop.real[1:] < 0.0))[0]
    ends = [POINTS - 1] if loop.real[-1] < 0.0 else []  # at the Nyquist frequency it is real, too
    behind = [*turns[turns > last], *ends]
    return Margins(
        stable,
        float(omega[last]) / (2.0 * math.pi) if above.size else math.nan,
        float(np.max(1.0 / np.abs(1.0 + loop))) if stable else math.inf,
        1.0 / float(np.abs(loop[behind[0]])) if behind else math.inf,
        math.degrees(float(np.angle(-loop[last]))) if above.size else math.nan,
    )
