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

from numba.extending import register_jitable

from controllers.checks import check_positive
from controllers.interface import Controller
from controllers.kernels import ESTIMATES, STEPS, Inputs, Output, present_inertia, with_feedforward, without_estimates
from controllers.pi import (
    PIParameters,
    PIState,
    asked_torque,
    check_gains,
    feed_back,
    initial_pi_state,
    plausible_inputs,
)
from controllers.plausibility import kept
from controllers.torques import acting_torque, slope_torque

FIRST, SECOND = 1.5, 1.1
"""Gains of the algorithm, over ``sqrt(L)`` and ``L``."""


class SuperTwistingParameters(NamedTuple):
    """Parameters of the loop with a super-twisting observer.

    Attributes
    ----------
    feedback : PIParameters
        The PI loop.
    inertia : float
        Nominal inertia, kg m^2.
    bound : float
        ``L``, rad/s^3.
    period : float
        Nominal period, s.
    """

    feedback: PIParameters
    inertia: float
    bound: float
    period: float


class SuperTwistingState(NamedTuple):
    """State of the loop with a super-twisting observer.

    Attributes
    ----------
    feedback : PIState
        State of the PI loop.
    velocity : float
        Reconstructed velocity, rad/s.
    disturbance : float
        Estimated disturbance, N m; positive where it opposes the torque.
    impulse : float
        Integral of the acting torque since the last valid measurement, N m s.
    elapsed : float
        Time since then, s.
    known_torque : float
        Torque known from elsewhere in the last period, N m.
    reference : float
        Last reference, rad/s.
    """

    feedback: PIState
    velocity: float
    disturbance: float
    impulse: float
    elapsed: float
    known_torque: float
    reference: float


def initial_super_twisting_state(block: SuperTwistingParameters) -> SuperTwistingState:
    """Return the state of a loop at rest."""
    return SuperTwistingState(initial_pi_state(block.feedback), 0.0, 0.0, 0.0, 0.0, 0.0, 0.0)


@register_jitable
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


@register_jitable
def step_super_twisting(
    block: SuperTwistingParameters, state: SuperTwistingState, inputs: Inputs
) -> tuple[Output, SuperTwistingState]:
    """Do one sample: observe the period that ends, add the disturbance and the inertia's torque, then feedback."""
    inputs, guard = plausible_inputs(block.feedback, state.feedback, inputs)
    last = state.feedback
    impulse = state.impulse + inputs.dt * acting_torque(inputs, asked_torque(block.feedback, last), state.known_torque)
    elapsed = state.elapsed + inputs.dt
    velocity, disturbance = state.velocity, state.disturbance
    if math.isfinite(inputs.velocity):
        if last.samples > last.rejected:  # there is a measurement to compare with
            inertia = present_inertia(inputs, block.inertia)
            predicted = velocity + (impulse - elapsed * disturbance) / inertia
            error, sign = twisted(predicted - inputs.velocity, block.bound, elapsed)
            velocity = inputs.velocity + error
            disturbance += SECOND * inertia * block.bound * elapsed * sign
        else:
            velocity = inputs.velocity
        impulse, elapsed = 0.0, 0.0
    velocity, disturbance, impulse = kept(velocity), kept(disturbance), kept(impulse)
    ahead = slope_torque(block.inertia, inputs, state.reference, last.samples > 0, block.period)
    output, feedback = feed_back(block.feedback, last, with_feedforward(inputs, ahead + disturbance), guard)
    return Output(output.torque, inputs.feedforward + ahead), SuperTwistingState(
        feedback, velocity, disturbance, impulse, elapsed, inputs.feedforward, inputs.reference
    )


STEPS[SuperTwistingParameters] = step_super_twisting
ESTIMATES[SuperTwistingParameters] = without_estimates


class SuperTwisting(Controller):
    """``u = PI(e) + J dr/dt + d``, ``d`` by the super-twisting algorithm from torque and measured velocity.

    Parameters
    ----------
    proportional, integral : float
        Gains of the PI loop, N m s/rad and N m/rad.
    period : float
        Nominal sampling period, s.
    inertia : float
        Nominal inertia, kg m^2.
    bound : float
        ``L``, rad/s^3: the disturbance changes by at most ``J L`` in a second. The larger, the faster and the louder.
    delay : float, optional
        Computation delay of the drive, sampling periods.

    Raises
    ------
    ValueError
        A value is out of range.
    """

    def __init__(
        self,
        proportional: float,
        integral: float,
        period: float,
        *,
        inertia: float,
        bound: float,
        delay: float = 0.0,
    ) -> None:
        feedback = check_gains(proportional, integral, period, delay)
        check_positive(inertia=inertia, bound=bound)
        parameters = SuperTwistingParameters(feedback, float(inertia), float(bound), float(period))
        super().__init__(parameters, period, initial_super_twisting_state)

    @property
    def disturbance(self) -> float:
        """Estimated torque that opposes the commanded one, N m."""
        return float(self.state.disturbance)
