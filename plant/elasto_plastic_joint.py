"""The elasto-plastic joint as a user meets it."""

from typing import Literal, Self

from pydantic import model_validator

from plant.elasto_plastic import ElastoPlasticParameters
from plant.fields import NonNegative, Positive
from plant.friction import steepest_fall
from plant.joint import FrictionFields, longest_with_lag
from plant.maxwell_joint import check_gentle_at_rest, longest_gentle_period


class ElastoPlasticJoint(FrictionFields):
    """Parameters of a simulated rigid joint with two-state elasto-plastic friction, checked.

    Parameters
    ----------
    kind : "elasto_plastic"
        Kind of joint.
    presliding : float
        Displacement after a reversal until the joint slides, rad, positive.
    friction_lag : float, optional
        Friction lag ``tau``, s, zero or more.
    solver_period : float, optional
        Solver period ``h``, s, positive, and short enough for the implicit step to have one solution.
    **fields
        Those of :class:`FrictionFields`; ``stribeck_shape`` is at least one.

    Raises
    ------
    pydantic.ValidationError
        A field is missing, unknown, of the wrong type or out of range, or the implicit step would not be unique.
    """

    kind: Literal["elasto_plastic"] = "elasto_plastic"
    presliding: Positive
    friction_lag: NonNegative = 0.0
    solver_period: Positive = 0.001

    @model_validator(mode="after")
    def _check_step(self) -> Self:
        check_gentle_at_rest(self)
        check_elasto_plastic_period(self.parameters, self.solver_period)
        return self

    @property
    def parameters(self) -> ElastoPlasticParameters:
        """The parameters as the step takes them."""
        return ElastoPlasticParameters(
            self.inertia, self.friction, self.friction_backward, self.offset, self.friction_lag, self.presliding
        )


def check_elasto_plastic_period(joint: ElastoPlasticParameters, period: float) -> None:
    """Refuse a solver period for which the implicit step could have more than one solution.

    As of the rigid joint, ``kappa max(-g') < 1`` with ``kappa = h^2/(J (tau + h))``; half of that is allowed, so that
    the root can be bracketed.

    Raises
    ------
    ValueError
        The period is too long; the message names the longest one allowed.
    """
    falls = (steepest_fall(curve._replace(viscous=0.0)) for curve in (joint.friction, joint.backward))
    longest = longest_with_lag(longest_gentle_period(joint.inertia, falls), joint.friction_lag)
    if period > longest:
        raise ValueError(
            f"solver_period = {period:g} s is too long for this joint: beyond {longest:.6g} s the falling Stribeck "
            "curve could leave the implicit step more than one solution; use a shorter solver_period"
        )
