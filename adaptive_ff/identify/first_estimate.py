"""What an identified joint is to a controller: its first model, and how sure that is."""

import math
from collections.abc import Sequence
from statistics import NormalDist
from typing import NamedTuple

from adaptive_ff.errors import InputError, check_positive
from adaptive_ff.friction.identifying import ALL_CHOICES, check_parameters
from adaptive_ff.friction.model import (
    GRAVITY,
    PER_DIRECTION,
    PER_DIRECTION_WITH_GRAVITY,
    WITH_GRAVITY,
    WITH_OFFSET,
    TorqueModel,
)
from adaptive_ff.identify.result import ASYMMETRY, IdentifiedJoint
from adaptive_ff.identify.selection import Parameter

REPORTED_AS = dict(zip(GRAVITY, ("gravity_sine", "gravity_cosine"), strict=True))
"""Names in an identification of what controllers call otherwise."""

FRICTION = ("coulomb", "viscous", "stiction_excess")
"""Friction of a simulated joint."""

ASSUMED_LAG = 0.01
"""Friction lag where none is identified, s: fed too early friction throws a joint, too late it sticks a little."""

SLOW = 0.05
"""Stribeck velocity where none is identified, over the usual speed."""

LARGEST_FRACTION = 0.9
"""Largest fraction by which friction varies over the position."""


class FirstEstimate(NamedTuple):
    """Arguments of :class:`AdaptiveController` that an identification gives, beside its gains and period.

    Attributes
    ----------
    inertia : float
        Inertia, kg m^2 (kg); design the gains for it.
    stribeck_velocity, stribeck_shape : float
        Stribeck velocity, rad/s (m/s), and shape factor.
    parameters : tuple of str
        What the controller is to identify.
    model : dict of float
        First model: fields of ``TorqueModel``, and gravity.
    deviation : dict of float
        Standard deviations in the units of ``model``, by name; not named is what the log does not bound.
    position_periods : tuple of float
        Known periods that friction depends on, rad (m).
    position_hats : int
        Number of hats of friction over position.
    position_range : tuple of float or None
        Positions of the first and of the last hat, rad (m).
    position_map : tuple of float or None
        Cosine and sine of each period, then the hats, over friction; None where it does not depend on position.
    """

    inertia: float
    stribeck_velocity: float
    stribeck_shape: float
    parameters: tuple[str, ...]
    model: dict[str, float]
    deviation: dict[str, float]
    position_periods: tuple[float, ...] = ()
    position_hats: int = 0
    position_range: tuple[float, float] | None = None
    position_map: tuple[float, ...] | None = None


def torque_model(found: IdentifiedJoint, torque_constant: float | None = None) -> TorqueModel:
    """Return the best model of an identified joint as a controller takes it.

    Raises
    ------
    InputError
        The inertia is not identifiable, or the torque constant is not allowed.
    """
    scale = _torque_scale(found, torque_constant)
    if found.value("inertia") <= 0.0:
        raise InputError(f"{found.name}: the inertia is not identifiable, so there is no model of the joint")
    known = found.joint_parameters
    coulomb, viscous, excess = (known[name].value if name in known else 0.0 for name in FRICTION)
    fast = float(abs(found.rows.velocity).max())
    return TorqueModel(
        inertia=scale * found.value("inertia"),
        coulomb=scale * coulomb,
        stiction=scale * (coulomb + excess),
        viscous=scale * viscous,
        friction_lag=found.value("friction_lag") or (0.0 if found.value("path") else ASSUMED_LAG),
        stribeck_velocity=found.value("stribeck_velocity") if excess else float(f"{SLOW * fast:.3g}"),
        stribeck_shape=1.0,
        offset=scale * found.value("offset"),
        viscous_asymmetry=scale * found.value(ASYMMETRY),
        presliding=found.value("path"),
    )


def first_estimate(
    found: IdentifiedJoint, torque_constant: float | None = None, parameters: Sequence[str] | None = None
) -> FirstEstimate:
    """Return what a controller begins with; see `IdentifiedJoint.first_estimate`."""
    names = _suiting(found) if parameters is None else _checked(parameters)
    model, scale = torque_model(found, torque_constant), _torque_scale(found, torque_constant)
    values = model._asdict()
    values |= {name: scale * found.value(REPORTED_AS[name]) for name in GRAVITY if name in names}
    known, spread = found.joint_parameters, {}
    normal = NormalDist().inv_cdf(0.5 + 0.5 * found.confidence)
    for name in names:
        one = known.get(REPORTED_AS.get(name, name))
        if one is not None:
            unit = 1.0 if name == "friction_lag" else scale
            spread[name] = unit * _spread(one, normal)
    if "coulomb" in spread:
        spread.setdefault("stiction", spread["coulomb"])
    deviation = {name: value for name, value in spread.items() if math.isfinite(value) and value > 0.0}
    first = FirstEstimate(model.inertia, model.stribeck_velocity, model.stribeck_shape, names, values, deviation)
    return _with_map(first, found)


def _with_map(first: FirstEstimate, found: IdentifiedJoint) -> FirstEstimate:
    """Return a first estimate with friction over position as it was identified."""
    place, coulomb = found.place, found.value("coulomb")
    if not any(f"friction_{name}" in found.best.values for name in place.names) or coulomb <= 0.0:
        return first
    waves = [f"{part}_{number}" for number in range(1, len(place.periods) + 1) for part in ("cosine", "sine")]
    hats = [f"hat_{number}" for number in range(1, place.hats + 1)]
    fractions = [found.value(f"friction_{name}") / coulomb for name in (*waves, *hats)]
    return first._replace(
        position_periods=place.periods,
        position_hats=place.hats,
        position_range=(place.low, place.high) if place.hats else None,
        position_map=tuple(min(max(fraction, -LARGEST_FRACTION), LARGEST_FRACTION) for fraction in fractions),
    )


def _spread(one: Parameter, normal: float) -> float:
    """Return the standard deviation of a parameter by its interval."""
    return max(one.upper - one.value, one.value - one.lower) / normal


def _checked(parameters: Sequence[str]) -> tuple[str, ...]:
    try:
        return check_parameters(parameters, ALL_CHOICES)
    except ValueError as error:
        raise InputError(str(error)) from error


def _suiting(found: IdentifiedJoint) -> tuple[str, ...]:
    if found.value(ASYMMETRY) != 0.0:
        return PER_DIRECTION if found.linear else PER_DIRECTION_WITH_GRAVITY
    return WITH_OFFSET if found.linear else WITH_GRAVITY


def _torque_scale(found: IdentifiedJoint, torque_constant: float | None) -> float:
    """Return the factor from the log's torque to N m (N)."""
    is_current = found.units["torque"] == "A"
    if torque_constant is None:
        if is_current:
            raise InputError(f"{found.name}: the torque is a current; give torque_constant, in N m/A (N/A)")
        return 1.0
    check_positive(torque_constant=torque_constant)
    if not is_current:
        raise InputError(f"{found.name}: torque_constant = {torque_constant:g} is given, but the torque is no current")
    return float(torque_constant)
