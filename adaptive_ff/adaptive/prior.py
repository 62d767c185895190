"""What an adaptive controller assumes of its joint before it has learnt: mean, covariance and bounds of its columns.

Friction is a total, a split of it over the columns that bend over a path, and an excess of stiction:

    theta_slip + sum theta_path = Fc,        theta_stiction + sum theta_path = Fs

The total is vague, the split about as vague whatever the total, and stiction is slip and an excess. So a first turn of
the joint says how much friction there is, and some more of them how it sets in. Without a model all of that is in units
of the largest torque so far, see ``step.grown_unit``; a model states it in newton metres.
"""

import math
from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np

from adaptive_ff.adaptive.tuning import Tuning
from adaptive_ff.friction.columns import COULOMB, INERTIA, PATHS, STICTION, VISCOUS, Hypothesis, column_count
from adaptive_ff.friction.model import FURTHER, GRAVITY, RIPPLE, WITH_GRAVITY, TorqueModel
from adaptive_ff.learning.kalman import Prior
from controllers.arrays import NDArray, packed, unpacked
from controllers.checks import check_numbers, checked_array

Array = NDArray[np.float64]

ASYMMETRY = ("stiction_asymmetry", "viscous_asymmetry")
"""Estimates of what differs by direction."""

FOUND = ("stribeck_velocity", "presliding")
"""Estimates that every controller has beside the parameters that it is asked for."""

LARGEST_COEFFICIENT = 2.0
"""Largest number of a first map of friction over position, as a fraction of friction."""


def wave_place(hypothesis: Hypothesis) -> int:
    """Return the place of the first column over position."""
    return PATHS + hypothesis.distances.size + 2 * int(hypothesis.directions)


def map_place(hypothesis: Hypothesis) -> int:
    """Return the place of the first column of the map of friction over position."""
    return wave_place(hypothesis) + 2 * hypothesis.waves.size


def split_over_paths(distances: Array, presliding: float) -> Array:
    """Return the fractions of Coulomb friction in the columns slip and paths, for a mean path (rad)."""
    path = np.concatenate([[0.0], distances])
    fractions = np.zeros(path.size)
    above = min(int(np.searchsorted(path, presliding)), path.size - 1)
    if above == 0 or presliding >= path[above]:
        fractions[above] = 1.0
    else:
        fractions[above] = (presliding - path[above - 1]) / (path[above] - path[above - 1])
        fractions[above - 1] = 1.0 - fractions[above]
    return fractions


def friction_covariance(fractions: Array, total: float, spread: float, excess: float) -> Array:
    """Return the covariance of slip, stiction and paths.

    Parameters
    ----------
    fractions : ndarray, shape (1 + d,)
        How the total splits over slip and paths.
    total, spread, excess : float
        Standard deviations of the total, of the parts at a given total, and of stiction beyond Coulomb friction.
    """
    parts = total**2 * np.outer(fractions, fractions) + spread**2 * (np.eye(fractions.size) - 1.0 / fractions.size)
    order = np.concatenate([[0, 0], np.arange(1, fractions.size)])
    covariance: Array = parts[np.ix_(order, order)]
    covariance[1, 1] += excess**2
    return covariance


def default_prior(
    hypothesis: Hypothesis, tuning: Tuning, proportional: float, inertia: float, stribeck_velocity: float
) -> Prior:
    """Return the prior of a joint of which no more is known than the inertia (kg m^2) and the Stribeck velocity.

    Parameters
    ----------
    hypothesis, tuning : Hypothesis, Tuning
        Columns and constants.
    proportional : float
        Gain of the feedback, N m s/rad.
    inertia, stribeck_velocity : float
        Assumed inertia, kg m^2, and Stribeck velocity, rad/s.
    """
    count, response = column_count(hypothesis), inertia / proportional
    scaled = np.ones(count, dtype=bool)
    mean, deviation = np.zeros(count), np.ones(count)
    lowest, highest = np.full(count, -math.inf), np.full(count, math.inf)
    paths = hypothesis.distances.size
    mean[INERTIA], deviation[INERTIA] = inertia, tuning.inertia_deviation * inertia
    lowest[INERTIA], highest[INERTIA] = inertia / tuning.largest_ratio, inertia * tuning.largest_ratio
    deviation[VISCOUS] = tuning.viscous_deviation * proportional
    lowest[VISCOUS : PATHS + paths] = 0.0
    scaled[[INERTIA, VISCOUS, -2, -1]] = False
    if hypothesis.directions:
        deviation[PATHS + paths], deviation[PATHS + paths + 1] = tuning.asymmetry, tuning.asymmetry * deviation[VISCOUS]
        scaled[PATHS + paths + 1] = False
    place = wave_place(hypothesis)
    deviation[place : place + 2 * hypothesis.waves.size] = tuning.load
    mean[-2] = math.log(max(tuning.shortest_lag, min(response, tuning.longest_guess)))
    deviation[-2], lowest[-2], highest[-2] = (
        tuning.lag_deviation,
        math.log(tuning.shortest_lag),
        math.log(tuning.longest_lag),
    )
    mean[-1], deviation[-1] = math.log(stribeck_velocity), tuning.velocity_deviation
    reach = math.log(tuning.largest_ratio)
    lowest[-1], highest[-1] = mean[-1] - reach, mean[-1] + reach
    covariance = np.diag(deviation**2)
    places = np.arange(COULOMB, PATHS + paths)
    fractions = np.full(1 + paths, (1.0 - tuning.slip_fraction) / paths)
    fractions[0] = tuning.slip_fraction
    covariance[np.ix_(places, places)] = friction_covariance(fractions, 1.0, tuning.spread, tuning.excess)
    return Prior(mean, packed(covariance), scaled, lowest, highest)


def column_of(hypothesis: Hypothesis, names: Sequence[str], name: str) -> int:
    """Return the place of the column whose coefficient is the estimate of a name; -1 where it is none by itself."""
    waves = wave_place(hypothesis)
    if name in ("inertia", "viscous"):
        return INERTIA if name == "inertia" else VISCOUS
    if name in ASYMMETRY:
        return PATHS + hypothesis.distances.size + ASYMMETRY.index(name)
    if name in GRAVITY:
        return waves + GRAVITY.index(name)
    if name.startswith(RIPPLE):
        part, number = int(name.startswith(RIPPLE[1])), int(name.rsplit("_", 1)[1])
        return waves + 2 * int(GRAVITY[0] in names) + 2 * (number - 1) + part
    if name.startswith(FURTHER):
        return column_count(hypothesis) - 3 - hypothesis.regressors + int(name.rsplit("_", 1)[1])
    return -1


def model_prior(
    prior: Prior,
    hypothesis: Hypothesis,
    tuning: Tuning,
    names: Sequence[str],
    model: TorqueModel | Mapping[str, float],
    deviation: float | Mapping[str, float],
    unit: float,
) -> Prior:
    """Return a prior with what a model of the joint says.

    Parameters
    ----------
    prior : Prior
        What holds without the model.
    hypothesis, tuning : Hypothesis, Tuning
        Columns and constants.
    names : sequence of str
        The estimates.
    model : TorqueModel or mapping
        The joint, from a data sheet, an identification or the ``estimates`` of another controller. Of a mapping what
        this controller does not identify is passed over, and what it lacks but for the inertia and the lag is zero.
    deviation : float or mapping
        How sure it is: standard deviation as a fraction of each value, or for each name in its unit. What is zero, or
        not named, is as uncertain as its unit.
    unit : float
        Unit of torque, N m.

    Raises
    ------
    ValueError
        A value is missing, not finite or not possible, a name is not one of the estimates, or a deviation is not
        positive and finite.
    TypeError
        The model is none, or a value no number.
    """
    known = checked_values(prior, names, model)
    mean, covariance, scaled = prior.mean.copy(), unpacked(prior.covariance), prior.scaled.copy()
    units = {"friction_lag": 1.0, "offset": unit, "coulomb": unit, "stiction": unit} | {
        name: math.sqrt(covariance[place, place]) * (unit if prior.scaled[place] else 1.0)
        for name in names
        if (place := column_of(hypothesis, names, name)) >= 0
    }
    spread = checked_deviations(names, known, deviation, units)
    for name in names:
        place = column_of(hypothesis, names, name)
        if place >= 0:
            mean[place], scaled[place] = known[name], False
            covariance[place, place] = max(spread[name], tuning.least_deviation * units[name]) ** 2
    paths = hypothesis.distances.size
    places = np.arange(COULOMB, PATHS + paths)
    fractions = split_over_paths(hypothesis.distances, known["presliding"])
    coulomb, stiction = known["coulomb"], known["stiction"]
    mean[COULOMB], mean[PATHS : PATHS + paths] = coulomb * fractions[0], coulomb * fractions[1:]
    mean[STICTION] = max(stiction - coulomb * (1.0 - fractions[0]), 0.0)
    scaled[places] = False
    deviations = [max(spread[name], tuning.least_deviation * unit) for name in ("coulomb", "stiction")]
    covariance[np.ix_(places, places)] = friction_covariance(
        fractions, deviations[0], tuning.spread * max(coulomb, deviations[0]), deviations[1]
    )
    lag, least = known["friction_lag"], math.exp(prior.lowest[-2])
    mean[-2] = math.log(max(lag, least))
    relative = min(tuning.lag_deviation, spread["friction_lag"] / max(lag, least))
    covariance[-2, -2] = max(tuning.least_deviation, relative) ** 2
    if known["stribeck_velocity"] > 0.0:
        mean[-1] = min(max(math.log(known["stribeck_velocity"]), prior.lowest[-1]), prior.highest[-1])
    return Prior(mean, packed(covariance), scaled, prior.lowest, prior.highest)


def checked_values(prior: Prior, names: Sequence[str], model: TorqueModel | Mapping[str, float]) -> dict[str, float]:
    """Return the values of a model by name, zero where it says nothing; refuse what is not possible."""
    given = model._asdict() if isinstance(model, TorqueModel) else _by_name(model)
    possible = {*names, *TorqueModel._fields, *WITH_GRAVITY, *FOUND}
    unknown = [name for name in given if name not in possible and not name.startswith((FURTHER, *RIPPLE))]
    if unknown:
        raise ValueError(f"model.{min(unknown)} is not known: it must be one of {', '.join(sorted(possible))}")
    values = {}
    for name in (*names, *FOUND):
        if name not in given and name in ("inertia", "friction_lag"):
            raise ValueError(f"model has no {name}: it must have inertia and friction_lag at least")
        value = given.get(name, 0.0)
        check_numbers(**{f"model.{name}": value})
        least, most = _possible(prior, name)
        if not (math.isfinite(value) and least <= value <= most):
            raise ValueError(
                f"model.{name} = {value:g} is not allowed: it must be finite and from {least:g} to {most:g}"
            )
        values[name] = float(value)
    return values


def _possible(prior: Prior, name: str) -> tuple[float, float]:
    if name == "inertia":
        return float(prior.lowest[INERTIA]), float(prior.highest[INERTIA])
    if name == "friction_lag":
        return 0.0, math.exp(prior.highest[-2])
    signed = (*ASYMMETRY, "offset", *GRAVITY)
    return (-math.inf if name in signed or name.startswith((FURTHER, *RIPPLE)) else 0.0), math.inf


def _by_name(model: Any) -> dict[str, float]:
    """Return a mapping as a dict; raise ``TypeError`` for what is none."""
    try:
        known = dict(model)
    except (TypeError, ValueError):
        known = None
    if known is None or not all(isinstance(name, str) for name in known):
        raise TypeError(f"model = {model!r} is not allowed: it must be a TorqueModel, or values by name")
    return known


def checked_deviations(
    names: Sequence[str], known: Mapping[str, float], deviation: float | Mapping[str, float], units: Mapping[str, float]
) -> dict[str, float]:
    """Return the standard deviation of each value of a model; ``units`` hold where nothing is said."""
    if isinstance(deviation, Mapping):
        unknown = set(deviation) - {*names, *FOUND}
        if unknown:
            raise ValueError(f"deviation.{min(unknown)} is not allowed: it must be one of {', '.join(names)}")
        given = {f"deviation.{name}": value for name, value in deviation.items() if name not in (*FOUND, "offset")}
    else:
        given = {"deviation": deviation}
    check_numbers(**given)
    for where, value in given.items():
        if not (math.isfinite(value) and value > 0.0):
            raise ValueError(f"{where} = {value} is not allowed: it must be positive and finite")
    if isinstance(deviation, Mapping):
        return {name: float(deviation.get(name, unit)) for name, unit in units.items()}
    return {name: float(deviation) * abs(known.get(name, 0.0)) or unit for name, unit in units.items()}


def with_map(
    prior: Prior,
    hypothesis: Hypothesis,
    tuning: Tuning,
    coefficients: Sequence[float] | None,
    deviation: float | Sequence[float],
    coulomb: float,
) -> Prior:
    """Return a prior with a first map of friction over position.

    Parameters
    ----------
    prior, hypothesis, tuning : Prior, Hypothesis, Tuning
        Prior without it, columns and constants.
    coefficients : sequence of float or None
        Cosine and sine of each period, then the hats; fractions of the friction.
    deviation : float or sequence of float
        Standard deviation of all of them, or of each; infinite where nothing is known.
    coulomb : float
        Coulomb friction of the model, N m; zero without one.

    Raises
    ------
    ValueError
        The map is not allowed.
    """
    waves, count = hypothesis.map_waves.size, 2 * hypothesis.map_waves.size + hypothesis.hats
    spread = _checked_spread(deviation, np.size(deviation) if coefficients is None else count)
    if coefficients is None:
        return prior
    if count == 0:
        raise ValueError("position_map is not allowed without position_periods or position_hats")
    if not coulomb > 0.0:
        raise ValueError(
            "position_map is not allowed without a model that has Coulomb friction: its numbers are fractions of that"
        )
    known = _numbers("position_map", coefficients, count)
    for place, value in enumerate(known.tolist()):
        if not abs(value) <= LARGEST_COEFFICIENT:
            raise ValueError(
                f"position_map[{place}] = {value:g} is not allowed: it must be from {-LARGEST_COEFFICIENT:g} to "
                f"{LARGEST_COEFFICIENT:g}"
            )
    order = np.arange(count)
    order[: 2 * waves] = order[: 2 * waves].reshape(-1, 2)[:, ::-1].ravel()  # columns have the sine first
    places = (map_place(hypothesis) + order)[np.isfinite(spread)]
    mean, covariance, scaled = prior.mean.copy(), unpacked(prior.covariance), prior.scaled.copy()
    mean[places], scaled[places] = coulomb * known[np.isfinite(spread)], False
    squares = (coulomb * np.maximum(spread[np.isfinite(spread)], tuning.least_deviation)) ** 2
    covariance[places, places] = squares
    return Prior(mean, packed(covariance), scaled, prior.lowest, prior.highest)


def _checked_spread(deviation: float | Sequence[float], count: int) -> Array:
    one_for_all = np.ndim(deviation) == 0
    spread = _numbers("map_deviation", [deviation] * count if one_for_all else deviation, count)
    for place, value in enumerate(spread.tolist()):
        if not value >= 0.0:
            where = "map_deviation" if one_for_all else f"map_deviation[{place}]"
            raise ValueError(
                f"{where} = {value:g} is not allowed: it must be zero or more, or inf for what is not known"
            )
    return spread


def _numbers(name: str, values: object, count: int) -> Array:
    try:
        array = checked_array(name, values)
    except TypeError as error:
        raise ValueError(f"{name} = {values!r} is not allowed: it must be {count} numbers") from error
    if array.shape != (count,):
        raise ValueError(
            f"{name} has shape {array.shape}; it must be ({count},): cosine and sine of each of position_periods, then "
            "position_hats"
        )
    return array
