"""Observer of the velocity of an inertia and of the torque that disturbs it.

The extended state observer and the Kalman filter share it; they differ in their gains.

``J dw/dt = u - d`` with a constant ``d`` is exact for a torque ``u`` held over the period:
``w(k) = w(k-1) + dt/J (u(k-1) - d(k-1))``. The estimate is a *current* one: the newest measurement corrects it before
it is used.
"""

import math
from typing import NamedTuple

from numba.extending import register_jitable


class ObserverState(NamedTuple):
    """Estimated state of the joint.

    Attributes
    ----------
    velocity : float
        Velocity, rad/s.
    disturbance : float
        Torque that opposes the commanded one, N m.
    """

    velocity: float
    disturbance: float


@register_jitable
def predict(inertia: float, state: ObserverState, torque: float, dt: float) -> ObserverState:
    """Predict the state after a torque (N m) has acted on an inertia (kg m^2) for a time (s)."""
    return ObserverState(state.velocity + dt / inertia * (torque - state.disturbance), state.disturbance)


@register_jitable
def correct(state: ObserverState, velocity: float, velocity_gain: float, disturbance_gain: float) -> ObserverState:
    """Correct a predicted state by a measurement.

    Parameters
    ----------
    state : ObserverState
        The prediction.
    velocity : float
        Measured velocity, rad/s.
    velocity_gain : float
        Share of the innovation that goes to the velocity.
    disturbance_gain : float
        Torque that the disturbance *loses* for each unit of innovation, N m s/rad, positive: a joint that is faster
        than predicted is disturbed less.
    """
    innovation = velocity - state.velocity
    return ObserverState(state.velocity + velocity_gain * innovation, state.disturbance - disturbance_gain * innovation)


@register_jitable
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
