"""The joint with lagged Stribeck friction as a user meets it, the fields that every kind of joint has, and its weight.

The torque of a weight that hangs on a rotary joint is ``amplitude sin(q + phase)``, against the motor's. It acts over a
solver step as it is at the position before the step: of first order in the period, like the steps themselves. Of an
elastic joint it acts at the motor, as the offset does.
"""

import math
from collections.abc import Iterable
from typing import Any, Literal, NamedTuple, Self

from pydantic import model_validator

from plant.fields import Finite, NonNegative, Positive, Table, check_numbers, check_period
from plant.friction import Stribeck, sliding_friction, steepest_fall
from plant.registry import CHECK_PERIOD, READY_JOINT, STEP_READY, register
from plant.step import (
    JointParameters,
    JointState,
    ReadyJoint,
    changed_joint,
    initial_joint,
    ready_joint,
    step_joint,
    step_ready_joint,
)


class Gravity(NamedTuple):
    """The torque of a weight."""

    amplitude: float  # largest torque, N m; zero without a weight
    phase: float  # angle from the hanging weight to the position zero, rad


def gravity_torque(gravity: Gravity, position: float) -> float:
    """Return the torque (N m) against the motor's at a position (rad)."""
    return gravity.amplitude * math.sin(position + gravity.phase)


LARGEST_FALL = 0.5
"""Largest falling slope of friction in a step whose root is bracketed, over ``J/h``; at one it is not unique.

It is that of bristles, elements and presliding curves.
"""

FALLING = "the falling Stribeck curve could leave the implicit step more than one solution"

LARGEST_BREAKAWAY_JUMP = 0.01
"""Largest velocity jump at breakaway, relative to Vs, that is accepted for a shape factor below one."""


class FrictionFields(Table):
    """What every kind of joint has: an inertia, a friction curve per direction and a constant torque.

    Raises
    ------
    pydantic.ValidationError
        A field is missing, unknown, of the wrong type or out of range, or the solver period is too long.
    """

    kind: str  # kind of joint
    inertia: Positive  # inertia ``J``, kg m^2, positive
    coulomb: NonNegative  # coulomb friction ``Fc``, N m, zero or more
    stiction: NonNegative  # stiction ``Fs``, N m, at least ``coulomb``
    viscous: NonNegative  # viscous coefficient ``sigma``, N m s/rad, zero or more
    stribeck_velocity: Positive  # stribeck velocity ``Vs``, rad/s, positive
    # stribeck shape factor ``delta``, positive. The paper allows negative ones; they turn the curve over, so that
    # ``F(0+) = Fc``, and are refused
    stribeck_shape: Positive = 1.0
    # the same for backward motion; as forward by default
    coulomb_backward: NonNegative | None = None
    stiction_backward: NonNegative | None = None
    viscous_backward: NonNegative | None = None
    offset: Finite = 0.0  # constant torque against the motor's, N m, of either sign: ``J dw/dt = u - f - offset``
    # kind of motion. Of a linear axis read m, m/s, N and kg for rad, rad/s, N m and kg m^2 everywhere
    axis: Literal["rotary", "linear"] = "rotary"
    # amplitude of the torque of a weight, N m, against the motor's: ``gravity sin(q + gravity_phase)`` with the
    # position ``q``, which is zero at the start. Only of a rotary axis
    gravity: NonNegative = 0.0
    gravity_phase: Finite = 0.0  # angle from the hanging weight to the position zero, rad
    # turns of the motor in a turn of the joint. It changes nothing in the simulation; a controller may be given it
    gear_ratio: Positive | None = None
    # solver period ``h``, s, positive, and short enough for the implicit step to have one solution
    solver_period: Positive = 0.001

    @model_validator(mode="after")
    def _check_joint(self) -> Self:
        if self.axis == "linear" and self.gravity > 0.0:
            raise ValueError(
                f"gravity = {self.gravity:g} is not allowed for axis = 'linear': only a rotary axis has a torque that "
                "varies with its position as a sine; the weight on a linear axis is its offset"
            )
        for curve, ending in self.curves:
            if curve.stiction < curve.coulomb:
                raise ValueError(
                    f"stiction{ending} = {curve.stiction:g} is less than coulomb{ending} = {curve.coulomb:g}; "
                    f"stiction{ending} must be at least coulomb{ending}"
                )
        self.check_kind()
        CHECK_PERIOD[type(self.parameters)](self.parameters, self.solver_period)
        return self

    def check_kind(self) -> None:
        """Raise ``ValueError`` where fields of a kind do not go together."""

    @property
    def parameters(self) -> Any:
        """The parameters as the step of the kind takes them."""
        raise NotImplementedError

    @property
    def curves(self) -> tuple[tuple[Stribeck, str], ...]:
        """The static friction map of each direction, and the ending of its fields' names."""
        return (self.friction, ""), (self.friction_backward, "_backward")

    @property
    def weight(self) -> Gravity:
        """The weight as the loop takes it."""
        return Gravity(self.gravity, self.gravity_phase)

    @property
    def friction(self) -> Stribeck:
        """The static friction map of forward motion."""
        return Stribeck(self.coulomb, self.stiction, self.viscous, self.stribeck_velocity, self.stribeck_shape)

    @property
    def friction_backward(self) -> Stribeck:
        """The static friction map of backward motion."""
        given = {"coulomb": self.coulomb_backward, "stiction": self.stiction_backward, "viscous": self.viscous_backward}
        return self.friction._replace(**{name: value for name, value in given.items() if value is not None})


class JointModel(FrictionFields):
    """Parameters of a simulated rigid joint with lagged Stribeck friction, checked.

    Further fields are those of :class:`FrictionFields`.
    """

    kind: Literal["stribeck"] = "stribeck"  # kind of joint
    friction_lag: NonNegative = 0.0  # friction lag ``tau``, s, zero or more

    @property
    def parameters(self) -> JointParameters:
        """The parameters as the step takes them."""
        return JointParameters(self.inertia, self.friction, self.friction_backward, self.offset, self.friction_lag)


def check_unique_step(joint: JointParameters, period: float) -> None:
    """Refuse a solver period for which the implicit step has more than one solution.

    With ``kappa = h^2/(J (tau + h))`` the step is unique while ``kappa max(-F') < 1``. For a shape factor below one the
    slope at rest is infinite, and rest is always one of several solutions just below breakaway; rest is chosen there,
    and the velocity jumps at breakaway to a value that vanishes with the period. That jump is bounded.
    """
    kappa = period * period / (joint.inertia * (joint.friction_lag + period))
    limit = min(largest_kappa(joint.friction), largest_kappa(joint.backward))
    if not kappa < limit:
        longest = longest_with_lag(limit * joint.inertia, joint.friction_lag)
        refuse_period(period, longest, "the falling Stribeck curve leaves the implicit step more than one solution")


def longest_with_lag(longest: float, lag: float) -> float:
    """Return the ``h`` with ``h^2/(tau + h)`` of the longest solver period (s) without a lag ``tau`` (s)."""
    return longest if math.isinf(longest) else 0.5 * (longest + math.sqrt(longest * longest + 4.0 * longest * lag))


def largest_kappa(friction: Stribeck) -> float:
    """Return the ``kappa`` at which the step stops being unique (or jumps too far), rad/s per N m."""
    fall = steepest_fall(friction)
    if not math.isinf(fall):
        return 1.0 / fall if fall > 0.0 else math.inf
    jump = LARGEST_BREAKAWAY_JUMP * friction.stribeck_velocity
    drop = friction.stiction - sliding_friction(friction, jump)
    return jump / drop if drop > 0.0 else math.inf


def check_coulomb(joint: FrictionFields) -> None:
    """Refuse a curve without Coulomb friction, which elements or bristles that slide at no torque cannot carry."""
    for curve, ending in joint.curves:
        if curve.coulomb == 0.0:
            raise ValueError(
                f"coulomb{ending} = 0 is not allowed for a joint of the kind {joint.kind!r}: it must be positive"
            )


def check_gentle_at_rest(joint: FrictionFields) -> None:
    """Refuse a Stribeck curve that falls infinitely steeply at rest, where a joint can only creep."""
    if any(math.isinf(steepest_fall(curve)) for curve, _ in joint.curves):
        raise ValueError(
            f"stribeck_shape = {joint.stribeck_shape:g} is not allowed for a joint of the kind {joint.kind!r}: it must "
            "be at least 1, or stiction equal to coulomb, since the curve falls infinitely steeply at rest"
        )


def longest_gentle_period(inertia: float, falls: Iterable[float]) -> float:
    """Return the solver period, s, at which falling friction (N m s/rad) takes half of the implicit step's slope."""
    fall = max(falls)
    return LARGEST_FALL * inertia / fall if fall > 0.0 else math.inf


def refuse_period(period: float, longest: float, reason: str) -> None:
    """Raise ``ValueError`` for a solver period beyond the longest one (s), with the reason why it is that."""
    if period > longest:
        raise ValueError(
            f"solver_period = {period:g} s is too long for this joint: beyond {longest:.6g} s {reason}; use a shorter "
            "solver_period"
        )


def whole_multiple(duration: float, period: float) -> int | None:
    """Return how many periods a duration holds, or None where that is not a whole number of one or more.

    Raises
    ------
    ValueError
        The period is not positive and finite.
    TypeError
        A value is no number.
    """
    check_numbers(duration=duration)
    check_period("period", period)
    ratio = duration / period
    if not math.isfinite(ratio) or round(ratio) < 1 or abs(ratio - round(ratio)) > 1e-6 + 1e-12 * ratio:
        return None
    return round(ratio)


register(JointParameters, JointState, step_joint, initial_joint, check_unique_step, changed_joint)
READY_JOINT[JointParameters], STEP_READY[ReadyJoint] = ready_joint, step_ready_joint
