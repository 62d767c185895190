"""Observer of the velocity of an inertia and of the torque that disturbs it.

The extended state observer and the Kalman filter share it; they differ in their gains.

``J dw/dt = u - d`` with a constant ``d`` is exact for a torque ``u`` held over the period:
``w(k) = w(k-1) + dt/J (u(k-1) - d(k-1))``. The estimate is a *current* one: the newest measurement corrects it before
it is used.
"""

import math
from typing import NamedTuple

from controllers.pi import PIParameters, PIState, asked_torque
from controllers.plausibility import kept
from controllers.registry import Inputs
from controllers.torques import acting_torque


class ObserverState(NamedTuple):
    """Estimated state of the joint."""

    velocity: float = 0.0  # velocity, rad/s
    disturbance: float = 0.0  # torque that opposes the commanded one, N m


class ObservedLoopState(NamedTuple):
    """State of a loop with such an observer."""

    feedback: PIState
    observer: ObserverState = ObserverState()
    known_torque: float = 0.0  # torque known from elsewhere in the last period, N m
    reference: float = 0.0  # last reference, rad/s


def predict(inertia: float, state: ObserverState, torque: float, dt: float) -> ObserverState:
    """Predict the state after a torque (N m) has acted on an inertia (kg m^2) for a time (s)."""
    return ObserverState(state.velocity + dt / inertia * (torque - state.disturbance), state.disturbance)


def correct(state: ObserverState, velocity: float, velocity_gain: float, disturbance_gain: float) -> ObserverState:
    """Correct a predicted state by a measurement.

    Parameters
    ----------
    state : ObserverState
        The prediction.
    velocity : float
        Measured velocity, rad/s.
    velocity_gain : float
        Fraction of the innovation that goes to the velocity.
    disturbance_gain : float
        Torque that the disturbance *loses* for each unit of innovation, N m s/rad, positive: a joint that is faster
        than predicted is disturbed less.
    """
    innovation = velocity - state.velocity
    return ObserverState(state.velocity + velocity_gain * innovation, state.disturbance - disturbance_gain * innovation)


def observe(
    feedback: PIParameters, state: ObservedLoopState, inputs: Inputs, inertia: float, gains: tuple[float, float]
) -> ObserverState:
    """Predict over the period that ends, and correct with gains of velocity and disturbance where one is measured."""
    last, observer = state.feedback, state.observer
    valid = math.isfinite(inputs.velocity)
    if last.samples > last.rejected:  # the observer has started
        torque = acting_torque(inputs, asked_torque(feedback, last), state.known_torque)
        observer = predict(inertia, observer, torque, inputs.dt)
        if valid:
            observer = correct(observer, inputs.velocity, gains[0], gains[1])
    elif valid:
        observer = ObserverState(inputs.velocity, observer.disturbance)
    return ObserverState(kept(observer.velocity), kept(observer.disturbance))


def double_pole_gains(inertia: float, pole: float, dt: float) -> tuple[float, float]:
    """Return the gains of :func:`correct` that put both poles at ``exp(-wo dt)``.

    Parameters
    ----------
    inertia : float
        Inertia, kg m^2.
    pole : float
        Both poles ``wo``, rad/s.
    dt : float
        Time since the last sample, s.
    """
    kept = math.exp(-pole * dt)
    rest = 1.0 - kept
    return 1.0 - kept * kept, inertia * (rest * rest) / dt  # a product: pow() rounds otherwise than a square does
