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

import math
from typing import Annotated, Any, Literal, NamedTuple

from pydantic import Field

from plant.fields import NonNegative, Positive
from plant.friction import AnyParameters, JointChange, Stribeck, changed_friction
from plant.joint import FrictionFields, check_unique_step, refuse_period
from plant.registry import register
from plant.sliding import velocity_under_friction
from plant.step import JointParameters, friction_at


class ElasticParameters(NamedTuple):
    """What the step needs to know of an elastic joint."""

    motor_inertia: float  # inertia on either side of the spring, kg m^2, both on the joint's side of the gear
    link_inertia: float
    friction: Stribeck  # static friction map of forward and of backward motion of the motor
    backward: Stribeck
    offset: float  # constant torque against the motor's, N m, of either sign
    friction_lag: float  # friction lag ``tau``, s, zero or more
    link_stiffness: float  # stiffness ``k`` of the spring, N m/rad
    link_damping: float  # damping ``c`` of the spring, N m s/rad


class ElasticState(NamedTuple):
    """State of an elastic joint."""

    velocity: float  # velocity of the link, rad/s
    friction_torque: float  # friction torque ``f`` at the motor, N m, without the offset
    position: float  # position of the motor, rad
    motor_velocity: float  # velocity of the motor, rad/s
    twist: float  # position of the motor less that of the link, rad


def motor_and_link(
    joint: AnyParameters, state: Any, drive: float, period: float, level: float, gain: float
) -> tuple[float, float, float]:
    """Solve the step for the velocities of motor and link, rad/s, and the static friction torque at the motor, N m.

    ``drive`` is the torque at the motor less the offset and the friction that its lag carries over, N m; the mean
    torque of the spring over the step is ``level + gain (D + D+)``, N m.
    """
    motor, link = state.motor_velocity, state.velocity
    fraction = 1.0 / (1.0 + period * gain / joint.link_inertia)
    coupling = fraction * gain  # with the link's equation the mean torque is held + coupling wm+
    held = fraction * (level + gain * (motor - link - link))
    mobility = period / joint.motor_inertia
    divisor = 1.0 + mobility * coupling
    free_velocity = (motor + mobility * (drive - held)) / divisor
    kappa = mobility * period / ((joint.friction_lag + period) * divisor)
    next_motor = velocity_under_friction(joint.friction, joint.backward, free_velocity, kappa, abs(motor))
    static_friction = (free_velocity - next_motor) / kappa
    return next_motor, link + period / joint.link_inertia * (held + coupling * next_motor), static_friction


def step_elastic(joint: ElasticParameters, state: ElasticState, torque: float, period: float) -> ElasticState:
    """Advance an elastic joint by a solver period (s) under constant torque (N m)."""
    motor, link, lag_divisor = state.motor_velocity, state.velocity, joint.friction_lag + period
    carried = joint.friction_lag * state.friction_torque / lag_divisor
    gain = 0.25 * period * joint.link_stiffness + 0.5 * joint.link_damping
    next_motor, next_link, static_friction = motor_and_link(
        joint, state, torque - joint.offset - carried, period, joint.link_stiffness * state.twist, gain
    )
    half = 0.5 * period
    return ElasticState(
        next_link,
        carried + period * static_friction / lag_divisor,
        state.position + half * (motor + next_motor),
        next_motor,
        state.twist + half * (motor - link + next_motor - next_link),
    )


def changed_elastic(joint: AnyParameters, change: JointChange) -> AnyParameters:
    """Return a joint of motor and link with a change of its parameters; a payload is the link's, the motor's stays."""
    changed = changed_friction(joint, change)
    return changed._replace(  # type: ignore[no-any-return]
        link_inertia=joint.link_inertia * change.inertia, friction_lag=joint.friction_lag * change.lag
    )


def sensed_elastic(state: Any) -> float:
    """Return the velocity at the motor, where the sensor of a joint of motor and link sits, rad/s."""
    return state.motor_velocity  # type: ignore[no-any-return]


def initial_elastic(joint: ElasticParameters, velocity: float) -> ElasticState:
    """Return the state of a joint that has moved at a velocity (rad/s) for long: untwisted, its position zero."""
    return ElasticState(velocity, friction_at(joint.friction, joint.backward, velocity), 0.0, velocity, 0.0)


OpenFraction = Annotated[float, Field(gt=0.0, lt=1.0, allow_inf_nan=False, strict=True)]

LARGEST_ANGLE = 0.349
"""Largest ``omega h`` of the resonance: the trapezoidal rule then lowers its frequency by 1 %."""


class GearFields(FrictionFields):
    """What both kinds of joints with motor and link have, beside the fields of every joint."""

    inertia: Positive  # inertia of motor and link together, kg m^2: what slow motion needs, as for the other kinds
    # fraction of the inertia that is beyond the spring, between 0 and 1. The antiresonance is at ``sqrt(k/(a J))``, the
    # resonance at ``sqrt(k/(a (1 - a) J))`` rad/s
    link_share: OpenFraction
    link_stiffness: Positive  # stiffness ``k`` of the spring between motor and link, N m/rad, positive
    link_damping: NonNegative = 0.0  # damping ``c`` of the spring, N m s/rad, zero or more
    friction_lag: NonNegative = 0.0  # friction lag ``tau`` of the motor's friction, s, zero or more

    @property
    def motor_and_link(self) -> ElasticParameters:
        """The parameters of motor, spring and link as the step takes them."""
        link_inertia = self.link_share * self.inertia
        return ElasticParameters(
            motor_inertia=self.inertia - link_inertia,
            link_inertia=link_inertia,
            friction=self.friction,
            backward=self.friction_backward,
            offset=self.offset,
            friction_lag=self.friction_lag,
            link_stiffness=self.link_stiffness,
            link_damping=self.link_damping,
        )


class ElasticJoint(GearFields):
    """Parameters of a simulated joint with motor and link on a spring, checked.

    Further fields are those of ``GearFields`` and of :class:`FrictionFields`; friction and offset act at the motor.
    """

    kind: Literal["elastic"] = "elastic"  # kind of joint

    @property
    def parameters(self) -> ElasticParameters:
        """The parameters as the step takes them."""
        return self.motor_and_link


def check_elastic_period(joint: Any, period: float) -> None:
    """Refuse a solver period that misplaces the resonance, or for which the implicit step has more than one solution.

    The step is the rigid joint's with the motor's inertia and part of the link's, so a period that suits the motor
    alone suits it.
    """
    stiffness = joint.link_stiffness
    resonance = math.sqrt(stiffness / joint.motor_inertia + stiffness / joint.link_inertia)
    if resonance * period > LARGEST_ANGLE:
        frequency = resonance / (2.0 * math.pi)
        reason = f"its resonance of {frequency:.4g} Hz is misplaced by more than 1 %"
        refuse_period(period, LARGEST_ANGLE / resonance, reason)
    check_unique_step(
        JointParameters(joint.motor_inertia, joint.friction, joint.backward, joint.offset, joint.friction_lag), period
    )


register(
    ElasticParameters,
    ElasticState,
    step_elastic,
    initial_elastic,
    check_elastic_period,
    changed_elastic,
    sensed=sensed_elastic,
)
