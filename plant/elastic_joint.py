"""The elastic joint as a user meets it."""

import math
from typing import Annotated, Literal, Self

from pydantic import Field, model_validator

from plant.backlash import BacklashParameters
from plant.elastic import ElasticParameters
from plant.fields import NonNegative, Positive
from plant.joint import FrictionFields, check_unique_step
from plant.step import JointParameters

Share = Annotated[float, Field(gt=0.0, lt=1.0, allow_inf_nan=False, strict=True)]

LARGEST_ANGLE = 0.349
"""Largest ``omega h`` of the resonance: the trapezoidal rule then lowers its frequency by 1 %."""


class ElasticJoint(FrictionFields):
    """Parameters of a simulated joint with motor and link on a spring, checked.

    Parameters
    ----------
    kind : "elastic"
        Kind of joint.
    inertia : float
        Inertia of motor and link together, kg m^2: what slow motion needs, as for the other kinds.
    link_share : float
        Share of the inertia that is beyond the spring, between 0 and 1. The antiresonance is at
        ``sqrt(k/(share J))``, the resonance at ``sqrt(k/(share (1 - share) J))`` rad/s.
    link_stiffness : float
        Stiffness ``k`` of the spring between motor and link, N m/rad, positive.
    link_damping : float, optional
        Damping ``c`` of the spring, N m s/rad, zero or more.
    friction_lag : float, optional
        Friction lag ``tau`` of the motor's friction, s, zero or more.
    solver_period : float, optional
        Solver period ``h``, s, positive, short enough for the resonance and for the implicit step to have one solution.
    **fields
        Those of :class:`FrictionFields`; friction and offset act at the motor.

    Raises
    ------
    pydantic.ValidationError
        A field is missing, unknown, of the wrong type or out of range, or the solver period is too long.
    """

    kind: Literal["elastic"] = "elastic"
    link_share: Share
    link_stiffness: Positive
    link_damping: NonNegative = 0.0
    friction_lag: NonNegative = 0.0
    solver_period: Positive = 0.001

    @model_validator(mode="after")
    def _check_period(self) -> Self:
        check_elastic_period(self.parameters, self.solver_period)
        return self

    @property
    def parameters(self) -> ElasticParameters:
        """The parameters as the step takes them."""
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


def check_elastic_period(joint: ElasticParameters | BacklashParameters, period: float) -> None:
    """Refuse a solver period that misplaces the resonance, or for which the implicit step has more than one solution.

    The step is the rigid joint's with the motor's inertia and part of the link's, so a period that suits the motor
    alone suits it.

    Raises
    ------
    ValueError
        The period is too long; the message names the longest one allowed.
    """
    stiffness = joint.link_stiffness
    resonance = math.sqrt(stiffness / joint.motor_inertia + stiffness / joint.link_inertia)
    if resonance * period > LARGEST_ANGLE:
        raise ValueError(
            f"solver_period = {period:g} s is too long for this joint: beyond {LARGEST_ANGLE / resonance:.6g} s its "
            f"resonance of {resonance / (2.0 * math.pi):.4g} Hz is misplaced by more than 1 %; use a shorter "
            "solver_period"
        )
    check_unique_step(
        JointParameters(joint.motor_inertia, joint.friction, joint.backward, joint.offset, joint.friction_lag), period
    )
