"""Joints with Maxwell-slip friction as a user meets them: by their elements, or by the curve of a rolling contact."""

import math
from collections.abc import Iterable
from itertools import pairwise
from typing import Annotated, Literal, Self

from pydantic import Field, model_validator

from plant.fields import Positive
from plant.friction import Stribeck, steepest_fall
from plant.joint import LARGEST_FALL, FrictionFields
from plant.maxwell import ELEMENTS, Four, MaxwellParameters

FourValues = Annotated[list[Positive], Field(min_length=ELEMENTS, max_length=ELEMENTS)]

EVEN = [0.25, 0.25, 0.25, 0.25]

KNOTS = (1.0 / 16.0, 1.0 / 4.0, 9.0 / 16.0, 1.0)
"""Where on a rolling contact's curve the elements slip, as shares of its range: closer where it bends more."""


class SlipFields(FrictionFields):
    """What both kinds of joints with Maxwell-slip friction have, beside the fields of every joint.

    Parameters
    ----------
    solver_period : float, optional
        Solver period ``h``, s, positive, and short enough for the implicit step to have one solution.
    """

    solver_period: Positive = 0.001

    @model_validator(mode="after")
    def _check_curve(self) -> Self:
        for curve, ending in ((self.friction, ""), (self.friction_backward, "_backward")):
            if curve.coulomb == 0.0:
                raise ValueError(
                    f"coulomb{ending} = 0 N m is not allowed for a joint whose friction is carried by elements: it "
                    "must be positive"
                )
        check_gentle_at_rest(self)
        return self

    def _elements(self, shares: Four, displacements: Four, relaxation: float) -> MaxwellParameters:
        torques = (share * self.stiction for share in shares)
        stiffnesses = tuple(torque / reach for torque, reach in zip(torques, displacements, strict=True))
        return MaxwellParameters(
            self.inertia, self.friction, self.friction_backward, self.offset, shares, _four(stiffnesses), relaxation
        )


class MaxwellJoint(SlipFields):
    """Parameters of a simulated rigid joint with generalised Maxwell-slip friction, checked.

    Parameters
    ----------
    kind : "maxwell"
        Kind of joint.
    displacements : list of float
        Displacement from rest, rad, after which each of the four elements slips where the others carry what they can:
        positive, ascending. Element i has the stiffness ``share stiction/displacement``.
    shares : list of float, optional
        Share of each element in the friction, positive, of the sum one; equal by default.
    attraction : float, optional
        ``C``, N m/s, positive: how fast a slipping element follows the Stribeck curve. By default at once.
    **fields
        Those of :class:`SlipFields`; ``coulomb`` of either direction is positive, ``stribeck_shape`` at least one.

    Raises
    ------
    pydantic.ValidationError
        A field is missing, unknown, of the wrong type or out of range, or the implicit step would not be unique.
    """

    kind: Literal["maxwell"] = "maxwell"
    displacements: FourValues
    shares: FourValues = EVEN
    attraction: Positive | None = None

    @model_validator(mode="after")
    def _check_elements(self) -> Self:
        if any(later <= earlier for earlier, later in pairwise(self.displacements)):
            raise ValueError(f"displacements = {self.displacements} is not allowed: they must ascend strictly")
        if abs(sum(self.shares) - 1.0) > 1e-6:
            raise ValueError(f"shares = {self.shares} is not allowed: their sum is {sum(self.shares):g}, not one")
        check_maxwell_period(self.parameters, self.solver_period)
        return self

    @property
    def parameters(self) -> MaxwellParameters:
        """The parameters as the step takes them."""
        total = sum(self.shares)
        shares = _four([share / total for share in self.shares])
        relaxation = 0.0 if self.attraction is None else 1.0 / self.attraction
        return self._elements(shares, _four(self.displacements), relaxation)


class RollingJoint(SlipFields):
    """Parameters of a simulated rigid joint with rolling friction, checked.

    From rest, friction grows with the displacement ``x`` as ``Fs (1 - (1 - x/range)^exponent)`` and stays at ``Fs``
    beyond the range; after a reversal by the Masing rule, twice as high and twice as far. Four Maxwell elements have
    that curve exactly where they slip, and straight lines between. The curve stands for those of T. Takemura,
    H. Fujimoto (2011) and Y. Maeda, M. Iwasaki (2013), who describe a ball screw by a rolling force, a range and an
    exponent, too; their formulas could not be compared.

    Parameters
    ----------
    kind : "rolling"
        Kind of joint.
    rolling_range : float
        Displacement from rest after which friction grows no more, rad, positive.
    exponent : float, optional
        Exponent of the curve, more than one: the higher, the steeper at its begin.
    **fields
        Those of :class:`SlipFields`; ``coulomb`` of either direction is positive, ``stribeck_shape`` at least one.

    Raises
    ------
    pydantic.ValidationError
        A field is missing, unknown, of the wrong type or out of range, or the implicit step would not be unique.
    """

    kind: Literal["rolling"] = "rolling"
    rolling_range: Positive
    exponent: Annotated[float, Field(gt=1.0, allow_inf_nan=False, strict=True)] = 2.0

    @model_validator(mode="after")
    def _check_period(self) -> Self:
        check_maxwell_period(self.parameters, self.solver_period)
        return self

    @property
    def parameters(self) -> MaxwellParameters:
        """The parameters as the step takes them."""
        heights = [1.0 - (1.0 - knot) ** self.exponent for knot in KNOTS]
        points = [(0.0, 0.0), *zip(KNOTS, heights, strict=True)]
        slopes = [(top - bottom) / (right - left) for (left, bottom), (right, top) in pairwise(points)] + [0.0]
        bends = [steep - flat for steep, flat in pairwise(slopes)]
        shares = _four([bend * knot for bend, knot in zip(bends, KNOTS, strict=True)])
        return self._elements(shares, _four([knot * self.rolling_range for knot in KNOTS]), 0.0)


def _four(values: Iterable[float]) -> Four:
    first, second, third, fourth = values
    return float(first), float(second), float(third), float(fourth)


def check_gentle_at_rest(joint: FrictionFields) -> None:
    """Refuse a Stribeck curve that falls infinitely steeply at rest, where a joint can only creep.

    Raises
    ------
    ValueError
        The shape factor is below one and the curve falls.
    """
    if math.isinf(steepest_fall(joint.friction)) or math.isinf(steepest_fall(joint.friction_backward)):
        raise ValueError(
            f"stribeck_shape = {joint.stribeck_shape:g} is not allowed for a joint of the kind {joint.kind!r}: it must "
            "be at least 1, or stiction equal to coulomb, since the curve falls infinitely steeply at rest"
        )


def longest_gentle_period(inertia: float, falls: Iterable[float]) -> float:
    """Return the solver period, s, at which falling friction (N m s/rad) takes half of the implicit step's slope."""
    fall = max(falls)
    return LARGEST_FALL * inertia / fall if fall > 0.0 else math.inf


def check_maxwell_period(joint: MaxwellParameters, period: float) -> None:
    """Refuse a solver period for which the implicit step could have more than one solution.

    Raises
    ------
    ValueError
        The period is too long; the message names the longest one allowed.
    """
    longest = longest_gentle_period(joint.inertia, (_steepest(joint.friction), _steepest(joint.backward)))
    if period > longest:
        raise ValueError(
            f"solver_period = {period:g} s is too long for this joint: beyond {longest:.6g} s the falling Stribeck "
            "curve could leave the implicit step more than one solution; use a shorter solver_period"
        )


def _steepest(curve: Stribeck) -> float:
    """Return how steeply the elements' torque after a step can fall with the speed, N m s/rad.

    A slipping element that follows with ``C`` falls ``(Fs e + 1)/(Fc e + 1)^2`` times as steeply as its share of the
    curve, ``e = 1/(h C)``, at most; that is one for ``Fs <= 2 Fc``, and has its largest value over ``e`` beyond.
    """
    ratio = curve.stiction / curve.coulomb
    factor = 1.0 if ratio <= 2.0 else ratio * ratio / (4.0 * (ratio - 1.0))
    return factor * (steepest_fall(curve._replace(viscous=0.0)))
