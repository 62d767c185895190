"""Which model a log shows: the textbook's first, refined only where what was left out of the fit says so."""

import math
from collections.abc import Iterator
from typing import NamedTuple

import numpy as np
from scipy import optimize

from adaptive_ff.identify.columns import DRY, GRAVITY, VISCOUS, Map, Shape, unit_torques
from adaptive_ff.identify.motion import Array
from adaptive_ff.identify.preparation import Prepared
from adaptive_ff.identify.regression import (
    Folds,
    bounded,
    left_out_errors,
    quantile,
    solve,
    spread,
    sums,
)


class Rule(NamedTuple):
    """When further terms are taken.

    The standard errors over the folds by which the mean square error must fall, and the fraction of the rms residual
    that must go.
    """

    errors: float
    gain: float


REFINEMENT, WEIGHT = Rule(1.5, 0.1), Rule(0.7, 0.03)
"""For refinements, and for gravity, which most rotary joints have."""

DIFFERENT = Rule(1.5, 0.0)
"""For models that only count in the intervals."""

LAGS = (0.02, 0.04, 0.08, 0.16, 0.3, 0.6)
"""Friction lags that are tried, in cycles of the band."""

PATHS = (0.002, 0.008, 0.03)
"""Paths that are tried, over the way in a second at the usual speed."""

SPEEDS = (0.02, 0.04, 0.08, 0.15, 0.3)
"""Stribeck velocities that are tried, over the usual speed."""

NEAR = 0.4
"""Logarithm of the factor within which a shape is looked for around the best tried one."""

SLOPE = "slope of "
"""Name of the column by which a shape is refined."""


class Model(NamedTuple):
    """Terms of a model, and the shape of their columns."""

    names: tuple[str, ...]
    shape: Shape = Shape()


class Parameter(NamedTuple):
    """A parameter with its interval."""

    value: float
    lower: float
    upper: float

    @property
    def half_width(self) -> float:
        """Half width of the interval over the value."""
        return 0.5 * (self.upper - self.lower) / abs(self.value) if self.value else math.inf


class Fit(NamedTuple):
    """A fitted model with its parameters, and what it leaves of folds that were left out of the fit, rms over rms."""

    model: Model
    parameters: dict[str, Parameter]
    left: float

    @property
    def values(self) -> dict[str, float]:
        """Estimates by name."""
        return {name: one.value for name, one in self.parameters.items()}


class Selection(NamedTuple):
    """The textbook's model, that with the refinements that were taken, and what each textbook column has of its own.

    The tolerance is the fraction of a column that the others do not explain, gravity's among them on a rotary axis.
    """

    textbook: Fit
    refined: Fit | None
    taken: tuple[str, ...]
    tolerance: dict[str, float]


class Data(NamedTuple):
    """All sliding rows of a log, and what may be asked of them."""

    prepared: Prepared
    place: Map
    rotary: bool
    narrower: Prepared | None = None

    def columns(self, names: tuple[str, ...], shape: Shape) -> Array:
        """Return columns of all segments."""
        return np.concatenate([unit_torques(rows, names, shape, self.place) for rows in self.prepared.rows])

    def modelled(self, fit: "Fit") -> Array:
        """Return the torque of a model in the band at the rows."""
        return np.asarray(self.columns(*fit.model) @ [fit.values[name] for name in fit.model.names])

    def sums(self, names: tuple[str, ...], columns: Array) -> Folds:
        """Return the sums of some columns by fold."""
        return sums(names, columns, self.prepared.torque, self.prepared.fold, self.prepared.noise)

    def fit(self, model: Model) -> Folds:
        """Return the sums of a model."""
        return self.sums(model.names, self.columns(*model))


def is_better(old: Array, new: Array, rule: Rule) -> bool:
    """Tell whether errors of folds fall by what a rule asks for."""
    fall = old - new
    spread = float(np.std(fall, ddof=1)) / math.sqrt(fall.size)
    return float(np.mean(fall)) > rule.errors * spread and np.mean(new) < (1.0 - rule.gain) ** 2 * np.mean(old)


def refinements(data: Data, model: Model) -> Iterator[tuple[str, Model]]:
    """Yield models that have one thing more, each with what that is."""
    names, shape = model
    band, fast = data.prepared.band, data.prepared.fast
    if "coulomb" in names and not (shape.friction_lag or shape.path):
        for cycles in LAGS:
            yield "lag", Model(names, shape._replace(friction_lag=cycles / band))
        for seconds in PATHS:
            yield "path", Model(names, shape._replace(path=seconds * fast))
    if "coulomb" in names and not shape.stribeck_velocity:
        for fraction in SPEEDS:
            yield "stribeck", Model((*names, "stiction_excess"), shape._replace(stribeck_velocity=fraction * fast))
    for kind, further in _linear(data, model):
        if further and not set(further) <= set(names):
            yield kind, Model((*names, *further), shape)


def _linear(data: Data, model: Model) -> Iterator[tuple[str, tuple[str, ...]]]:
    """Yield terms that need no shape."""
    if "coulomb" in model.names:
        yield "directions", ("viscous_asymmetry",)
        yield "friction over position", tuple(f"friction_{name}" for name in data.place.names)
    if not data.prepared.delay_known:
        yield "delay", ("torque_delay",)
    if data.prepared.has_known:
        yield "load", ("load_friction",)
    yield "force over position", tuple(f"force_{name}" for name in data.place.names)


def tried(data: Data, model: Model) -> dict[str, tuple[Model, Array]]:
    """Return the best model of each kind of refinement, with the errors of its folds."""
    cache = dict(zip([(name, model.shape) for name in model.names], data.columns(*model).T, strict=True))
    best: dict[str, tuple[Model, Array]] = {}
    for kind, one in refinements(data, model):
        keys = [(name, one.shape if _is_friction(name) else model.shape) for name in one.names]
        for name, shape in keys:
            if (name, shape) not in cache:
                cache[name, shape] = data.columns((name,), shape)[:, 0]
        errors = left_out_errors(data.sums(one.names, np.column_stack([cache[key] for key in keys])))
        if kind not in best or np.mean(errors) < np.mean(best[kind][1]):
            best[kind] = one, errors
    return best


def select(data: Data, terms: tuple[str, ...], confidence: float, *, weight: bool | None, refine: bool) -> Selection:
    """Select a model from the textbook's terms, for intervals of some probability.

    ``weight`` says whether gravity takes torque (None: the rows are to tell), ``refine`` whether refinements may be
    taken.
    """
    model, tolerance = _identifiable(data, terms)
    errors = left_out_errors(data.fit(model))
    if data.rotary and weight is not False:
        heavy = Model((*model.names, *GRAVITY))
        with_weight = left_out_errors(data.fit(heavy))
        if weight or is_better(errors, with_weight, WEIGHT):
            model, errors = heavy, with_weight
    base, base_errors, taken = model, errors, []
    before: dict[str, Array] = {}
    around = beside = tried(data, model) if refine else {}
    while refine:
        kind, (better, new) = min(around.items(), key=lambda item: float(np.mean(item[1][1])))
        if not is_better(errors, new, REFINEMENT):
            break
        taken.append(kind)
        bent = [name for name, value in better.shape._asdict().items() if value and not getattr(model.shape, name)]
        before |= dict.fromkeys(bent, errors)
        model, errors = better, new
        around = tried(data, model)
        if not around:
            break
    others = [_estimated(data, *one) for one in beside.values() if is_better(base_errors, one[1], DIFFERENT)]
    models = [_estimated(data, base, base_errors), *others]
    refined = None
    if taken:
        models.append(_estimated(data, _polished(data, model), errors))
        refined = _refined(data, models[-1], before, confidence)
    return Selection(_averaged(data, models, confidence), refined, tuple(taken), tolerance)


COLLINEAR = 1e-3
"""Fraction of a column that the others must leave for its parameter to be identifiable."""


def _identifiable(data: Data, terms: tuple[str, ...]) -> tuple[Model, dict[str, float]]:
    """Return the textbook's model of the terms that the motion tells apart, and how far it does."""
    judged = terms + (GRAVITY if data.rotary else ())
    folds = data.fit(Model(judged))
    tolerance = folds.of(terms).tolerance()
    noise = data.prepared.noise["inertia"] * folds.rows.sum()
    power = float(folds.gram.sum(axis=0)[0, 0])
    tolerance["inertia"] = min(tolerance["inertia"], max(0.0, 1.0 - noise / max(power, 1e-300)) ** 4)
    names = list(terms)
    if "coulomb" in names and tolerance["coulomb"] < COLLINEAR and "offset" in names:
        names.remove("coulomb")  # one way: friction and load are one constant
    for name in ("viscous", "inertia"):
        if min(folds.of(tuple(names)).tolerance()[name], tolerance[name] if name == "inertia" else 1.0) < COLLINEAR:
            names.remove(name)
    if data.rotary and "inertia" in names:  # one sine: a spring-like torque and inertia are one number
        tolerance["inertia_beside_gravity"] = folds.tolerance()["inertia"]
    return Model(tuple(names)), tolerance


def _polished(data: Data, model: Model) -> Model:
    """Return a model with the shape between the tried ones that leaves least."""
    for name, value in model.shape._asdict().items():
        if not value:
            continue

        def left(log_value: float, name: str = name, model: Model = model) -> float:
            one = model._replace(shape=model.shape._replace(**{name: math.exp(log_value)}))
            folds = data.fit(one)
            values = folds.solve()
            return float(values @ folds.gram.sum(axis=0) @ values - 2.0 * values @ folds.moment.sum(axis=0))

        ends = math.log(value) - NEAR, math.log(value) + NEAR
        found = optimize.minimize_scalar(left, bounds=ends, method="bounded", options={"xatol": 0.02})
        model = model._replace(shape=model.shape._replace(**{name: math.exp(found.x)}))
    return model


class _Estimated(NamedTuple):
    """A model with its estimates, those of the logarithms of its shape's numbers after them, and their covariance.

    ``narrowed`` is the variance by the choice of the band: what half of it changes, taken as uniform up to that.
    """

    model: Model
    errors: Array
    slopes: tuple[str, ...]
    values: Array
    covariance: Array
    narrowed: Array


def _estimated(data: Data, model: Model, errors: Array) -> _Estimated:
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
    if data.narrower is not None:
        narrow = data._replace(prepared=data.narrower).fit(model).solve()
        moved[: narrow.size] = narrow - values[: narrow.size]
    return _Estimated(model, errors, bent, values, spread(own) + _timing(data, folds, own), moved**2 / 3.0)


def _refined(data: Data, one: _Estimated, before: dict[str, Array], confidence: float) -> Fit:
    """Return a model with the intervals of its estimates.

    ``before`` holds the errors without each number of the shape; zero is in its interval as long as the model without
    it has some weight.
    """
    names, size = one.model.names, len(one.model.names)
    half = quantile(one.errors.size, confidence) * np.sqrt(np.diag(one.covariance) + one.narrowed)
    found = _with_intervals(data, one, names, one.values[:size], half[:size])
    for name, value, error in zip(one.slopes, np.exp(one.values[size:]).tolist(), half[size:], strict=True):
        factor = math.exp(min(float(error), 20.0))
        without = _weight(before[name], one.errors)
        low = 0.0 if without / (1.0 + without) > 0.5 * (1.0 - confidence) else value / factor
        found.parameters[name] = Parameter(value, low, value * factor)
    return found


def _averaged(data: Data, models: list[_Estimated], confidence: float) -> Fit:
    """Return the textbook's model, the first, with its parameters averaged over models (J. Hoeting 1999).

    Each model counts by how it validates. Coulomb and viscous friction and offset of a richer one are those of the line
    through its friction without lag, path and delay.
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
    return _with_intervals(data, models[0], names, mean, half)


def _with_intervals(data: Data, one: _Estimated, names: tuple[str, ...], values: Array, half: Array) -> Fit:
    ends = [bounded(names, end).tolist() for end in (values, values - half)]
    parameters = map(Parameter, *ends, (values + half).tolist())
    left = math.sqrt(float(np.mean(one.errors)) / float(np.mean(data.prepared.torque**2)))
    return Fit(one.model, dict(zip(names, parameters, strict=True)), left)


def _textbook_of(data: Data, names: tuple[str, ...], one: _Estimated) -> Array:
    """Return the matrix that makes the textbook's parameters of the estimates of a model.

    Its line of Coulomb and viscous friction is the one through the friction of the model without lag, path and delay;
    its offset is the mean of what that leaves, and of the loads.
    """
    inner, shape = one.model
    result = np.array([[float(own == name) for own in (*inner, *one.slopes)] for name in names])
    if inner == names and shape == Shape():
        return result
    apart = {"inertia", "torque_delay", *GRAVITY}
    slow = [place for place, name in enumerate(inner) if name not in apart]
    static = Model(tuple(inner[place] for place in slow), shape._replace(friction_lag=0.0, path=0.0))
    bends = _slopes(data, static, one.values[slow])
    torques = np.column_stack([data.columns(*static), *bends.values()])
    places = np.array([*slow, *(len(inner) + one.slopes.index(name.removeprefix(SLOPE)) for name in bends)])
    friction = np.array([_is_friction(name) for name in static.names] + [True] * len(bends))
    line = [place for place, name in enumerate(names) if _is_friction(name)]
    if line:
        columns = data.columns(tuple(names[place] for place in line), Shape())
        fitted = np.linalg.lstsq(columns, torques[:, friction])[0]
        result[np.ix_(line, places[friction])] = fitted
        torques[:, friction] -= columns @ fitted
    if "offset" in names:
        result[names.index("offset"), places] = torques.mean(axis=0)
    return result


def _is_friction(name: str) -> bool:
    return name in DRY | VISCOUS or name.startswith("friction_")


def _slopes(data: Data, model: Model, values: Array) -> dict[str, Array]:
    """Return the derivative of the torque by the logarithm of each number of the shape."""
    found = {}
    for name, value in model.shape._asdict().items():
        if value:
            up, down = (
                data.columns(model.names, model.shape._replace(**{name: value * factor})) @ values
                for factor in (1.05, 1.0 / 1.05)
            )
            found[SLOPE + name] = (up - down) / (2.0 * math.log(1.05))
    return found


def _timing(data: Data, folds: Folds, own: Folds) -> Array:
    """Return the covariance by the time of the torque, known to half a sample before the rows were measured."""
    if data.prepared.delay_known or "torque_delay" in own.names:
        return np.zeros((len(own.names), len(own.names)))
    prior = data.prepared.period**2 / 12.0
    free = folds.solve(bounded=False)
    delay, error = float(free[-1]), math.sqrt(spread(folds)[-1, -1])
    certain = 1.0 / (1.0 / prior + 1.0 / max(error, 1e-12) ** 2)
    mean = min(abs(delay) * certain / max(error, 1e-12) ** 2, data.prepared.period)
    gram, cross = own.clean.sum(axis=0), folds.gram.sum(axis=0)[: len(own.names), -1]
    alias = solve(gram, cross, own.names, bounded=False)
    return np.asarray(np.outer(alias, alias) * (certain + mean**2))


def _weight(errors: Array, best: Array) -> float:
    """Return the weight of a model by how many standard errors it validates worse than the best."""
    apart = errors - best
    spread = float(np.std(apart, ddof=1)) / math.sqrt(apart.size)
    return math.exp(-0.5 * (float(np.mean(apart)) / spread) ** 2) if spread > 0.0 else 1.0
