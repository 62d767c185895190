"""Proportional-integral velocity loop with anti-windup from the realised torque."""

import math
from collections.abc import Callable
from typing import TYPE_CHECKING, Any, NamedTuple

from controllers.checks import PI_SENSITIVITY, check_numbers, check_period
from controllers.declaration import register
from controllers.delay import check_delay, delay_line, delayed, remember
from controllers.interface import Controller
from controllers.plausibility import Guard, bridging_gain, checked_inputs
from controllers.registry import Inputs, Output

if TYPE_CHECKING:
    from controllers.design.pi_design import PIDesign


class PIParameters(NamedTuple):
    """Parameters of the PI loop."""

    proportional: float  # proportional gain ``Kp``, N m s/rad
    integral: float  # integral gain ``Ki``, N m/rad
    delay: float  # computation delay of the drive, sampling periods; see ``delay``
    period: float  # nominal sampling period, s; it stands in for a time between samples that is not plausible


class PIState(NamedTuple):
    """State of the PI loop."""

    integral: float  # integral part of the torque, N m
    velocity: float  # last valid measurement, rad/s
    # commanded torques, N m, the newest first, as far back as the drive may still apply them
    commands: tuple[float, ...]
    samples: int  # samples so far
    rejected: int  # measurements that were not finite or not plausible
    guard: Guard  # memory of the check of the inputs


def initial_pi_state(parameters: PIParameters) -> PIState:
    """Return the state of a loop at rest."""
    return PIState(0.0, 0.0, delay_line(parameters.delay), 0, 0, Guard())


def asked_torque(pi: PIParameters, state: PIState) -> float:
    """Return the torque (N m) that the drive was asked for over the period that ends now."""
    return delayed(state.commands, pi.delay)


def plausible_inputs(pi: PIParameters, state: PIState, inputs: Inputs) -> tuple[Inputs, Guard]:
    """Return the inputs that a step can rely on; every controller begins with it, and feeds back with the guard."""
    return checked_inputs(inputs, state.guard, pi.proportional, pi.integral, pi.period)


def unwound_integral(pi: PIParameters, state: PIState, inputs: Inputs) -> float:
    """Return the integral (N m) less what of it the drive was asked for and did not give in the period that has ended.

    Anti-windup is back-calculation, with the time constant ``Kp/Ki``.
    """
    integral = state.integral
    if pi.integral > 0.0 and state.samples > 0 and math.isfinite(inputs.realised_torque):
        fraction = 1.0 if pi.proportional <= 0.0 else min(1.0, inputs.dt * pi.integral / pi.proportional)
        integral += fraction * (inputs.realised_torque - asked_torque(pi, state))
    return integral


def feed_back(pi: PIParameters, state: PIState, inputs: Inputs, guard: Guard) -> tuple[Output, PIState]:
    """Do one sample of ``u = Kp e + I + u_ff`` with ``e = reference + correction - velocity``, of checked inputs.

    The integral is a backward Euler sum, ``I(k) = I(k-1) + Ki dt e(k)``: it uses the newest error and so adds no
    delay. Anti-windup comes before it, see ``unwound_integral``.

    Where the measurement is lost nobody knows the error, and the last one would grow with the plan on top of a
    feedforward that follows it already: it is taken for zero. After a while the torque fades to zero; see ``bridging``.
    """
    velocity, rejected, fed = inputs.velocity, state.rejected, inputs.feedforward
    integral = unwound_integral(pi, state, inputs)
    kept, error = integral, inputs.reference + inputs.correction - velocity
    integral += pi.integral * inputs.dt * error
    command = pi.proportional * error + integral + fed
    if not math.isfinite(command):  # as it is where velocity or integral is not finite
        if not math.isfinite(velocity):
            integral, velocity, rejected = kept, state.velocity, rejected + 1
            command = (integral + fed) * bridging_gain(guard.lost)
        if not math.isfinite(command):
            integral, command, fed = 0.0, 0.0, 0.0
            guard = Guard(guard.reference, guard.feedforward, guard.lost, guard.faults + 1)
    commands = remember(state.commands, command)
    return Output(command, fed), PIState(integral, velocity, commands, state.samples + 1, rejected, guard)


def step_pi(pi: PIParameters, state: PIState, inputs: Inputs) -> tuple[Output, PIState]:
    """Do one sample of the PI loop alone; see ``feed_back``."""
    inputs, guard = plausible_inputs(pi, state, inputs)
    return feed_back(pi, state, inputs, guard)


register(PIParameters, step_pi, initial_pi_state)


def check_gains(proportional: float, integral: float, period: float, delay: float = 0.0) -> PIParameters:
    """Return the parameters of a PI loop; arguments and errors are those of :class:`PI`."""
    check_numbers(proportional=proportional, integral=integral, delay=delay)
    check_period(period)
    for name, gain in (("proportional", proportional), ("integral", integral)):
        if not (math.isfinite(gain) and gain >= 0.0):
            raise ValueError(f"{name} = {gain} is not allowed: a gain must be finite and not negative")
    check_delay(delay)
    return PIParameters(float(proportional), float(integral), float(delay), float(period))


class PI(Controller):
    """``u = Kp e + Ki integral(e) + u_ff`` with ``e = reference + correction - velocity``: PI velocity controller.

    It knows no torque limit: clip the torque where it goes to the drive, and hand over what the drive gave as
    ``realised_torque`` at the next step. Without that the integral winds up while the drive saturates.

    Parameters
    ----------
    proportional : float
        Proportional gain, N m s/rad.
    integral : float
        Integral gain, N m/rad.
    period : float
        Nominal sampling period, s.
    delay : float, optional
        Computation delay of the drive, sampling periods: it applies the torque of a sample from that much later on. For
        the anti-windup only; the gains are taken as they are.

    Raises
    ------
    ValueError
        A gain is negative or not finite, the period not positive and finite, or the delay not from 0 to
        ``controllers.delay.LONGEST_DELAY``.
    TypeError
        An argument is no number.

    Examples
    --------
    >>> from controllers import PI
    >>> design = PI.design(inertia=20.0, period=0.01, bandwidth=10.0)
    >>> controller = PI(design.proportional, design.integral, period=0.01)
    >>> torque = controller.step(reference=0.1, velocity=0.0)
    """

    def __init__(self, proportional: float, integral: float, period: float, *, delay: float = 0.0) -> None:
        super().__init__(check_gains(proportional, integral, period, delay), period, initial_pi_state)

    @staticmethod
    def design(
        inertia: float,
        period: float,
        bandwidth: float | None = None,
        *,
        delay: int = 0,
        maximum_sensitivity: float = PI_SENSITIVITY,
        friction: Callable[[float], float] | None = None,
        velocity: Any = None,
    ) -> "PIDesign":
        """Design the gains by robustness margin; arguments and errors are those of :func:`controllers.design_pi`."""
        from controllers.design.pi_design import design_pi

        options = {"maximum_sensitivity": maximum_sensitivity, "friction": friction, "velocity": velocity}
        return design_pi(inertia, period, bandwidth, delay=delay, **options)
