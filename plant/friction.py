"""The static friction map of the paper, equation (3): Coulomb, Stribeck and viscous friction; and how joints change."""

import math
from typing import Any, NamedTuple, TypeVar


class Stribeck(NamedTuple):
    """Parameters of the static friction map ``F(w)``, equation (3)."""

    coulomb: float  # coulomb friction ``Fc``, N m
    stiction: float  # stiction (adhesion, breakaway) friction ``Fs``, N m
    viscous: float  # viscous coefficient ``sigma``, N m s/rad
    stribeck_velocity: float  # stribeck velocity ``Vs``, rad/s
    stribeck_shape: float  # stribeck shape factor ``delta``, dimensionless, positive


def stribeck_decay(speed: float, stribeck_velocity: float, stribeck_shape: float) -> float:
    """Evaluate ``exp(-(|w|/Vs)^delta)`` for a speed ``|w| >= 0`` in rad/s."""
    ratio = speed / stribeck_velocity
    if stribeck_shape == 1.0:
        return math.exp(-ratio)
    if stribeck_shape == 2.0:
        return math.exp(-ratio * ratio)
    if ratio > 1.0 and stribeck_shape * math.log(ratio) > 7.0:
        return 0.0  # exp(-exp(7)) underflows, and the power below could overflow
    return math.exp(-(ratio**stribeck_shape))


def sliding_friction(friction: Stribeck, speed: float) -> float:
    """Friction magnitude ``F(|w|)`` in N m of a joint that slides with speed ``|w| >= 0``.

    The limit from the sliding side: at zero speed it is ``Fs``, whereas the map itself is the whole
    interval ``[-Fs, Fs]`` there.
    """
    decay = stribeck_decay(speed, friction.stribeck_velocity, friction.stribeck_shape)
    return friction.coulomb + (friction.stiction - friction.coulomb) * decay + friction.viscous * speed  # (3)


def sliding_friction_and_slope(friction: Stribeck, speed: float) -> tuple[float, float]:
    """Return friction magnitude (N m) and slope ``dF/d|w|`` (N m s/rad) of a joint that slides, at ``|w| > 0``."""
    ratio = speed / friction.stribeck_velocity
    decay = stribeck_decay(speed, friction.stribeck_velocity, friction.stribeck_shape)
    excess = friction.stiction - friction.coulomb
    torque = friction.coulomb + excess * decay + friction.viscous * speed  # (3)
    if decay == 0.0:
        return torque, friction.viscous  # the power below could overflow
    if friction.stribeck_shape == 1.0:
        power = 1.0
    elif friction.stribeck_shape == 2.0:
        power = ratio
    else:
        power = ratio ** (friction.stribeck_shape - 1.0)
    return torque, friction.viscous - excess * friction.stribeck_shape * power * decay / friction.stribeck_velocity


def steepest_fall(friction: Stribeck) -> float:
    """Steepest falling slope ``max(-dF/d|w|)`` in N m s/rad, zero where friction never falls.

    The slope of ``exp(-x^delta)`` is steepest at ``x^delta = (delta - 1)/delta`` for ``delta > 1``, at rest for
    ``delta = 1``; for ``delta < 1`` it is infinite at rest.
    """
    excess = friction.stiction - friction.coulomb
    if excess == 0.0:
        return 0.0
    shape = friction.stribeck_shape
    if shape < 1.0:
        return math.inf
    ratio = ((shape - 1.0) / shape) ** (1.0 / shape) if shape > 1.0 else 0.0
    return max(0.0, -sliding_friction_and_slope(friction, ratio * friction.stribeck_velocity)[1])


def scaled(friction: Stribeck, factor: float) -> Stribeck:
    """Return the friction with ``Fc``, ``Fs`` and ``sigma`` times a dimensionless factor."""
    coulomb, stiction, viscous = friction.coulomb * factor, friction.stiction * factor, friction.viscous * factor
    return friction._replace(coulomb=coulomb, stiction=stiction, viscous=viscous)


def yield_torque(friction: Stribeck, speed: float) -> tuple[float, float]:
    """Return ``g(|w|)``, the map without its viscous part, and ``|w| dg/d|w|``, both in N m, at a speed ``|w| >= 0``.

    The product is finite at rest, where for a shape factor below one the slope is not.
    """
    ratio = speed / friction.stribeck_velocity
    if friction.stribeck_shape == 1.0:
        power = ratio
    elif friction.stribeck_shape == 2.0:
        power = ratio * ratio
    elif ratio > 1.0 and friction.stribeck_shape * math.log(ratio) > 7.0:
        return friction.coulomb, 0.0  # exp(-exp(7)) underflows, and the power below could overflow
    else:
        power = ratio**friction.stribeck_shape
    excess = (friction.stiction - friction.coulomb) * math.exp(-power)
    return friction.coulomb + excess, -excess * friction.stribeck_shape * power


AnyParameters = TypeVar("AnyParameters", bound=Any)
"""Parameters of a joint of any kind, as its step takes them."""


class JointChange(NamedTuple):
    """How a joint differs from its original parameters."""

    dry: float  # factor on ``Fc`` and ``Fs`` of both directions
    viscous: float  # factor on ``sigma`` of both directions
    inertia: float  # factor on the inertia, of an elastic joint on that of the link
    lag: float  # factor on the friction lag, for joints that have one
    load: float  # constant torque against the motor's beside the joint's offset, N m, of either sign


UNCHANGED = JointChange(1.0, 1.0, 1.0, 1.0, 0.0)


def changed_curve(friction: Stribeck, change: JointChange) -> Stribeck:
    """Return a static friction map with its dry and its viscous part changed."""
    coulomb, stiction = friction.coulomb * change.dry, friction.stiction * change.dry
    return friction._replace(coulomb=coulomb, stiction=stiction, viscous=friction.viscous * change.viscous)


def scaled_friction(joint: AnyParameters, factor: float) -> AnyParameters:
    """Return a joint of any kind with the static friction of both directions times a dimensionless factor.

    All else stays, also the offset.
    """
    return joint._replace(  # type: ignore[no-any-return]
        friction=scaled(joint.friction, factor), backward=scaled(joint.backward, factor)
    )


def changed_friction(joint: AnyParameters, change: JointChange) -> AnyParameters:
    """Return a joint of any kind with static friction and offset changed; its inertia and what else it has stay."""
    return joint._replace(  # type: ignore[no-any-return]
        friction=changed_curve(joint.friction, change),
        backward=changed_curve(joint.backward, change),
        offset=joint.offset + change.load,
    )
