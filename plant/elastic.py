"""One time step of an elastic joint: motor and link, two inertias with a spring between them.

    Jm dwm/dt = u - f - offset - T          T = k theta + c (wm - wl)
    Jl dwl/dt = T                           dtheta/dt = wm - wl

Friction acts at the motor, lagged as in :mod:`plant.step`, and so does the sensor; tracking is judged at the link.

Spring and inertias are discretised by the trapezoidal rule, which takes no energy out of an oscillation (implicit
Euler would take most of it within a few periods), friction and its lag by implicit Euler as in the rigid joint, for an
exact rest. With the means of the step for the spring, ``theta + h/4 (D + D+)`` and ``(D + D+)/2``, ``D = wm - wl``, the
link's equation is linear and is eliminated; what remains is the rigid joint's equation in ``wm+`` with another inertia,
and the same solver serves it. A motor that sticks is exactly at rest while the link goes on swinging.

Of first order in the period. The trapezoidal rule lowers a frequency ``omega`` to ``2/h atan(omega h/2)``.
"""

from typing import Any, NamedTuple

from numba.extending import register_jitable

from plant.change import AnyParameters, JointChange, changed_friction
from plant.friction import Stribeck
from plant.sliding import velocity_under_friction
from plant.step import friction_at


class ElasticParameters(NamedTuple):
    """What the step needs to know of an elastic joint.

    Attributes
    ----------
    motor_inertia, link_inertia : float
        Inertia on either side of the spring, kg m^2, both on the joint's side of the gear.
    friction, backward : Stribeck
        Static friction map of forward and of backward motion of the motor.
    offset : float
        Constant torque against the motor's, N m, of either sign.
    friction_lag : float
        Friction lag ``tau``, s, zero or more.
    link_stiffness : float
        Stiffness ``k`` of the spring, N m/rad.
    link_damping : float
        Damping ``c`` of the spring, N m s/rad.
    """

    motor_inertia: float
    link_inertia: float
    friction: Stribeck
    backward: Stribeck
    offset: float
    friction_lag: float
    link_stiffness: float
    link_damping: float


class ElasticState(NamedTuple):
    """State of an elastic joint.

    Attributes
    ----------
    velocity : float
        Velocity of the link, rad/s.
    friction_torque : float
        Friction torque ``f`` at the motor, N m, without the offset.
    position : float
        Position of the motor, rad.
    motor_velocity : float
        Velocity of the motor, rad/s.
    twist : float
        Position of the motor less that of the link, rad.
    """

    velocity: float
    friction_torque: float
    position: float
    motor_velocity: float
    twist: float


@register_jitable
def step_elastic(joint: ElasticParameters, state: ElasticState, torque: float, period: float) -> ElasticState:
    """Advance an elastic joint by one solver period under constant torque.

    Parameters
    ----------
    joint : ElasticParameters
        The joint.
    state : ElasticState
        State at the start of the step.
    torque : float
        Torque ``u`` at the motor, N m, constant over the step.
    period : float
        Solver period ``h``, s.

    Returns
    -------
    ElasticState
        State at the end of the step. A motor at rest has a velocity of exactly zero.
    """
    motor, link = state.motor_velocity, state.velocity
    lag_divisor = joint.friction_lag + period
    carried = joint.friction_lag * state.friction_torque / lag_divisor
    # the mean torque of the spring, with the link's equation in it, is held + coupling wm+
    gain = 0.25 * period * joint.link_stiffness + 0.5 * joint.link_damping
    share = 1.0 / (1.0 + period * gain / joint.link_inertia)
    coupling = share * gain
    held = share * (joint.link_stiffness * state.twist + gain * (motor - link - link))
    mobility = period / joint.motor_inertia
    divisor = 1.0 + mobility * coupling
    free_velocity = (motor + mobility * (torque - joint.offset - carried - held)) / divisor
    kappa = mobility * period / (lag_divisor * divisor)
    next_motor = velocity_under_friction(joint.friction, joint.backward, free_velocity, kappa, abs(motor))
    static_friction = (free_velocity - next_motor) / kappa
    next_link = link + period / joint.link_inertia * (held + coupling * next_motor)
    half = 0.5 * period
    return ElasticState(
        next_link,
        carried + period * static_friction / lag_divisor,
        state.position + half * (motor + next_motor),
        next_motor,
        state.twist + half * (motor - link + next_motor - next_link),
    )


@register_jitable
def changed_elastic(joint: AnyParameters, change: JointChange) -> AnyParameters:
    """Return a joint of motor and link with a change of its parameters; a payload is the link's, the motor's stays."""
    changed = changed_friction(joint, change)
    return changed._replace(  # type: ignore[no-any-return]
        link_inertia=joint.link_inertia * change.inertia, friction_lag=joint.friction_lag * change.lag
    )


@register_jitable
def sensed_elastic(state: Any) -> float:
    """Return the velocity at the motor, where the sensor of a joint of motor and link sits, rad/s."""
    return state.motor_velocity  # type: ignore[no-any-return]


def initial_elastic(joint: ElasticParameters, velocity: float) -> ElasticState:
    """Return the state of a joint that has moved at a velocity (rad/s) for long: untwisted, its position zero."""
    return ElasticState(velocity, friction_at(joint.friction, joint.backward, velocity), 0.0, velocity, 0.0)
