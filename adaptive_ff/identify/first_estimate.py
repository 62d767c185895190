"""What an identified joint is to a controller: its first model, and how sure that is."""

import math
from collections.abc import Sequence
from statistics import NormalDist
from typing import Any

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
from adaptive_ff.identify.columns import ASYMMETRY
from adaptive_ff.identify.joint import IdentifiedJoint

REPORTED_AS = dict(zip(GRAVITY, ("gravity_sine", "gravity_cosine"), strict=True))
"""Names in an identification of what controllers call otherwise."""

ASSUMED_LAG = 0.01
"""Friction lag where none is identified, s: fed too early friction throws a joint, too late it sticks a little."""

SLOW = 0.05
"""Stribeck velocity where none is identified, over the usual speed."""

LARGEST_FRACTION = 0.9
"""Largest fraction by which friction varies over the position."""


def torque_model(found: IdentifiedJoint, torque_constant: float | None = None) -> TorqueModel:
    """Return the best model as the torque model of a controller; ``torque_constant`` (N m/A) of a current.

    Raises
    ------
    InputError
        The inertia is not identifiable, or the torque constant is not allowed.
    """
    scale = _torque_scale(found, torque_constant)
    if found.value("inertia") <= 0.0:
        raise InputError(f"{found.name}: the inertia is not identifiable, so there is no model of the joint")
    known = {name: scale * one.value for name, one in found.joint_parameters.items()}
    excess = known.get("stiction_excess", 0.0)
    return TorqueModel(
        inertia=known["inertia"],
        coulomb=known.get("coulomb", 0.0),
        stiction=known.get("coulomb", 0.0) + excess,
        viscous=known.get("viscous", 0.0),
        friction_lag=found.value("friction_lag") or (0.0 if found.value("path") else ASSUMED_LAG),
        stribeck_velocity=found.value("stribeck_velocity")
        if excess
        else float(f"{SLOW * float(abs(found.data.velocity).max()):.3g}"),
        stribeck_shape=1.0,
        offset=known.get("offset", 0.0),
        viscous_asymmetry=known.get(ASYMMETRY, 0.0),
        presliding=found.value("path"),
    )


def first_estimate(
    found: IdentifiedJoint, torque_constant: float | None = None, parameters: Sequence[str] | None = None
) -> dict[str, Any]:
    """Return what an adaptive controller begins with: arguments of ``AdaptiveController`` beside gains and period.

    The standard deviations are in the units of the first model; one that is not named is not bounded by the log. Where
    friction depends on position, its map is among the arguments.

    Parameters
    ----------
    found : IdentifiedJoint
        The joint.
    torque_constant : float, optional
        N m/A (N/A), where the log has a current.
    parameters : sequence of str, optional
        What the controller is to identify; by default what suits the model.
    """
    try:
        names = _suiting(found) if parameters is None else check_parameters(parameters, ALL_CHOICES)
    except ValueError as error:
        raise InputError(str(error)) from error
    model, scale = torque_model(found, torque_constant), _torque_scale(found, torque_constant)
    values = model._asdict()
    values |= {name: scale * found.value(REPORTED_AS[name]) for name in GRAVITY if name in names}
    normal, deviation = NormalDist().inv_cdf(0.5 + 0.5 * found.confidence), {}
    for name in names:
        one = found.joint_parameters.get(REPORTED_AS.get(name, name))
        if one is not None:
            half = max(one.upper - one.value, one.value - one.lower) * (1.0 if name == "friction_lag" else scale)
            deviation[name] = half / normal
    if "coulomb" in deviation:
        deviation.setdefault("stiction", deviation["coulomb"])
    return {
        "inertia": model.inertia,
        "stribeck_velocity": model.stribeck_velocity,
        "stribeck_shape": model.stribeck_shape,
        "parameters": names,
        "model": values,
        "deviation": {name: value for name, value in deviation.items() if math.isfinite(value) and value > 0.0},
        **_over_position(found),
    }


def _over_position(found: IdentifiedJoint) -> dict[str, Any]:
    """Return the arguments of friction that depends on position, over Coulomb friction; none where it does not."""
    place, coulomb = found.data.place, found.value("coulomb")
    if not any(f"friction_{name}" in found.best.values for name in place.names) or coulomb <= 0.0:
        return {}
    waves = [f"{part}_{number}" for number in range(1, len(place.periods) + 1) for part in ("cosine", "sine")]
    hats = [f"hat_{number}" for number in range(1, place.hats + 1)]
    fractions = [found.value(f"friction_{name}") / coulomb for name in (*waves, *hats)]
    return {
        "position_periods": place.periods,
        "position_hats": place.hats,
        "position_range": (place.low, place.high) if place.hats else None,
        "position_map": tuple(min(max(one, -LARGEST_FRACTION), LARGEST_FRACTION) for one in fractions),
    }


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
