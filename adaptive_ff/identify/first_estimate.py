"""What an identified joint is to a controller: its first model, its friction over position, and how sure they are."""

import math
from collections.abc import Sequence
from numbers import Real
from statistics import NormalDist
from typing import NamedTuple

import numpy as np

from adaptive_ff.adaptive.learning.friction_map import LARGEST_COEFFICIENT
from adaptive_ff.adaptive.learning.map_settings import MAP_DEVIATION
from adaptive_ff.errors import InputError
from adaptive_ff.friction.identifying import ALL_CHOICES, check_parameters
from adaptive_ff.friction.model import (
    GRAVITY,
    PER_DIRECTION,
    PER_DIRECTION_WITH_GRAVITY,
    WITH_GRAVITY,
    WITH_OFFSET,
    TorqueModel,
    ripple_names,
)
from adaptive_ff.identify.result import LogIdentification
from adaptive_ff.identify.stiction import known_stiction
from adaptive_ff.identify.terms import ASYMMETRY, BENT, LAG, PATH, SATURATIONS, bent_friction
from adaptive_ff.identify.units import LINEAR, is_linear, of_current
from adaptive_ff.learning.batch_least_squares import Estimate

REPORTED_AS = dict(zip(GRAVITY, ("gravity_sine", "gravity_cosine"), strict=True))
"""Names in an identification of what the controllers call otherwise."""

ASSUMED_LAG = 0.01
"""Friction lag where none can be estimated, s: fed too early friction throws a joint, too late it sticks a little."""

NO_TORQUE = ("friction_lag", "stribeck_velocity", "stribeck_shape")
"""What is the same number whether the log holds a torque or a current."""


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
        How sure it is: standard deviations in the units of ``model``, by name; not named is what it does not bound.
    ripple_periods : tuple of float
        Periods of a force over position, rad (m), whose sizes ``model`` holds; none where none was found.
    position_periods : tuple of float
        Known periods that friction depends on, rad (m); none where it was not found to.
    position_hats : int
        Number of hats of friction over position; zero where there are none.
    position_range : tuple of float or None
        Positions of the first and of the last hat, rad (m); None without hats.
    position_map : tuple of float or None
        Cosine and sine of each period, then the hats, as shares of friction; None where it does not depend on position.
    map_deviation : tuple of float
        Their standard deviations; infinite for a hat that the log did not visit.
    """

    inertia: float
    stribeck_velocity: float
    stribeck_shape: float
    parameters: tuple[str, ...]
    model: dict[str, float]
    deviation: dict[str, float]
    ripple_periods: tuple[float, ...] = ()
    position_periods: tuple[float, ...] = ()
    position_hats: int = 0
    position_range: tuple[float, float] | None = None
    position_map: tuple[float, ...] | None = None
    map_deviation: tuple[float, ...] | float = MAP_DEVIATION


class _Sliding(NamedTuple):
    """Coulomb friction and viscous coefficient with that of friction which saturates, and their deviations."""

    coulomb: float
    viscous: float
    deviation: dict[str, float]


def torque_model(found: LogIdentification, torque_constant: float | None = None) -> TorqueModel:
    """Return the model of an identified joint; see :meth:`LogIdentification.torque_model`."""
    scale, lag = _torque_scale(found, torque_constant), _lag(found)
    inertia = found.value("inertia")
    if inertia <= 0.0:
        raise InputError(f"{found.name}: the inertia is not identifiable, so there is no model of the joint")
    sliding = _sliding(found)
    slow = known_stiction(found, sliding.coulomb)
    return TorqueModel(
        inertia=scale * inertia,
        coulomb=scale * sliding.coulomb,
        stiction=scale * slow.stiction,
        viscous=scale * sliding.viscous,
        friction_lag=ASSUMED_LAG if lag is None else _first_lag(lag),
        stribeck_velocity=slow.velocity,
        stribeck_shape=slow.shape,
        offset=scale * found.value("offset"),
        viscous_asymmetry=scale * found.value(ASYMMETRY),
        presliding=found.value(PATH),
    )


def first_estimate(
    found: LogIdentification, torque_constant: float | None = None, parameters: Sequence[str] | None = None
) -> FirstEstimate:
    """Return what a controller begins with; see :meth:`LogIdentification.first_estimate`."""
    names = _identified(found) if parameters is None else _checked(parameters)
    model, scale = torque_model(found, torque_constant), _torque_scale(found, torque_constant)
    values = model._asdict()
    values |= {name: scale * found.value(REPORTED_AS[name]) for name in GRAVITY if name in names}
    sliding = _sliding(found)
    known = {
        name: found.parameters[reported].estimate
        for name in names
        if (reported := REPORTED_AS.get(name, name)) in found.parameters
    }
    if _lag(found) is None:
        known.pop("friction_lag", None)
    stiction = known_stiction(found, sliding.coulomb).estimate
    if stiction is not None:
        known["stiction"] = stiction
    deviation = {}
    for name, estimate in known.items():
        unit = 1.0 if name in NO_TORQUE else scale
        error = sliding.deviation.get(name, _standard_deviation(estimate, values[name] / unit, found.confidence))
        if math.isfinite(error) and error > 0.0:
            deviation[name] = unit * error
    first = FirstEstimate(model.inertia, model.stribeck_velocity, model.stribeck_shape, names, values, deviation)
    return _with_map(_with_ripple(first, found, scale), found)


def _with_ripple(first: FirstEstimate, found: LogIdentification, scale: float) -> FirstEstimate:
    """Return a first estimate with the force over periods of position that was identified, times a scale."""
    learnt = found.position_map
    if learnt is None or not learnt.force_periods:
        return first
    model, deviation = dict(first.model), dict(first.deviation)
    cosines, sines = learnt.force_coefficients[::2], learnt.force_coefficients[1::2]
    pairs = [part for pair in zip(sines, cosines, strict=True) for part in pair]
    for name, estimate in zip(ripple_names(len(cosines)), pairs, strict=True):
        model[name] = scale * estimate.value
        deviation[name] = scale * _standard_deviation(estimate, estimate.value, found.confidence)
    return first._replace(model=model, deviation=deviation, ripple_periods=learnt.force_periods)


def _with_map(first: FirstEstimate, found: LogIdentification) -> FirstEstimate:
    """Return a first estimate with friction over position as it was identified."""
    learnt = found.position_map
    if learnt is None or not learnt.coefficients or first.model["coulomb"] <= 0.0:
        return first
    interval = found.selection.chosen.regression.interval
    pairs = list(zip(learnt.coefficients, learnt.standard_errors, strict=True))
    spread = [
        _standard_deviation(interval(value, error), value, found.confidence) if math.isfinite(error) else math.inf
        for value, error in pairs
    ]
    return first._replace(
        position_periods=learnt.periods,
        position_hats=learnt.hats,
        position_range=learnt.range if learnt.hats else None,
        position_map=tuple(float(np.clip(value, -LARGEST_COEFFICIENT, LARGEST_COEFFICIENT)) for value, _ in pairs),
        map_deviation=tuple(spread),
    )


def _checked(parameters: Sequence[str]) -> tuple[str, ...]:
    try:
        return check_parameters(parameters, ALL_CHOICES)
    except ValueError as error:
        raise InputError(str(error)) from error


def _lag(found: LogIdentification) -> Estimate | None:
    """Return the friction lag (s), the one estimated beside the model where that does without.

    None where there is no friction to lag, or where the interval reaches the ends of the search.

    On the built-in joint, whose lag is 20 ms, zero makes the first 10 s up to twice as bad as they are without a model,
    and the 16 ms that are estimated beside the model make them better (seeds 1 to 8, 11 to 16).
    """
    if PATH in found.selection.chosen.terms and LAG not in found.selection.chosen.terms:
        return Estimate(0.0, 0.0, 0.0, 0.0)  # it follows the path
    reported = found.parameters.get("friction_lag")
    sliding, (first, *_, last) = _sliding(found), found.lags
    if reported is None or not (sliding.coulomb > 0.0 or sliding.viscous > 0.0):
        return None
    bounded = first < reported.estimate.lower and reported.estimate.upper < last
    return reported.estimate if bounded else None


def _first_lag(lag: Estimate) -> float:
    """Return the lag to begin with, s: where zero is possible, the assumed one as far as the interval allows."""
    possible = min(ASSUMED_LAG, lag.upper) if lag.lower <= 0.0 else 0.0
    return max(lag.value, possible, 0.0)


def _identified(found: LogIdentification) -> tuple[str, ...]:
    linear = is_linear(found.units)
    if found.value(ASYMMETRY) != 0.0:
        return PER_DIRECTION if linear else PER_DIRECTION_WITH_GRAVITY
    return WITH_OFFSET if linear else WITH_GRAVITY


def _torque_scale(found: LogIdentification, torque_constant: float | None) -> float:
    """Return what the torques of an identification are multiplied by to be N m (N)."""
    current = of_current(LINEAR)["torque"]
    unit = "N/A" if is_linear(found.units) else "N m/A"
    if torque_constant is not None and not _is_number(torque_constant):
        raise InputError(f"torque_constant = {torque_constant!r} is not allowed: it must be a number of {unit}")
    if found.units["torque"] != current:
        if torque_constant is not None:
            raise InputError(
                f"torque_constant = {torque_constant:g} {unit} is not allowed: the log of {found.name} holds "
                f"{found.units['torque']}, not a current"
            )
        return 1.0
    if torque_constant is None:
        raise InputError(
            f"torque_constant is missing: the log of {found.name} holds a current, A, so it must be the torque (force) "
            f"of one ampere, {unit}, or 1 for a controller that commands A"
        )
    if not (math.isfinite(torque_constant) and torque_constant > 0.0):
        raise InputError(f"torque_constant = {torque_constant} {unit} is not allowed: it must be positive and finite")
    return float(torque_constant)


def _is_number(value: object) -> bool:
    return isinstance(value, Real) and not isinstance(value, bool)


def _sliding(found: LogIdentification) -> _Sliding:
    """Return Coulomb and viscous friction; a part that saturates is shared out between them as at the log's speeds.

    Where friction saturates its parts are vague and their sum is not, so what the straight line leaves of that part is
    the deviation.
    """
    coulomb, viscous = found.value("coulomb"), found.value("viscous")
    shapes = [shape for shape in SATURATIONS if found.value(shape) > 0.0 and found.value(BENT[shape]) > 0.0]
    if not shapes:
        return _Sliding(coulomb, viscous, {})
    speed = np.abs(np.concatenate([rows.velocity[rows.slides] for rows in found.rows]))
    bent = sum(found.value(shape) * bent_friction(shape, speed, found.value(BENT[shape])) for shape in shapes)
    line = np.column_stack([np.ones_like(speed), speed])
    (start, slope), *_ = np.linalg.lstsq(line, bent, rcond=None)
    left = float(np.sqrt(np.mean((line @ [start, slope] - bent) ** 2)))
    deviation = {"coulomb": left, "viscous": left / float(np.sqrt(np.mean(speed**2)))}
    return _Sliding(coulomb + float(start), viscous + float(slope), deviation)


def _standard_deviation(estimate: Estimate, value: float, confidence: float) -> float:
    """Return the standard deviation about a value that an interval of a probability stands for."""
    width = NormalDist().inv_cdf(0.5 * (1.0 + confidence))
    return max(abs(estimate.upper - value), abs(value - estimate.lower)) / width
