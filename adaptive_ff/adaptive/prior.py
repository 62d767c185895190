"""What an adaptive controller assumes of its joint before it has learnt: first estimate, units, how sure it is."""

import math
from collections.abc import Mapping, Sequence
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from adaptive_ff.friction.bounds import OFFSET, VISCOUS_SHARE, possible_ranges
from adaptive_ff.friction.model import FURTHER, RIPPLE, WITH_GRAVITY, TorqueModel
from controllers.checks import check_numbers

LAG_UNIT = 0.01
"""Least unit of the friction lag, s: the time constant of a fast loop would be too small a unit to find the lag in."""

ONE_SIDED_SHARE = 0.1
"""Units of the offset and of what differs by direction, as a share of those of friction itself.

Until the joint has moved both ways, the offset and Coulomb friction are one number; the smaller unit, the less of it is
taken for an offset. With equal units the first seconds were worse than with the five parameters of a symmetric joint.
"""

LOAD_SHARE = 1.0
"""Unit of the sizes of known loads, gravity among them, as a share of that of friction."""

CHOSEN = ("stribeck_velocity", "presliding")
"""Estimates of another controller that are no parameters: candidates, of which the first one says where to begin."""

LEAST_DEVIATION = 0.01
"""Least standard deviation of a first estimate, in units of the parameter: a prior that is surer would not fade."""


LONGEST_GUESS = 0.03
"""Longest lag of friction that is assumed at first, s; else the time in which the loop brakes its inertia, ``J/Kp``.

That is 0.1 s in loops of 2 Hz, where a joint with a shorter lag sticks at each reversal for longer than the filters
remember, and the lag comes down by 7 % a reversal. With 0.05, 0.03 and 0.02 s at most, 600 machines drawn with seed 101
(:mod:`benchmarks.drawn_machines`) settle at 1.039, 1.066 and 1.073 times the ratio to PI, as a geometric mean.
"""

INERTIA_DEVIATION = 0.3
"""Standard deviation of the inertia that the feedback was designed for, as a share of it.

Before a joint has turned round a few times, friction that bends or falls looks like inertia, up to ten times what it
is. With 1.0, as all other parameters have it, machines drawn with seed 101 settle at 0.98 times the ratio to PI that
they have with 0.3, falls of 10 and 20 gains at 0.91 (geometric mean; median of seeds 101 to 112). Told too small by
five it is found all the same.
"""


class Prior(NamedTuple):
    """What is assumed of the parameters, in the order of the estimate.

    Attributes
    ----------
    first, scale, deviation : ndarray, shape (n,)
        First estimate, unit of each parameter, and standard deviation of the first estimate.
    given : bool
        Whether the first estimate is that of a model, so that nothing is guessed before there is something to learn.
    """

    first: NDArray[np.float64]
    scale: NDArray[np.float64]
    deviation: NDArray[np.float64]
    given: bool


def parameter_units(
    names: Sequence[str], inertia: float, proportional: float, stribeck_velocity: float
) -> NDArray[np.float64]:
    """Return the unit that each parameter is estimated in, of its expected size.

    Parameters
    ----------
    names : sequence of str
        The parameters.
    inertia : float
        Inertia that the feedback was designed for, kg m^2.
    proportional : float
        Proportional gain, N m s/rad.
    stribeck_velocity : float
        Assumed Stribeck velocity, rad/s.
    """
    torque, slope = proportional * stribeck_velocity, VISCOUS_SHARE * proportional
    units = {
        "inertia": inertia,
        "coulomb": torque,
        "stiction": torque,
        "viscous": slope,
        "friction_lag": max(inertia / proportional, LAG_UNIT),
        "offset": ONE_SIDED_SHARE * torque,
        "stiction_asymmetry": ONE_SIDED_SHARE * torque,
        "viscous_asymmetry": ONE_SIDED_SHARE * slope,
    }
    return np.array([units.get(name, LOAD_SHARE * torque) for name in names])


def frictionless_prior(names: Sequence[str], scale: NDArray[np.float64], inertia: float, lag: float) -> Prior:
    """Return the prior of a frictionless joint of an inertia (kg m^2), with a friction lag (s); as sure as a unit.

    Only the inertia is surer: the feedback was designed for it.
    """
    known, sure = {"inertia": inertia, "friction_lag": lag}, {"inertia": INERTIA_DEVIATION}
    first = np.array([known.get(name, 0.0) for name in names])
    return Prior(first, scale, scale * np.array([sure.get(name, 1.0) for name in names]), False)


def model_prior(
    names: Sequence[str],
    scale: NDArray[np.float64],
    model: TorqueModel | Mapping[str, float],
    deviation: float | Mapping[str, float],
    ranges: NDArray[np.float64],
) -> Prior:
    """Return the prior that a model of the joint makes.

    Parameters
    ----------
    names : sequence of str
        The parameters.
    scale : ndarray, shape (n,)
        Their units.
    model : TorqueModel or mapping
        The joint, from a data sheet, an identification or the ``estimates`` of another controller. Of a mapping what
        this controller does not identify is passed over, and what it lacks but for the inertia and the lag is zero.
    deviation : float or mapping
        How sure it is: standard deviation as a share of each value, or for each name in its unit. What is zero, or not
        named, is as uncertain as the unit of the parameter.
    ranges : ndarray, shape (n, 2)
        Possible values.

    Raises
    ------
    ValueError
        A value is missing, not finite or not possible, a name is not one of the parameters, or a deviation is not
        positive and finite.
    TypeError
        The model is none, or a value no number.
    """
    known = model._asdict() if isinstance(model, TorqueModel) else _by_name(model)
    possible = {*names, *TorqueModel._fields, *WITH_GRAVITY, *CHOSEN}
    unknown = [name for name in known if name not in possible and not name.startswith((FURTHER, *RIPPLE))]
    if unknown:
        raise ValueError(f"model.{min(unknown)} is not known: it must be one of {', '.join(sorted(possible))}")
    first = np.zeros(len(names))
    for i, name in enumerate(names):
        if name not in known and name in ("inertia", "friction_lag"):
            raise ValueError(f"model has no {name}: it must have inertia and friction_lag at least")
        check_numbers(**{f"model.{name}": known.get(name, 0.0)})
        value = float(known.get(name, 0.0))
        least, most = ranges[i] if i >= OFFSET or name in ("inertia", "friction_lag") else (0.0, math.inf)
        if not (math.isfinite(value) and least <= value <= most):
            raise ValueError(
                f"model.{name} = {value:g} is not allowed: it must be finite and from {least:g} to {most:g}"
            )
        first[i] = value
    return Prior(first, scale, _deviations(names, scale, first, deviation), True)


def _by_name(model: Mapping[str, float]) -> dict[str, float]:
    """Return a mapping as a dict; raise ``TypeError`` for what is none."""
    try:
        known = dict(model)
    except (TypeError, ValueError):
        known = None
    if known is None or not all(isinstance(name, str) for name in known):
        raise TypeError(f"model = {model!r} is not allowed: it must be a TorqueModel, or values by name")
    return known


def _deviations(
    names: Sequence[str],
    scale: NDArray[np.float64],
    first: NDArray[np.float64],
    deviation: float | Mapping[str, float],
) -> NDArray[np.float64]:
    if isinstance(deviation, Mapping):
        unknown = set(deviation) - {*names, *CHOSEN}
        if unknown:
            raise ValueError(f"deviation.{min(unknown)} is not allowed: it must be one of {', '.join(names)}")
        given = {f"deviation.{name}": value for name, value in deviation.items()}
        check_numbers(**given)
        asked = np.array([float(deviation.get(name, unit)) for name, unit in zip(names, scale, strict=True)])
    else:
        given = {"deviation": deviation}
        check_numbers(**given)
        asked = np.where(first != 0.0, float(deviation) * np.abs(first), scale)
    for where, value in given.items():
        if not (math.isfinite(value) and value > 0.0):
            raise ValueError(f"{where} = {value} is not allowed: it must be positive and finite")
    found: NDArray[np.float64] = np.maximum(asked, LEAST_DEVIATION * scale)
    return found


def prior_of(
    names: Sequence[str],
    *,
    inertia: float,
    proportional: float,
    stribeck: tuple[float, float],
    largest_lag: float,
    model: TorqueModel | Mapping[str, float] | None,
    deviation: float | Mapping[str, float],
) -> tuple[Prior, NDArray[np.float64]]:
    """Return the prior of a controller, and the possible values of its parameters, shape (n, 2).

    Parameters
    ----------
    names : sequence of str
        The parameters.
    inertia, proportional : float
        Inertia that the feedback was designed for, kg m^2, and its proportional gain, N m s/rad.
    stribeck : (float, float)
        Stribeck velocity, rad/s, and shape factor; those of a model must be the same.
    largest_lag : float
        Largest possible friction lag, s.
    model, deviation
        See ``model_prior``; without a model the joint is assumed to be frictionless.

    Raises
    ------
    ValueError
        The model or its deviation is not allowed.
    """
    ranges = possible_ranges(inertia, largest_lag, len(names))
    scale = parameter_units(names, inertia, proportional, stribeck[0])
    if model is None:
        _deviations(names, scale, scale, deviation)  # checked, though without a model it is of no use
        lag = min(inertia / proportional, LONGEST_GUESS)
        return frictionless_prior(names, scale, inertia, lag), ranges
    if isinstance(model, TorqueModel):
        for name, value in zip(("stribeck_velocity", "stribeck_shape"), stribeck, strict=True):
            own = getattr(model, name)
            check_numbers(**{f"model.{name}": own})
            if own != value:
                raise ValueError(f"model.{name} = {own:g} is not allowed: it must be {name} = {value:g}")
    return model_prior(names, scale, model, deviation, ranges), ranges
