"""Joints drawn at random for properties of their steps, and the one that all of them share."""

from hypothesis import strategies as st
from pydantic import ValidationError

FRICTION = {"coulomb": 60.0, "stiction": 90.0, "viscous": 80.0, "stribeck_velocity": 0.05}
"""The joint that all tests of steps share, beside its inertia of 20 kg m^2."""

VELOCITY = st.just(0.0) | st.floats(-2.0, 2.0)
TORQUE = st.floats(-300.0, 300.0)


@st.composite
def friction_fields(draw, least=0.0, shapes=(1.0, 1.5, 2.0)):
    """Fields that every kind of joint has; ``least`` is the smallest Coulomb friction."""
    coulomb, backward = draw(st.floats(least, 100.0)), draw(st.none() | st.floats(least, 100.0))
    return {
        "inertia": draw(st.floats(0.5, 100.0)),
        "coulomb": coulomb,
        "coulomb_backward": backward,
        "stiction": max(coulomb, backward or 0.0) + draw(st.just(0.0) | st.floats(0.0, 100.0)),
        "viscous": draw(st.floats(0.0, 100.0)),
        "stribeck_velocity": draw(st.floats(0.01, 0.5)),
        "stribeck_shape": draw(st.sampled_from(shapes)),
        "offset": draw(st.just(0.0) | st.floats(-50.0, 50.0)),
    }


def accepted(model, fields, period=1e-3):
    """A joint of some fields, with a solver period short enough for it."""
    while True:
        try:
            return model(**fields, solver_period=period)
        except ValidationError:
            period *= 0.5


def mirrored(step, joint, state, torque, period):
    """The state after a step of the joint seen from the other side, as seen from this one: the step is odd."""
    turned = joint._replace(friction=joint.backward, backward=joint.friction, offset=-joint.offset)
    after = step(turned, type(state)(*(-value for value in state)), -torque, period)
    return tuple(-value for value in after)
