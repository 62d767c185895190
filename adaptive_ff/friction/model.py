"""The friction model that controllers assume of a joint: a hypothesis, assumed or identified.

It is the paper's model, equations (1)-(3), written for one direction of use: which torque does a motion need. Beyond
the paper it has what real joints have, an offset and friction that differs by direction:

    F(w) = sgn(w) (Fc (1 - e) + (Fs +- dFs) e) + (sigma +- dsigma) w + offset,   e = exp(-|w/Vs|^delta)

with the upper sign for ``w > 0``. What does not change its sign with the direction, ``dFs e + dsigma |w| + offset``,
stands beside the paper's friction and is zero where the joint is symmetric. The truth that a simulation runs on is
``plant``; a test ties the two where they must agree.
"""

import math
from typing import Any, NamedTuple

from controllers.checks import check_numbers


class TorqueModel(NamedTuple):
    """Assumed parameters of a joint; names as in the scenario's ``[joint]`` table.

    Attributes
    ----------
    inertia : float
        Inertia ``J``, kg m^2.
    coulomb : float
        Coulomb friction ``Fc``, N m.
    stiction : float
        Stiction ``Fs``, N m.
    viscous : float
        Viscous coefficient ``sigma``, N m s/rad.
    friction_lag : float
        Friction lag ``tau``, s.
    stribeck_velocity : float
        Stribeck velocity ``Vs``, rad/s.
    stribeck_shape : float
        Stribeck shape factor ``delta``.
    offset : float
        Torque that friction and load add to the paper's friction whatever the motion, N m. A constant passes the
        friction lag unchanged, so a constant load and Coulomb friction that differs by direction, ``Fc +- dFc``, are
        one number while the joint slides: ``offset`` is their sum.
    stiction_asymmetry : float
        Half of what ``Fs - Fc`` is more for positive than for negative velocity, N m: ``dFs`` above.
    viscous_asymmetry : float
        Half of what ``sigma`` is more for positive than for negative velocity, N m s/rad: ``dsigma`` above.
    presliding : float
        Presliding distance, rad: path over which friction follows its static curve; zero without bristles.
    micro_damping : float
        Damping of the bristles, N m; see ``friction.feedforward``.
    """

    inertia: float
    coulomb: float
    stiction: float
    viscous: float
    friction_lag: float
    stribeck_velocity: float
    stribeck_shape: float
    offset: float = 0.0
    stiction_asymmetry: float = 0.0
    viscous_asymmetry: float = 0.0
    presliding: float = 0.0
    micro_damping: float = 0.0


POSITIVE = ("stribeck_velocity", "stribeck_shape")
"""Fields of the model that are positive ..."""

NOT_NEGATIVE = ("inertia", "coulomb", "stiction", "viscous", "friction_lag", "presliding", "micro_damping")
"""... and those that are zero or more; the others are any finite numbers."""


def checked_model(name: str, model: Any) -> TorqueModel:
    """Return a model of numbers that a joint can have.

    Parameters
    ----------
    name : str
        What it is called in messages.
    model : TorqueModel
        The model.

    Raises
    ------
    TypeError
        It is no model, or a field is no number.
    ValueError
        A field is not possible; the message names it.
    """
    if not isinstance(model, TorqueModel):
        raise TypeError(f"{name} = {model!r} is not allowed: it must be a TorqueModel")
    check_numbers(**{f"{name}.{field}": value for field, value in model._asdict().items()})
    for field, value in model._asdict().items():
        rule, allowed = "finite", math.isfinite(value)
        if field in POSITIVE:
            rule, allowed = "positive and finite", allowed and value > 0.0
        elif field in NOT_NEGATIVE:
            rule, allowed = "zero or more and finite", allowed and value >= 0.0
        if not allowed:
            raise ValueError(f"{name}.{field} = {value:g} is not allowed: it must be {rule}")
    return TorqueModel(*map(float, model))


ESTIMATED = ("inertia", "coulomb", "stiction", "viscous", "friction_lag")
"""Fields of the model that are identified online; Stribeck velocity and shape are pre-estimated, as in the paper."""

WITH_OFFSET = (*ESTIMATED, "offset")
"""The same, with the offset."""

PER_DIRECTION = (*WITH_OFFSET, "stiction_asymmetry", "viscous_asymmetry")
"""The same, with the offset and what differs by direction."""

GRAVITY = ("gravity_sin", "gravity_cos")
"""Torque of a weight on a rotary joint at the position ``q``: ``gravity_sin sin q + gravity_cos cos q``, N m."""

WITH_GRAVITY = (*WITH_OFFSET, *GRAVITY)
"""The parameters of a symmetric joint with the offset and gravity."""

PER_DIRECTION_WITH_GRAVITY = (*PER_DIRECTION, *GRAVITY)
"""The same, with what differs by direction."""

IDENTIFIED = {
    "symmetric": ESTIMATED,
    "offset": WITH_OFFSET,
    "directions": PER_DIRECTION,
    "gravity": WITH_GRAVITY,
    "directions_and_gravity": PER_DIRECTION_WITH_GRAVITY,
}
"""What may be identified, by the name that a user gives."""

UNITS = {
    **dict.fromkeys(("coulomb", "stiction", "offset", "stiction_asymmetry", "gravity_sin", "gravity_cos"), "N m"),
    **dict.fromkeys(("viscous", "viscous_asymmetry"), "N m s/rad"),
    **{"stribeck_velocity": "rad/s", "presliding": "rad", "inertia": "kg m²", "friction_lag": "s"},
}
"""Units of the identified parameters but for those of ripples and further regressors; see :func:`unit_of`."""

FURTHER = "regressor_"
"""Names of the sizes of further known regressors begin with this; their number, from 1 on, follows."""

RIPPLE = ("ripple_sin_", "ripple_cos_")
"""Names of the sizes of a ripple begin with these; the number of its period, from 1 on, follows.

At the position ``q`` one of period ``p`` is the torque ``ripple_sin_1 sin(2 pi q/p) + ripple_cos_1 cos(2 pi q/p)``.
"""


def ripple_names(count: int) -> tuple[str, ...]:
    """Return the names of the sizes of ripples of so many periods."""
    return tuple(f"{part}{number}" for number in range(1, count + 1) for part in RIPPLE)


def unit_of(name: str) -> str:
    """Return the unit of an identified parameter; empty for another one.

    Further regressors count as numbers, their sizes as torques.
    """
    return "N m" if name.startswith((FURTHER, *RIPPLE)) else UNITS.get(name, "")


def stiction_fraction(speed: float, stribeck_velocity: float, stribeck_shape: float) -> float:
    """Return the fraction of stiction, ``exp(-(|w|/Vs)^delta)``, which is ``|h(w)|`` of (6).

    The rest of one is the fraction of Coulomb friction, ``|g(w)|`` of (5).
    """
    return math.exp(-stribeck_power(speed, stribeck_velocity, stribeck_shape))


def stribeck_power(speed: float, stribeck_velocity: float, stribeck_shape: float) -> float:
    """Return ``(|w|/Vs)^delta``; at most 1e4, since the fraction of stiction is zero long before."""
    ratio = speed / stribeck_velocity
    if stribeck_shape == 1.0:
        return min(ratio, 1e4)
    if stribeck_shape == 2.0:
        return min(ratio * ratio, 1e4)
    if ratio > 1.0 and stribeck_shape * math.log(ratio) > 7.0:
        return 1e4  # the power could overflow
    return float(ratio**stribeck_shape)


def friction_parts(model: TorqueModel, speed: float) -> tuple[float, float]:
    """Return what of the friction changes its sign with the direction, and what does not.

    Parameters
    ----------
    model : TorqueModel
        The joint.
    speed : float
        Sliding speed ``|w| >= 0``, rad/s.

    Returns
    -------
    opposing : float
        Friction (3), the mean of both directions, N m; it has the sign of the velocity.
    one_sided : float
        ``dFs e + dsigma |w|``, N m; the offset is not in it.
    """
    fraction = stiction_fraction(speed, model.stribeck_velocity, model.stribeck_shape)
    opposing = model.coulomb * (1.0 - fraction) + model.stiction * fraction + model.viscous * speed
    return opposing, model.stiction_asymmetry * fraction + model.viscous_asymmetry * speed


def model_friction(model: TorqueModel, speed: float) -> float:
    """Friction torque (N m) at a sliding speed ``|w| >= 0`` (rad/s), equation (3): the mean of both directions."""
    return friction_parts(model, speed)[0]


def directed_friction(model: TorqueModel, speed: float, direction: float) -> float:
    """Friction torque (N m) at a sliding speed (rad/s) in the direction of a signed number, without the offset."""
    opposing, one_sided = friction_parts(model, speed)
    return math.copysign(opposing, direction) + one_sided
