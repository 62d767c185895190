"""One implicit time step of a joint with set-valued friction and friction lag.

The joint is ``J dw/dt = u - f - offset`` (Fig. 1 of the paper, and a constant torque) with ``tau df/dt + f = F(w)``,
equation (1). Each direction has a friction map of its own. All is discretised by the implicit Euler method, because
only an implicit step can keep a joint exactly at rest: with ``F(0) = [-Fs, Fs]`` the friction torque at rest is an
unknown of the step, not a value of a function.

In sliding motion the step is of first order in the solver period. So it is for ``tau = 0`` through stops and
breakaways, where it is the classic Coulomb time step. With a lag the joint bounces about zero velocity before it rests,
and a bounce that the step cuts short shifts the next one: there single velocities converge with about the square root
of the period (some 0.01 rad/s at 1 ms), means over a motion with first order still.
"""

import math
from typing import NamedTuple

from plant.friction import AnyParameters, JointChange, Stribeck, changed_friction, sliding_friction
from plant.sliding import Direction, direction_of, speed_in_direction


class JointParameters(NamedTuple):
    """What the step needs to know of a joint."""

    inertia: float  # inertia ``J``, kg m^2
    friction: Stribeck  # static friction map ``F`` of forward motion
    backward: Stribeck  # static friction map of backward motion
    offset: float  # constant torque against the motor's, N m, of either sign
    friction_lag: float  # friction lag ``tau``, s, zero or more


class JointState(NamedTuple):
    """State of a joint."""

    velocity: float  # velocity ``w``, rad/s
    friction_torque: float  # friction torque ``f``, N m, without the offset
    position: float  # position, rad


class ReadyJoint(NamedTuple):
    """A joint with the constants of its step for one solver period."""

    forward: Direction  # constants of the step in each direction of motion
    backward: Direction
    offset: float  # constant torque against the motor's, N m
    gain: float  # ``h/J``, rad/s per N m
    kept: float  # shares ``tau/(tau + h)`` of the last friction torque and ``h/(tau + h)`` of the static one in the new
    taken: float
    per_kappa: float  # ``J (tau + h)/h^2``, N m per rad/s


def ready_joint(joint: JointParameters, period: float) -> ReadyJoint:
    """Return a joint ready to be stepped with a solver period in s."""
    denominator = joint.friction_lag + period
    kappa = period * period / (joint.inertia * denominator)
    return ReadyJoint(
        direction_of(joint.friction, kappa),
        direction_of(joint.backward, kappa),
        joint.offset,
        period / joint.inertia,
        joint.friction_lag / denominator,
        period / denominator,
        1.0 / kappa,
    )


def step_ready_joint(joint: ReadyJoint, state: JointState, torque: float, period: float) -> JointState:
    """Advance a joint by the solver period (s) that it was made ready for; see :func:`step_joint`."""
    carried = joint.kept * state.friction_torque
    free_velocity = state.velocity + joint.gain * (torque - joint.offset - carried)
    if -joint.backward.breakaway <= free_velocity <= joint.forward.breakaway:
        velocity = 0.0
    elif free_velocity < 0.0:
        velocity = -speed_in_direction(joint.backward, -free_velocity, -state.friction_torque)
    else:
        velocity = speed_in_direction(joint.forward, free_velocity, state.friction_torque)
    static_friction = (free_velocity - velocity) * joint.per_kappa
    friction_torque = carried + joint.taken * static_friction
    return JointState(velocity, friction_torque, state.position + period * velocity)


def step_joint(joint: JointParameters, state: JointState, torque: float, period: float) -> JointState:
    """Advance a joint by a solver period (s) under constant torque (N m)."""
    return step_ready_joint(ready_joint(joint, period), state, torque, period)


def changed_joint(joint: AnyParameters, change: JointChange) -> AnyParameters:
    """Return a rigid joint of any kind with a friction lag with a change of its parameters."""
    changed = changed_friction(joint, change)
    return changed._replace(  # type: ignore[no-any-return]
        inertia=joint.inertia * change.inertia, friction_lag=joint.friction_lag * change.lag
    )


def initial_joint(joint: JointParameters, velocity: float) -> JointState:
    """Return the state of a joint that has moved at a velocity (rad/s) for long; its position is zero."""
    return JointState(velocity, friction_at(joint.friction, joint.backward, velocity), 0.0)


def friction_at(forward: Stribeck, backward: Stribeck, velocity: float) -> float:
    """Return the static friction torque at a velocity (rad/s), N m; at rest the middle of what is possible, zero."""
    if velocity == 0.0:
        return 0.0
    return math.copysign(sliding_friction(forward if velocity > 0.0 else backward, abs(velocity)), velocity)
