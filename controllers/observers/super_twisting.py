"""PI loop with a disturbance observer by the super-twisting algorithm.

A. Levant, "Sliding order and sliding accuracy in sliding mode control" (1993); as an observer J. Davila, L. Fridman,
A. Levant, "Second-order sliding-mode observer for mechanical systems" (2005). The velocity is reconstructed from the
torque and a disturbance, both corrected by the error ``s = w_hat - w`` of the reconstruction:

    dw_hat/dt = (u - d)/J - 1.5 sqrt(L) |s|^(1/2) sgn(s),     dd/dt = 1.1 J L sgn(s)

``L`` bounds how fast the disturbance changes, as ``|dd/dt| <= J L``; the gains are those of the sources. Without noise
the estimate is exact after a finite time, whatever the disturbance within that bound.

Discretised implicitly (V. Acary, B. Brogliato, Y. Orlov, 2012), so that it does not chatter: ``s`` after a step solves
``s + h k1 |s|^(1/2) sgn(s) + h^2 k2 sgn(s) = b`` with the set-valued sign, in closed form.
"""

import math
from typing import NamedTuple

from controllers.declaration import argument, controller, positive
from controllers.loops import Observing, PILoop
from controllers.pi import PIState, asked_torque, plausible_inputs
from controllers.plausibility import kept
from controllers.registry import Inputs, Output, present_inertia
from controllers.torques import acting_torque, feed_ahead_and_back

FIRST, SECOND = 1.5, 1.1
"""Gains of the algorithm, over ``sqrt(L)`` and ``L``."""


class SuperTwistingState(NamedTuple):
    """State of the loop with a super-twisting observer."""

    feedback: PIState
    velocity: float = 0.0  # reconstructed velocity, rad/s
    disturbance: float = 0.0  # estimated disturbance, N m; positive where it opposes the torque
    impulse: float = 0.0  # integral of the acting torque since the last valid measurement, N m s
    elapsed: float = 0.0  # time since then, s
    known_torque: float = 0.0  # torque known from elsewhere in the last period, N m
    reference: float = 0.0  # last reference, rad/s


def twisted(error: float, bound: float, duration: float) -> tuple[float, float]:
    """Return the error of the reconstruction after a step, and the sign there, a number from -1 to 1.

    Parameters
    ----------
    error : float
        Error that there would be without correction, rad/s.
    bound : float
        ``L``, rad/s^3.
    duration : float
        Length of the step, s.
    """
    size, least = abs(error), SECOND * bound * duration * duration
    if size <= least:
        return 0.0, error / least
    first = FIRST * math.sqrt(bound) * duration
    root = 0.5 * (math.sqrt(first * first + 4.0 * (size - least)) - first)
    sign = 1.0 if error > 0.0 else -1.0
    return sign * root * root, sign


def step_super_twisting(
    parameters: "SuperTwisting", state: SuperTwistingState, inputs: Inputs
) -> tuple[Output, SuperTwistingState]:
    """Do one sample: observe the period that ends, add the disturbance and the inertia's torque, then feedback."""
    inputs, guard = plausible_inputs(parameters.feedback, state.feedback, inputs)
    last = state.feedback
    command = asked_torque(parameters.feedback, last)
    impulse = state.impulse + inputs.dt * acting_torque(inputs, command, state.known_torque)
    elapsed = state.elapsed + inputs.dt
    velocity, disturbance = state.velocity, state.disturbance
    if math.isfinite(inputs.velocity):
        if last.samples > last.rejected:  # there is a measurement to compare with
            inertia = present_inertia(inputs, parameters.inertia)
            predicted = velocity + (impulse - elapsed * disturbance) / inertia
            error, sign = twisted(predicted - inputs.velocity, parameters.bound, elapsed)
            velocity = inputs.velocity + error
            disturbance += SECOND * inertia * parameters.bound * elapsed * sign
        else:
            velocity = inputs.velocity
        impulse, elapsed = 0.0, 0.0
    velocity, disturbance, impulse = kept(velocity), kept(disturbance), kept(impulse)
    output, feedback = feed_ahead_and_back(parameters, state, inputs, guard, disturbance)
    return output, SuperTwistingState(
        feedback, velocity, disturbance, impulse, elapsed, inputs.feedforward, inputs.reference
    )


@controller(step_super_twisting, SuperTwistingState)
class SuperTwisting(PILoop, Observing):
    """``u = PI(e) + J dr/dt + d``, ``d`` by the super-twisting algorithm from torque and measured velocity."""

    inertia: float = argument(positive, "Nominal inertia ``J``, kg m^2.")
    bound: float = argument(
        positive, "``L``, rad/s^3: the disturbance changes by at most ``J L`` in a second; larger is faster and louder."
    )
