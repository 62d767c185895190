"""Which model a log shows: the textbook's first, refined only where what was left out of the fit says so.

Intervals are those that repetition would show: the spread over folds. The textbook's parameters are averaged over the
models that were tried.
"""

import math
from collections.abc import Iterator
from typing import NamedTuple

import numpy as np

from adaptive_ff.identify.columns import ASYMMETRY, CARRIED, GRAVITY, Shape, is_friction
from adaptive_ff.identify.motion import TUNING, Array
from adaptive_ff.identify.preparation import Prepared, narrowed
from adaptive_ff.identify.regression import Fit, Model, Parameter, left_out_errors, lowest, quantile, remainder, spread


def is_better(old: Array, new: Array, errors: float, gain: float) -> bool:
    """Tell whether mean square errors of folds fall by standard errors, and by a fraction of the rms residual."""
    fall = old - new
    spread = float(np.std(fall, ddof=1)) / math.sqrt(fall.size)
    less = np.mean(new) < (1.0 - gain) ** 2 * np.mean(old)
    return bool(less) and float(np.mean(fall)) > errors * spread


def refinements(data: Prepared, model: Model) -> Iterator[tuple[str, Model]]:
    """Yield models that have one thing more, each with what that is."""
    names, shape = model
    band, fast = data.band, data.fast
    if "coulomb" in names and not (shape.friction_lag or shape.path):
        for cycles in TUNING.lags:
            yield "lag", Model(names, shape._replace(friction_lag=cycles / band))
        for seconds in TUNING.paths:
            yield "path", Model(names, shape._replace(path=seconds * fast))
    if "coulomb" in names and not shape.stribeck_velocity:
        for fraction in TUNING.speeds:
            yield "stribeck", Model((*names, "stiction_excess"), shape._replace(stribeck_velocity=fraction * fast))
    if "coulomb" in names and "load_friction" not in names:
        yield "load", Model((*names, "load_friction"), shape._replace(load=data.load))
    maps = {kind: tuple(f"{kind}_{name}" for name in data.place.names) for kind in ("friction", "force")}
    linear = {"force over position": maps["force"], "delay": () if data.delay_known else ("torque_delay",)}
    if "coulomb" in names:
        linear |= {"directions": (ASYMMETRY,), "friction over position": maps["friction"]}
    for kind, further in linear.items():
        if further and not set(further) <= set(names):
            yield kind, Model((*names, *further), shape)


def tried(data: Prepared, model: Model) -> dict[str, tuple[Model, Array]]:
    """Return the best model of each kind of refinement, with the errors of its folds."""
    best: dict[str, tuple[Model, Array]] = {}
    for kind, one in refinements(data, model):
        errors = left_out_errors(data.fit(one))
        if kind not in best or np.mean(errors) < np.mean(best[kind][1]):
            best[kind] = one, errors
    return best


def select(
    data: Prepared, terms: tuple[str, ...], weight: bool | None, confidence: float, *, refine: bool
) -> tuple[Fit, Fit | None, tuple[str, ...], dict[str, str]]:
    """Select a model from the textbook's terms, for intervals of some probability.

    ``weight`` says whether gravity takes torque (None: the rows are to tell), ``refine`` whether refinements may be
    taken. Returns the textbook's model, that with refinements, these, and what is not identifiable with why.
    """
    model, lacking = _identifiable(data, terms)
    errors = left_out_errors(data.fit(model))
    if data.rotary:
        heavy = Model((*model.names, *GRAVITY))
        folds = data.fit(heavy)
        with_weight = left_out_errors(folds)
        if weight or (weight is None and is_better(errors, with_weight, *TUNING.weight)):
            model, errors = heavy, with_weight
        elif folds.tolerance().get("inertia", 1.0) < TUNING.collinear:  # a spring and inertia are one number
            lacking["inertia"] = "one_sine"
    if not data.has_known:
        found = dict(zip(model.names, data.fit(model).solve().tolist(), strict=True))
        data = data._replace(load=tuple(found.get(name, 0.0) for name in CARRIED))
    around = tried(data, model) if refine else {}
    models = [(model, errors), *around.values()]
    taken: list[str] = []
    while around:
        kind, (better, new) = min(around.items(), key=lambda item: float(np.mean(item[1][1])))
        if not is_better(errors, new, *TUNING.refinement):
            break
        taken.append(kind)
        model, errors = better, new
        around = tried(data, model)
    estimates = [estimated(data, *one) for one in models]
    narrower, refined = narrowed(data), None
    if taken:
        best = estimated(data, model, errors)
        for _ in range(TUNING.steps if best.steps.size else 0):
            best = estimated(data, best.moved(), errors)
        estimates.append(best)
        refined = with_intervals(data, narrower, best, confidence)
    return averaged(data, narrower, estimates, confidence), refined, tuple(taken), lacking


def _identifiable(data: Prepared, terms: tuple[str, ...]) -> tuple[Model, dict[str, str]]:
    """Return the textbook's model of the terms that the motion tells apart, and the reasons of the others."""
    folds, names, lacking = data.fit(Model(terms)), list(terms), {}
    quiet = 1.0 - data.noise["inertia"] * folds.rows.sum() / max(float(folds.gram.sum(axis=0)[0, 0]), 1e-300)
    reasons = {"viscous": "one_speed", "inertia": "no_acceleration"}
    if "offset" in names:  # one way: friction and load are one constant
        reasons = {"coulomb": "one_way", **reasons}
    for name, reason in reasons.items():
        own = data.fit(Model(tuple(names))).tolerance()[name]
        if min(own, max(0.0, quiet) ** 4 if name == "inertia" else 1.0) < TUNING.collinear:
            names.remove(name)
            lacking[name] = reason
    return Model(tuple(names)), lacking


class Estimated(NamedTuple):
    """A model with its estimates, and the covariance of these and of the logarithms of its shape's numbers.

    ``steps`` are those of Gauss and Newton of these logarithms.
    """

    model: Model
    errors: Array
    values: Array
    covariance: Array
    steps: Array

    def moved(self) -> Model:
        """Return the model with its shape a Gauss-Newton step further."""
        shape = self.model.shape
        factors = np.exp(np.clip(self.steps, -TUNING.near, TUNING.near)).tolist()
        moved = {name: one * factor for (name, one), factor in zip(shape.bends.items(), factors, strict=True)}
        return self.model._replace(shape=shape._replace(**moved))


def estimated(data: Prepared, model: Model, errors: Array) -> Estimated:
    """Return a model with its estimates and their covariance, which is their spread over folds."""
    columns = data.columns(*model)
    values = data.sums(model.names, columns).solve()
    slopes = _slopes(data, model, values)
    folds = data.sums((*model.names, *slopes), np.column_stack([columns, *slopes.values()]))
    return Estimated(model, errors, values, spread(folds), folds.solve()[values.size :])


def by_band(narrower: Prepared | None, one: Estimated) -> Array:
    """Return the standard error by the band, whose bias is taken as ``c / band``: half of it changes an estimate by it.

    That is the error estimate of L. F. Richardson (Phil. Trans. R. Soc. A 210, 1911), of first order, with the factor
    of safety of P. J. Roache (J. Fluids Eng. 116, 1994).
    """
    changed = one.values if narrower is None else narrower.fit(one.model).solve()
    return np.asarray(TUNING.safety * (changed - one.values))


def with_intervals(data: Prepared, narrower: Prepared | None, one: Estimated, confidence: float) -> Fit:
    """Return a model with the intervals of its estimates, those of its shape of their logarithms."""
    variance, size = np.diag(one.covariance).copy(), one.values.size
    variance[:size] += by_band(narrower, one) ** 2
    half = quantile(one.errors.size, confidence) * np.sqrt(variance)
    found = _fit(data, one, one.model.names, one.values, half[:size])
    for (name, value), error in zip(one.model.shape.bends.items(), half[size:].tolist(), strict=True):
        factor = math.exp(min(error, 20.0))
        found.parameters[name] = Parameter(value, value / factor, value * factor)
    return found


def averaged(data: Prepared, narrower: Prepared | None, models: list[Estimated], confidence: float) -> Fit:
    """Return the textbook's model, the first, with its parameters averaged over models (S. Buckland 1997).

    Akaike's weights ``(mean square error)^(-n / 2)`` are of the errors of folds that were left out, each of which
    counts as the two ways of a cycle. Coulomb and viscous friction and offset of a richer model are those of the line
    through its friction without lag, path, load and delay. The variance is that of the models, what the band changes in
    each among it, and of what they differ by.
    """
    textbook, names = models[0], models[0].model.names
    square = np.array([np.mean(one.errors) for one in models])
    weights = (square / square.min()) ** -float(textbook.errors.size)
    weights /= weights.sum()
    maps = [(_textbook_of(data, names, one), one) for one in models]
    each = np.array([np.maximum(lowest(names), own[:, : one.values.size] @ one.values) for own, one in maps])
    within = np.array([np.diag(own @ one.covariance @ own.T) for own, one in maps])
    biases = np.array([own[:, : one.values.size] @ by_band(narrower, one) for own, one in maps])
    mean = weights @ each
    variance = weights @ (within + biases**2 + (each - mean) ** 2)
    return _fit(data, textbook, names, mean, quantile(textbook.errors.size, confidence) * np.sqrt(variance))


def _fit(data: Prepared, one: Estimated, names: tuple[str, ...], values: Array, half: Array) -> Fit:
    ends = np.maximum(lowest(names), [values, values - half]).tolist()
    parameters = map(Parameter, *ends, (values + half).tolist())
    left = remainder(one.errors, data.torque, one.model.names)
    return Fit(one.model, dict(zip(names, parameters, strict=True)), left)


def _textbook_of(data: Prepared, names: tuple[str, ...], one: Estimated) -> Array:
    """Return the matrix that makes the textbook's parameters of the estimates of a model.

    Its line of Coulomb and viscous friction is the one through the friction of the model without lag, path, load and
    delay; its offset is the mean of what that leaves, and of the loads.
    """
    inner, shape = one.model
    result = np.array([[float(own == name) for own in (*inner, *shape.bends)] for name in names])
    apart = {"torque_delay", "load_friction", *CARRIED}
    slow = [place for place, name in enumerate(inner) if name not in apart]
    static = Model(tuple(inner[place] for place in slow), shape._replace(friction_lag=0.0, path=0.0, load=()))
    if static.shape == Shape() and set(static.names) <= set(names):
        return result
    bends = _slopes(data, static, one.values[slow])
    torques = np.column_stack([data.columns(*static), *bends.values()])
    places = np.array([*slow, *(len(inner) + list(shape.bends).index(name) for name in bends)])
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
        shapes = (Shape(**model.shape._asdict() | {name: value * factor}) for factor in (1.05, 1.0 / 1.05))
        up, down = (data.columns(model.names, shape) @ values for shape in shapes)
        found[name] = (up - down) / (2.0 * math.log(1.05))
    return found
