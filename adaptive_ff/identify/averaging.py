"""Intervals that repetition would show: the spread over folds, and the textbook's parameters averaged over models."""

import math
from typing import NamedTuple

import numpy as np

from adaptive_ff.identify.columns import CARRIED, Shape, is_friction
from adaptive_ff.identify.motion import Array
from adaptive_ff.identify.preparation import Prepared
from adaptive_ff.identify.regression import Fit, Folds, Model, Parameter, bounded, quantile, solve, spread

SLOPE = "slope of "
"""Name of the column by which a shape is refined."""


class Estimated(NamedTuple):
    """A model with its estimates, those of the logarithms of its shape's numbers after them, and their covariance.

    ``narrowed`` is the variance by the choice of the band: what half of it changes, taken as uniform up to that.
    """

    model: Model
    errors: Array
    slopes: tuple[str, ...]
    values: Array
    covariance: Array
    narrowed: Array


def estimated(data: Prepared, narrower: Prepared | None, model: Model, errors: Array) -> Estimated:
    """Return a model with its estimates and their covariance.

    To the spread over folds comes what half a sample of the torque's time would change, as far as the rows leave it
    open.
    """
    slopes = _slopes(data, model, data.fit(model).solve())
    late = () if "torque_delay" in model.names else ("torque_delay",)
    columns = np.column_stack([data.columns((*model.names, *late), model.shape), *slopes.values()])
    inner = (*model.names, *slopes)
    folds = data.sums((*model.names, *late, *slopes), columns).of((*inner, *late))
    own = folds.of(inner)
    bent = tuple(name.removeprefix(SLOPE) for name in slopes)
    values = np.append(folds.of(model.names).solve(), [math.log(getattr(model.shape, name)) for name in bent])
    moved = np.zeros(values.size)
    if narrower is not None:
        narrow = narrower.fit(model).solve()
        moved[: narrow.size] = narrow - values[: narrow.size]
    return Estimated(model, errors, bent, values, spread(own) + _timing(data, folds, own), moved**2 / 3.0)


def with_intervals(data: Prepared, one: Estimated, confidence: float) -> Fit:
    """Return a model with the intervals of its estimates, those of its shape of their logarithms."""
    names, size = one.model.names, len(one.model.names)
    half = quantile(one.errors.size, confidence) * np.sqrt(np.diag(one.covariance) + one.narrowed)
    found = _fit(data, one, names, one.values[:size], half[:size])
    for name, value, error in zip(one.slopes, np.exp(one.values[size:]).tolist(), half[size:], strict=True):
        factor = math.exp(min(float(error), 20.0))
        found.parameters[name] = Parameter(value, value / factor, value * factor)
    return found


def averaged(data: Prepared, models: list[Estimated], confidence: float) -> Fit:
    """Return the textbook's model, the first, with its parameters averaged over models (J. Hoeting 1999).

    Each model counts by how it validates. Coulomb and viscous friction and offset of a richer one are those of the line
    through its friction without lag, path, load and delay.
    """
    best = min((one.errors for one in models), key=lambda errors: float(np.mean(errors)))
    weights = np.array([_weight(one.errors, best) for one in models])
    weights /= weights.sum()
    names = models[0].model.names
    maps = [_textbook_of(data, names, one) for one in models]
    each = np.array(
        [
            bounded(names, own[:, : len(one.model.names)] @ one.values[: len(one.model.names)])
            for own, one in zip(maps, models, strict=True)
        ]
    )
    mean = weights @ each
    within = np.array([np.diag(own @ one.covariance @ own.T) for own, one in zip(maps, models, strict=True)])
    half = quantile(best.size, confidence) * np.sqrt(models[0].narrowed + weights @ (within + (each - mean) ** 2))
    return _fit(data, models[0], names, mean, half)


def _fit(data: Prepared, one: Estimated, names: tuple[str, ...], values: Array, half: Array) -> Fit:
    ends = [bounded(names, end).tolist() for end in (values, values - half)]
    parameters = map(Parameter, *ends, (values + half).tolist())
    left = math.sqrt(float(np.mean(one.errors)) / float(np.mean(data.torque**2)))
    return Fit(one.model, dict(zip(names, parameters, strict=True)), left)


def _textbook_of(data: Prepared, names: tuple[str, ...], one: Estimated) -> Array:
    """Return the matrix that makes the textbook's parameters of the estimates of a model.

    Its line of Coulomb and viscous friction is the one through the friction of the model without lag, path, load and
    delay; its offset is the mean of what that leaves, and of the loads.
    """
    inner, shape = one.model
    result = np.array([[float(own == name) for own in (*inner, *one.slopes)] for name in names])
    if inner == names and shape == Shape():
        return result
    apart = {"torque_delay", "load_friction", *CARRIED}
    slow = [place for place, name in enumerate(inner) if name not in apart]
    static = Model(tuple(inner[place] for place in slow), shape._replace(friction_lag=0.0, path=0.0))
    bends = _slopes(data, static, one.values[slow])
    torques = np.column_stack([data.columns(*static), *bends.values()])
    places = np.array([*slow, *(len(inner) + one.slopes.index(name.removeprefix(SLOPE)) for name in bends)])
    friction = np.array([is_friction(name) for name in static.names] + [True] * len(bends))
    line = [place for place, name in enumerate(names) if is_friction(name)]
    if line:
        columns = data.columns(tuple(names[place] for place in line), Shape())
        fitted = np.linalg.lstsq(columns, torques[:, friction])[0]
        result[np.ix_(line, places[friction])] = fitted
        torques[:, friction] -= columns @ fitted
    if "offset" in names:
        result[names.index("offset"), places] = torques.mean(axis=0)
    return result


def _slopes(data: Prepared, model: Model, values: Array) -> dict[str, Array]:
    """Return the derivative of the torque by the logarithm of each number of the shape."""
    found = {}
    for name, value in model.shape.bends.items():
        up, down = (
            data.columns(model.names, model.shape.bent(name, value * factor)) @ values for factor in (1.05, 1.0 / 1.05)
        )
        found[SLOPE + name] = (up - down) / (2.0 * math.log(1.05))
    return found


def _timing(data: Prepared, folds: Folds, own: Folds) -> Array:
    """Return the covariance by the time of the torque, known to half a sample before the rows were measured."""
    if data.delay_known or "torque_delay" in own.names:
        return np.zeros((len(own.names), len(own.names)))
    prior = data.period**2 / 12.0
    free = folds.solve(bounded=False)
    delay, error = float(free[-1]), math.sqrt(spread(folds)[-1, -1])
    certain = 1.0 / (1.0 / prior + 1.0 / max(error, 1e-12) ** 2)
    mean = min(abs(delay) * certain / max(error, 1e-12) ** 2, data.period)
    gram, cross = own.clean.sum(axis=0), folds.gram.sum(axis=0)[: len(own.names), -1]
    alias = solve(gram, cross, own.names, bounded=False)
    return np.asarray(np.outer(alias, alias) * (certain + mean**2))


def _weight(errors: Array, best: Array) -> float:
    """Return the weight of a model by how many standard errors it validates worse than the best."""
    apart = errors - best
    spread = float(np.std(apart, ddof=1)) / math.sqrt(apart.size)
    return math.exp(-0.5 * (float(np.mean(apart)) / spread) ** 2) if spread > 0.0 else 1.0
