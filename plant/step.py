"""One implicit time step of a joint with set-valued friction and friction lag.

The joint is ``J dw/dt = u - f - offset`` (Fig. 1 of the paper, and a constant torque) with ``tau df/dt + f = F(w)``,
equation (1). Each direction has a friction map of its own. All is discretised by the implicit Euler method, because
only an implicit step can keep a joint exactly at rest: with ``F(0) = [-Fs, Fs]`` the friction torque at rest is an
unknown of the step, not a value of a function. The step is of first order in the solver period; for ``tau = 0`` it is
the classic Coulomb time step.
"""

import math
from typing import NamedTuple

from numba.extending import register_jitable

from plant.change import JointChange, changed_curve
from plant.friction import Stribeck, scaled, sliding_friction, sliding_friction_and_slope

MAXIMUM_ITERATIONS = 80
RELATIVE_TOLERANCE = 1e-12  # Newton converges quadratically: the error left is about its square


class JointParameters(NamedTuple):
    """What the step needs to know of a joint.

    Attributes
    ----------
    inertia : float
        Inertia ``J``, kg m^2.
    friction : Stribeck
        Static friction map ``F`` of forward motion.
    backward : Stribeck
        Static friction map of backward motion.
    offset : float
        Constant torque against the motor's, N m, of either sign.
    friction_lag : float
        Friction lag ``tau``, s, zero or more.
    """

    inertia: float
    friction: Stribeck
    backward: Stribeck
    offset: float
    friction_lag: float


class JointState(NamedTuple):
    """State of a joint.

    Attributes
    ----------
    velocity : float
        Velocity ``w``, rad/s.
    friction_torque : float
        Friction torque ``f``, N m, without the offset.
    position : float
        Position, rad.
    """

    velocity: float
    friction_torque: float
    position: float


@register_jitable
def sliding_speed(friction: Stribeck, free_speed: float, kappa: float, guess: float) -> float:
    """Solve ``x + kappa F(x) = free_speed`` for the speed ``x > 0`` by Newton's method inside a bracket.

    Needs ``free_speed > kappa Fs``, so that a root exists. ``guess`` is the speed before the step, rad/s.
    """
    viscous_part = 1.0 + kappa * friction.viscous
    low = (free_speed - kappa * friction.stiction) / viscous_part
    high = (free_speed - kappa * friction.coulomb) / viscous_part
    speed = min(max(guess, low), high)
    for _ in range(MAXIMUM_ITERATIONS):
        torque, torque_slope = sliding_friction_and_slope(friction, speed)
        residual = speed + kappa * torque - free_speed
        if residual > 0.0:
            high = speed
        else:
            low = speed
        slope = 1.0 + kappa * torque_slope
        candidate = speed - residual / slope if slope > 0.0 else low
        if slope > 0.0 and abs(candidate - speed) <= RELATIVE_TOLERANCE * free_speed:
            return min(max(candidate, low), high)
        if candidate <= low or candidate >= high:
            candidate = 0.5 * (low + high)
        speed = candidate
    return speed


@register_jitable
def velocity_under_friction(
    forward: Stribeck, backward: Stribeck, free_velocity: float, kappa: float, guess: float
) -> float:
    """Solve ``w + kappa F(w) = free_velocity`` for the velocity ``w``, rad/s, with ``F`` set-valued at rest.

    ``kappa`` is what a unit of static friction takes off the velocity, rad/s per N m; ``guess`` is a speed near the
    solution, rad/s. A joint at rest has a velocity of exactly zero.
    """
    if -kappa * backward.stiction <= free_velocity <= kappa * forward.stiction:
        return 0.0
    if free_velocity < 0.0:
        return -sliding_speed(backward, -free_velocity, kappa, guess)
    return sliding_speed(forward, free_velocity, kappa, guess)


@register_jitable
def step_joint(joint: JointParameters, state: JointState, torque: float, period: float) -> JointState:
    """Advance a joint by one solver period under constant torque.

    Parameters
    ----------
    joint : JointParameters
        The joint.
    state : JointState
        State at the start of the step.
    torque : float
        Torque ``u``, N m, constant over the step.
    period : float
        Solver period ``h``, s.

    Returns
    -------
    JointState
        State at the end of the step. A joint at rest has a velocity of exactly zero.
    """
    lag = joint.friction_lag
    denominator = lag + period
    kappa = period * period / (joint.inertia * denominator)
    carried = lag * state.friction_torque / denominator
    free_velocity = state.velocity + period / joint.inertia * (torque - joint.offset - carried)
    velocity = velocity_under_friction(joint.friction, joint.backward, free_velocity, kappa, abs(state.velocity))
    static_friction = (free_velocity - velocity) / kappa
    friction_torque = carried + period * static_friction / denominator
    return JointState(velocity, friction_torque, state.position + period * velocity)


@register_jitable
def scaled_joint(joint: JointParameters, factor: float) -> JointParameters:
    """Return the joint with the friction of both directions times a dimensionless factor; the offset stays."""
    return JointParameters(
        joint.inertia, scaled(joint.friction, factor), scaled(joint.backward, factor), joint.offset, joint.friction_lag
    )


@register_jitable
def changed_joint(joint: JointParameters, change: JointChange) -> JointParameters:
    """Return the joint with a change of its parameters."""
    return JointParameters(
        joint.inertia * change.inertia,
        changed_curve(joint.friction, change),
        changed_curve(joint.backward, change),
        joint.offset + change.load,
        joint.friction_lag * change.lag,
    )


@register_jitable
def sensed_velocity(state: JointState) -> float:
    """Return the velocity at the motor, rad/s: a rigid joint has one velocity."""
    return state.velocity


def initial_joint(joint: JointParameters, velocity: float) -> JointState:
    """Return the state of a joint that has moved at a velocity (rad/s) for long; its position is zero."""
    return JointState(velocity, friction_at(joint.friction, joint.backward, velocity), 0.0)


def friction_at(forward: Stribeck, backward: Stribeck, velocity: float) -> float:
    """Return the static friction torque at a velocity (rad/s), N m; at rest the middle of what is possible, zero."""
    if velocity == 0.0:
        return 0.0
    return math.copysign(sliding_friction(forward if velocity > 0.0 else backward, abs(velocity)), velocity)
