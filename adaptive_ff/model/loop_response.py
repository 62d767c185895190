"""What the loop of joint and PI makes of a torque: the model ``G`` behind lag tuning, observer and trust.

An inertia under a PI loop that holds its torques,

    v(k) = v(k-1) + dt/J (x(k-1) - c(k-1)),    c = Kp v_m + Ki sum v_m dt,

with the torque ``x`` put in, the answer ``c`` of the feedback, the drive's computation delay on both, and ``v_m``
lagging behind ``v`` as the measured velocity lags behind the joint's. Friction that depends on the velocity is left
out. The sign is that of a torque that drives the joint.
"""

from typing import NamedTuple

from numba.extending import register_jitable

from controllers import PIParameters, delay_line, delayed, remember

LARGEST_RESPONSE = 1e30
"""Where the response grows beyond this, rad/s, the loop that the gains make is not stable: it starts anew."""


class LoopResponse(NamedTuple):
    """State of the model.

    Attributes
    ----------
    velocity : float
        Velocity that the torque causes.
    measured : float
        The same as the measured velocity shows it.
    integral : float
        Integral part of the feedback's answer.
    commands : tuple of float
        Answers of the feedback, the newest first, as far back as the drive may still apply them.
    """

    velocity: float
    measured: float
    integral: float
    commands: tuple[float, ...]


def initial_loop_response(feedback: PIParameters) -> LoopResponse:
    """Return the state of a loop at rest."""
    return LoopResponse(0.0, 0.0, 0.0, delay_line(feedback.delay))


@register_jitable
def advance_loop_response(
    response: LoopResponse,
    feedback: PIParameters,
    inertia: float,
    velocity_lag: float,
    torque: float,
    duration: float,
) -> LoopResponse:
    """Advance the model over the period that has ended.

    Parameters
    ----------
    response : LoopResponse
        The state.
    feedback : PIParameters
        The PI loop.
    inertia : float
        Inertia that it was designed for, kg m^2.
    velocity_lag : float
        Time by which the measured velocity lags, s.
    torque : float
        Mean torque put in over the period, as the drive applied it.
    duration : float
        Length of the period, s.
    """
    velocity = response.velocity + duration / inertia * (torque - delayed(response.commands, feedback.delay))
    measured = velocity
    if velocity_lag > 0.0:
        measured = response.measured + (velocity - response.measured) * duration / (duration + velocity_lag)
    integral = response.integral + feedback.integral * duration * measured
    command = feedback.proportional * measured + integral
    if not abs(command) < LARGEST_RESPONSE * feedback.proportional:
        velocity, measured, integral, command = 0.0, 0.0, 0.0, 0.0
    return LoopResponse(velocity, measured, integral, remember(response.commands, command))
