"""What may change of a joint at a given time, as factors on its original parameters and a load."""

from typing import Any, NamedTuple, TypeVar

from plant.friction import Stribeck, scaled

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
