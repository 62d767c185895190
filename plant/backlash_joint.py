"""The joint with backlash as a user meets it."""

from typing import Literal, Self

from pydantic import model_validator

from plant.backlash import BacklashParameters
from plant.elastic_joint import Share, check_elastic_period
from plant.fields import NonNegative, Positive
from plant.joint import FrictionFields


class BacklashJoint(FrictionFields):
    """Parameters of a simulated elastic joint with backlash and hysteresis in its gear, checked.

    Parameters
    ----------
    kind : "backlash"
        Kind of joint.
    inertia, link_share, link_stiffness, link_damping, friction_lag, solver_period
        As of :class:`plant.ElasticJoint`.
    gap : float
        Free play between motor and link, from one side to the other, rad on the joint's side, zero or more.
    hysteresis : float, optional
        Torque that the gear's hysteresis adds to or takes from the spring's, N m, zero or more.
    hysteresis_reach : float, optional
        Twist within which a reversal takes the hysteresis from zero to all of it, rad, positive.
    **fields
        Those of :class:`FrictionFields`; friction and offset act at the motor.

    Raises
    ------
    pydantic.ValidationError
        A field is missing, unknown, of the wrong type or out of range, or the solver period is too long.
    """

    kind: Literal["backlash"] = "backlash"
    link_share: Share
    link_stiffness: Positive
    link_damping: NonNegative = 0.0
    friction_lag: NonNegative = 0.0
    gap: NonNegative
    hysteresis: NonNegative = 0.0
    hysteresis_reach: Positive = 0.001
    solver_period: Positive = 0.001

    @model_validator(mode="after")
    def _check_period(self) -> Self:
        check_backlash_period(self.parameters, self.solver_period)
        return self

    @property
    def parameters(self) -> BacklashParameters:
        """The parameters as the step takes them."""
        link_inertia = self.link_share * self.inertia
        return BacklashParameters(
            motor_inertia=self.inertia - link_inertia,
            link_inertia=link_inertia,
            friction=self.friction,
            backward=self.friction_backward,
            offset=self.offset,
            friction_lag=self.friction_lag,
            link_stiffness=self.link_stiffness,
            link_damping=self.link_damping,
            half_gap=0.5 * self.gap,
            hysteresis=self.hysteresis,
            hysteresis_stiffness=self.hysteresis / self.hysteresis_reach,
        )


def check_backlash_period(joint: BacklashParameters, period: float) -> None:
    """Refuse a solver period that does not suit the elastic joint with the stiffness of the element that sticks.

    Raises
    ------
    ValueError
        The period is too long; the message names the longest one allowed.
    """
    stiffness = joint.link_stiffness + joint.hysteresis_stiffness
    check_elastic_period(joint._replace(link_stiffness=stiffness), period)
