"""The LuGre joint as a user meets it."""

import math
from typing import Literal, Self

import numpy as np
from pydantic import model_validator

from plant.fields import NonNegative, Positive
from plant.joint import LARGEST_FALL, FrictionFields
from plant.lugre import LuGreParameters, bristle_torque

MOST_PASSIVE = 4.0 * math.sqrt(2.0 * math.e)
"""Largest ``sigma1 Vs/Fc``: ``sigma1(w) |w| <= 4 g(w)`` at every speed, since ``x exp(-x^2) <= 1/sqrt(2 e)``."""


POWERS = np.geomspace(1e-5, 50.0, 70).tolist()
"""Grid of ``|w/Vs|^delta``."""

RATIOS = np.geomspace(1e-4, 1e4, 80).tolist()
"""Grid of ratios of a speed to a scale of speed."""


class LuGreJoint(FrictionFields):
    """Parameters of a simulated rigid joint with LuGre friction, checked.

    Parameters
    ----------
    kind : "lugre"
        Kind of joint.
    stiffness : float
        Stiffness ``sigma0`` of the bristles, N m/rad, positive. The joint breaks away after some ``stiction/stiffness``
        of displacement.
    damping : float, optional
        Damping ``sigma1`` of the bristles at rest, N m s/rad, zero or more; it fades with speed as ``exp(-(w/Vs)^2)``.
        By default the bristles are critically damped, ``sigma1 + sigma2 = 2 sqrt(sigma0 J)``, as far as is allowed.
    solver_period : float, optional
        Solver period ``h``, s, positive, and short enough for the implicit step to have one solution.
    **fields
        Those of :class:`FrictionFields`; ``coulomb`` of either direction is positive.

    Raises
    ------
    pydantic.ValidationError
        A field is missing, unknown, of the wrong type or out of range, friction could give energy, or the implicit step
        would not be unique.
    """

    kind: Literal["lugre"] = "lugre"
    stiffness: Positive
    damping: NonNegative | None = None
    solver_period: Positive = 0.001

    @model_validator(mode="after")
    def _check_coulomb(self) -> Self:
        for curve, ending in ((self.friction, ""), (self.friction_backward, "_backward")):
            if curve.coulomb == 0.0:
                raise ValueError(
                    f"coulomb{ending} = 0 N m is not allowed for a LuGre joint: it must be positive, since bristles "
                    "that slide at no torque cannot bend"
                )
        return self

    @model_validator(mode="after")
    def _check_passive(self) -> Self:
        if self.damping is not None and self.damping > self._most_damping:
            raise ValueError(
                f"damping = {self.damping:g} N m s/rad is not allowed: it must be at most {self._most_damping:.6g} "
                "N m s/rad (9.33 coulomb/stribeck_velocity), or friction could give energy"
            )
        return self

    @model_validator(mode="after")
    def _check_unique_step(self) -> Self:
        check_lugre_period(self.parameters, self.solver_period)
        return self

    @property
    def _most_damping(self) -> float:
        return MOST_PASSIVE * min(self.coulomb, self.friction_backward.coulomb) / self.stribeck_velocity

    @property
    def parameters(self) -> LuGreParameters:
        """The parameters as the step takes them."""
        damping = self.damping
        if damping is None:
            critical = 2.0 * math.sqrt(self.stiffness * self.inertia)
            damping = min(max(critical - min(self.viscous, self.friction_backward.viscous), 0.0), self._most_damping)
        return LuGreParameters(
            self.inertia, self.friction, self.friction_backward, self.offset, self.stiffness, damping
        )


def check_lugre_period(joint: LuGreParameters, period: float) -> None:
    """Refuse a solver period for which the implicit step could have more than one solution.

    The step's equation has one while friction falls by less than ``J/h`` with the new speed, see
    :func:`steepest_fall_in_a_step`. Half of that is allowed, so that the grid on which the fall is looked for does not
    matter and the root can be bracketed.

    Raises
    ------
    ValueError
        The period is too long; the message names the longest one allowed.
    """
    if _is_unique(joint, period):
        return
    short, long = 0.0, period
    for _ in range(60):
        middle = 0.5 * (short + long)
        short, long = (middle, long) if _is_unique(joint, middle) else (short, middle)
    raise ValueError(
        f"solver_period = {period:g} s is too long for this joint: beyond {short:.6g} s its stiffness and damping "
        "could leave the implicit step more than one solution; use a shorter solver_period"
    )


def _is_unique(joint: LuGreParameters, period: float) -> bool:
    return steepest_fall_in_a_step(joint, period) <= LARGEST_FALL * joint.inertia / period


def steepest_fall_in_a_step(joint: LuGreParameters, period: float) -> float:
    """Return how steeply the friction torque after a step falls with the speed after it, N m s/rad, at worst.

    At a given speed the slope is linear in the bristles' torque before the step, so only the ends of its range, the
    stiction of either direction, need to be looked at. Each of the three factors that vary with speed has a grid of its
    own: the Stribeck curve, the bristles' slip over a step, and their damping.
    """
    slip, worst = period * joint.stiffness, 0.0
    for curve, other in ((joint.friction, joint.backward), (joint.backward, joint.friction)):
        speeds = (
            *(curve.stribeck_velocity * power ** (1.0 / curve.stribeck_shape) for power in POWERS),
            *(curve.coulomb / slip * ratio for ratio in RATIOS),
            *(curve.stribeck_velocity * ratio for ratio in RATIOS),
        )
        for bending in (curve.stiction, -other.stiction):
            slopes = (bristle_torque(curve, bending, slip, joint.damping, speed)[1] for speed in speeds)
            worst = max(worst, -curve.viscous - min(slopes))
    return worst
