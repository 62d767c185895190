"""A joint with friction as a user meets it: validated parameters, and a thin class that holds a state."""

import math
from typing import Annotated, Self

from pydantic import BaseModel, ConfigDict, Field, model_validator

from plant.friction import Stribeck, sliding_friction, steepest_fall
from plant.step import JointParameters, JointState, step_joint

Positive = Annotated[float, Field(gt=0.0, allow_inf_nan=False, strict=True)]
NonNegative = Annotated[float, Field(ge=0.0, allow_inf_nan=False, strict=True)]

LARGEST_BREAKAWAY_JUMP = 0.01
"""Largest velocity jump at breakaway, relative to Vs, that is accepted for a shape factor below one."""


class JointModel(BaseModel):
    """Parameters of a simulated joint, checked.

    Parameters
    ----------
    inertia : float
        Inertia ``J``, kg m^2, positive.
    coulomb : float
        Coulomb friction ``Fc``, N m, zero or more.
    stiction : float
        Stiction ``Fs``, N m, at least ``coulomb``.
    viscous : float
        Viscous coefficient ``sigma``, N m s/rad, zero or more.
    stribeck_velocity : float
        Stribeck velocity ``Vs``, rad/s, positive.
    stribeck_shape : float
        Stribeck shape factor ``delta``, positive. The paper allows negative ones; they turn the curve over, so that
        ``F(0+) = Fc``, and are refused.
    friction_lag : float
        Friction lag ``tau``, s, zero or more.
    solver_period : float
        Solver period ``h``, s, positive, and short enough for the implicit step to have one solution.

    Raises
    ------
    pydantic.ValidationError
        A field is missing, unknown, of the wrong type or out of range, or the implicit step would not be unique.
    """

    model_config = ConfigDict(frozen=True, extra="forbid")

    inertia: Positive
    coulomb: NonNegative
    stiction: NonNegative
    viscous: NonNegative
    stribeck_velocity: Positive
    stribeck_shape: Positive = 1.0
    friction_lag: NonNegative = 0.0
    solver_period: Positive = 0.001

    @model_validator(mode="after")
    def _check_stiction(self) -> Self:
        if self.stiction < self.coulomb:
            raise ValueError(
                f"stiction = {self.stiction:g} N m is less than coulomb = {self.coulomb:g} N m; "
                "stiction must be at least coulomb"
            )
        return self

    @model_validator(mode="after")
    def _check_unique_step(self) -> Self:
        check_unique_step(self.parameters, self.solver_period)
        return self

    @property
    def friction(self) -> Stribeck:
        """The static friction map."""
        return Stribeck(self.coulomb, self.stiction, self.viscous, self.stribeck_velocity, self.stribeck_shape)

    @property
    def parameters(self) -> JointParameters:
        """The parameters as the step takes them."""
        return JointParameters(self.inertia, self.friction, self.friction_lag)


def check_unique_step(joint: JointParameters, period: float) -> None:
    """Refuse a solver period for which the implicit step has more than one solution.

    With ``kappa = h^2/(J (tau + h))`` the step is unique while ``kappa max(-F') < 1``. For a shape factor below one the
    slope at rest is infinite, and rest is always one of several solutions just below breakaway; rest is chosen there,
    and the velocity jumps at breakaway to a value that vanishes with the period. That jump is bounded.

    Raises
    ------
    ValueError
        The period is too long; the message names the longest one allowed.
    """
    kappa = period * period / (joint.inertia * (joint.friction_lag + period))
    limit = _largest_kappa(joint.friction)
    if kappa < limit:
        return
    mass = limit * joint.inertia
    longest = 0.5 * (mass + math.sqrt(mass * mass + 4.0 * mass * joint.friction_lag))
    raise ValueError(
        f"solver_period = {period:g} s is too long for this joint: beyond {longest:.6g} s the falling Stribeck curve "
        "leaves the implicit step more than one solution; use a shorter solver_period"
    )


def _largest_kappa(friction: Stribeck) -> float:
    """Return the ``kappa`` at which the step stops being unique (or jumps too far), rad/s per N m."""
    fall = steepest_fall(friction)
    if not math.isinf(fall):
        return 1.0 / fall if fall > 0.0 else math.inf
    jump = LARGEST_BREAKAWAY_JUMP * friction.stribeck_velocity
    drop = friction.stiction - sliding_friction(friction, jump)
    return jump / drop if drop > 0.0 else math.inf


class Joint:
    """A joint to step in one's own loop.

    Parameters
    ----------
    model : JointModel
        Parameters of the joint.
    velocity : float, optional
        Velocity at the start, rad/s; the friction torque starts on the static map.

    Examples
    --------
    >>> from plant import Joint, JointModel
    >>> joint = Joint(JointModel(inertia=20.0, coulomb=60.0, stiction=90.0, viscous=80.0, stribeck_velocity=0.05))
    >>> joint.step(80.0, 0.01)  # below the stiction: it rests
    0.0
    """

    def __init__(self, model: JointModel, velocity: float = 0.0) -> None:
        if not math.isfinite(velocity):
            raise ValueError(f"velocity = {velocity} is not allowed: it must be a finite number of rad/s")
        self.model = model
        self._parameters = model.parameters
        self.state = initial_state(self._parameters, float(velocity))

    def step(self, torque: float, duration: float) -> float:
        """Apply a constant torque for a while and return the velocity reached.

        Parameters
        ----------
        torque : float
            Torque, N m.
        duration : float
            Duration, s, a whole number of solver periods.

        Returns
        -------
        float
            Velocity at the end, rad/s.

        Raises
        ------
        ValueError
            The torque is not finite, or the duration is not a whole number of solver periods.
        """
        if not math.isfinite(torque):
            raise ValueError(f"torque = {torque} is not allowed: it must be a finite number of N m")
        steps = whole_multiple(duration, self.model.solver_period)
        if steps is None:
            raise ValueError(
                f"duration = {duration} s is not allowed: it must be a whole number of solver periods of "
                f"{self.model.solver_period:g} s"
            )
        for _ in range(steps):
            self.state = step_joint(self._parameters, self.state, float(torque), self.model.solver_period)
        return self.state.velocity


def initial_state(joint: JointParameters, velocity: float) -> JointState:
    """Return the state of a joint that has moved at a velocity (rad/s) for long."""
    if velocity == 0.0:
        return JointState(0.0, 0.0)
    return JointState(velocity, math.copysign(sliding_friction(joint.friction, abs(velocity)), velocity))


def whole_multiple(duration: float, period: float) -> int | None:
    """Return how many periods a duration holds, or None where that is not a whole number of one or more."""
    ratio = duration / period
    if not math.isfinite(ratio) or round(ratio) < 1 or abs(ratio - round(ratio)) > 1e-6 + 1e-12 * ratio:
        return None
    return round(ratio)
