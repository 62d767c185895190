"""Which model a log shows: the textbook's first, refined only where what was left out of the fit says so."""

import math
from collections.abc import Iterator
from typing import NamedTuple

import numpy as np
from scipy import optimize

from adaptive_ff.identify.columns import DRY, GRAVITY, VISCOUS, Map, Shape, static_friction, unit_torques
from adaptive_ff.identify.motion import Array
from adaptive_ff.identify.preparation import Prepared
from adaptive_ff.identify.regression import (
    NOT_NEGATIVE,
    Blocks,
    left_out_errors,
    quantile,
    solve,
    standard_errors,
    sums,
)


class Rule(NamedTuple):
    """When further terms are taken.

    The standard errors over the blocks by which the mean square error must fall, and the share of the rms residual that
    must go.
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


class Fitted(NamedTuple):
    """A model with estimates, ends of their intervals by name, and mean square errors of blocks that were left out."""

    model: Model
    values: dict[str, float]
    lower: dict[str, float]
    upper: dict[str, float]
    errors: Array


class Selection(NamedTuple):
    """The textbook's model, that with the refinements that were taken, and what each textbook column has of its own.

    The tolerance is the share of a column that the others do not explain, gravity's among them on a rotary axis.
    """

    textbook: Fitted
    refined: Fitted | None
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

    def sums(self, names: tuple[str, ...], columns: Array) -> Blocks:
        """Return the sums of some columns by block."""
        return sums(names, columns, self.prepared.torque, self.prepared.block, self.prepared.noise)

    def fit(self, model: Model) -> Blocks:
        """Return the sums of a model."""
        return self.sums(model.names, self.columns(*model))


def is_better(old: Array, new: Array, rule: Rule) -> bool:
    """Tell whether errors of blocks fall by what a rule asks for."""
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
        for share in SPEEDS:
            yield "stribeck", Model((*names, "stiction_excess"), shape._replace(stribeck_velocity=share * fast))
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
    """Return the best model of each kind of refinement, with the errors of its blocks."""
    cache = dict(zip([(name, model.shape) for name in model.names], data.columns(*model).T, strict=True))
    best: dict[str, tuple[Model, Array]] = {}
    for kind, one in refinements(data, model):
        follows = [name in DRY | VISCOUS or name.startswith("friction_") for name in one.names]
        keys = [(name, one.shape if bent else model.shape) for name, bent in zip(one.names, follows, strict=True)]
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
    around = beside = tried(data, model) if refine else {}
    while refine:
        kind, (better, new) = min(around.items(), key=lambda item: float(np.mean(item[1][1])))
        if not is_better(errors, new, REFINEMENT):
            break
        taken.append(kind)
        model, errors = better, new
        around = tried(data, model)
        if not around:
            break
    others = [(one, left) for one, left in beside.values() if is_better(base_errors, left, DIFFERENT)]
    if not taken:
        return Selection(_fitted(data, base, base_errors, others, confidence), None, (), tolerance)
    model = _polished(data, model)
    rest = [(one, left) for one, left in around.values() if is_better(errors, left, DIFFERENT)]
    refined = _fitted(data, model, errors, rest, confidence)
    explained = data.columns(*model) @ data.fit(model).solve() - data.columns(*base) @ data.fit(base).solve()
    rest_of = data._replace(prepared=data.prepared._replace(torque=data.prepared.torque - explained))
    textbook = _fitted(data, base, base_errors, [*others, (model, errors)], confidence, rest_of)
    return Selection(textbook, refined, tuple(taken), tolerance)


COLLINEAR = 1e-3
"""Share of a column that the others must leave for its parameter to be identifiable."""


def _identifiable(data: Data, terms: tuple[str, ...]) -> tuple[Model, dict[str, float]]:
    """Return the textbook's model of the terms that the motion tells apart, and how far it does."""
    judged = terms + (GRAVITY if data.rotary else ())
    blocks = data.fit(Model(judged))
    tolerance = blocks.of(terms).tolerance()
    noise = data.prepared.noise["inertia"] * blocks.rows.sum()
    power = float(blocks.gram.sum(axis=0)[0, 0])
    tolerance["inertia"] = min(tolerance["inertia"], max(0.0, 1.0 - noise / max(power, 1e-300)) ** 4)
    names = list(terms)
    if "coulomb" in names and tolerance["coulomb"] < COLLINEAR and "offset" in names:
        names.remove("coulomb")  # one way: friction and load are one constant
    for name in ("viscous", "inertia"):
        if min(blocks.of(tuple(names)).tolerance()[name], tolerance[name] if name == "inertia" else 1.0) < COLLINEAR:
            names.remove(name)
    if data.rotary and "inertia" in names:  # one sine: a spring-like torque and inertia are one number
        tolerance["inertia_beside_gravity"] = blocks.tolerance()["inertia"]
    return Model(tuple(names)), tolerance


def _polished(data: Data, model: Model) -> Model:
    """Return a model with the shape between the tried ones that leaves least."""
    for name, value in model.shape._asdict().items():
        if not value:
            continue

        def left(log_value: float, name: str = name, model: Model = model) -> float:
            one = model._replace(shape=model.shape._replace(**{name: math.exp(log_value)}))
            blocks = data.fit(one)
            values = blocks.solve()
            return float(values @ blocks.gram.sum(axis=0) @ values - 2.0 * values @ blocks.moment.sum(axis=0))

        ends = math.log(value) - NEAR, math.log(value) + NEAR
        found = optimize.minimize_scalar(left, bounds=ends, method="bounded", options={"xatol": 0.02})
        model = model._replace(shape=model.shape._replace(**{name: math.exp(found.x)}))
    return model


def _fitted(
    data: Data,
    model: Model,
    errors: Array,
    others: list[tuple[Model, Array]],
    confidence: float,
    without: Data | None = None,
) -> Fitted:
    """Return a model with estimates and intervals.

    To the spread over blocks come, as variances: what half a sample of the torque's time would change, as far as the
    rows leave it open; what half of the band changes; and, on their side alone, the weighted moves to models that
    validate better, each taken as uniform up to its size. ``without`` holds the torque without what refinements
    explain, which is no noise.
    """
    slopes = _slopes(data, model)
    late = () if "torque_delay" in model.names else ("torque_delay",)
    columns = np.column_stack([data.columns((*model.names, *late), model.shape), *slopes.values()])
    names, inner = (*model.names, *late, *slopes), (*model.names, *slopes)
    blocks = data.sums(names, columns).of((*inner, *late))
    values = blocks.of(model.names).solve()
    if without is not None:
        blocks = without.sums(names, columns).of((*inner, *late))
    own, size = blocks.of(inner), len(model.names)
    spread = standard_errors(own)
    variance = spread[:size] ** 2 + _timing(data, blocks, own)[:size] + _narrowing(data, model)
    wide = quantile(data.prepared.blocks, confidence)
    result = dict(zip(model.names, values.tolist(), strict=True))
    moved = _moves(data, model, result, errors, others)
    below, above = (wide * np.sqrt(variance + [moved[name][side] / 3.0 for name in model.names]) for side in (0, 1))
    lower = dict(zip(model.names, (values - below).tolist(), strict=True))
    upper = dict(zip(model.names, (values + above).tolist(), strict=True))
    lower |= {name: max(0.0, lower[name]) for name in NOT_NEGATIVE if name in lower}
    for name, error in zip(slopes, wide * spread[size:], strict=True):
        key = name.removeprefix(SLOPE)
        factor = math.exp(min(float(error), 20.0))
        result[key] = getattr(model.shape, key)
        lower[key], upper[key] = result[key] / factor, result[key] * factor
    return Fitted(model, result, lower, upper, errors)


def _slopes(data: Data, model: Model) -> dict[str, Array]:
    """Return the derivative of the torque by the logarithm of each number of the shape."""
    found = {}
    values = data.fit(model).solve()
    for name, value in model.shape._asdict().items():
        if value:
            up, down = (
                data.columns(model.names, model.shape._replace(**{name: value * factor})) @ values
                for factor in (1.05, 1.0 / 1.05)
            )
            found[SLOPE + name] = (up - down) / (2.0 * math.log(1.05))
    return found


def _narrowing(data: Data, model: Model) -> Array:
    """Return the variance by the choice of the band: what half of it changes, taken as uniform up to that."""
    if data.narrower is None:
        return np.zeros(len(model.names))
    wide, narrow = data.fit(model).solve(), data._replace(prepared=data.narrower).fit(model).solve()
    return np.asarray((narrow - wide) ** 2 / 3.0)


def _timing(data: Data, blocks: Blocks, own: Blocks) -> Array:
    """Return the variance by the time of the torque, known to half a sample before the rows were seen."""
    if data.prepared.delay_known or "torque_delay" in own.names:
        return np.zeros(len(own.names))
    prior = data.prepared.period**2 / 12.0
    free = blocks.solve(bounded=False)
    delay, error = float(free[-1]), float(standard_errors(blocks)[-1])
    certain = 1.0 / (1.0 / prior + 1.0 / max(error, 1e-12) ** 2)
    mean = min(abs(delay) * certain / max(error, 1e-12) ** 2, data.prepared.period)
    gram, cross = own.clean.sum(axis=0), blocks.gram.sum(axis=0)[: len(own.names), -1]
    alias = solve(gram, cross, own.names, bounded=False)
    return np.asarray(alias**2 * (certain + mean**2))


def line(data: Data, values: dict[str, float], shape: Shape) -> tuple[float, float]:
    """Return Coulomb and viscous friction of the line through a friction curve, over the speeds of the rows."""
    velocity = data.prepared.velocity
    columns = np.column_stack([np.sign(velocity), velocity])
    coulomb, viscous = np.linalg.lstsq(columns, static_friction(velocity, values, shape))[0]
    return float(coulomb), float(viscous)


def _moves(
    data: Data, model: Model, values: dict[str, float], errors: Array, others: list[tuple[Model, Array]]
) -> dict[str, tuple[float, float]]:
    """Return how far better models move each parameter, squared: downwards and upwards, weighted by their errors."""
    moved = {name: (0.0, 0.0) for name in model.names}
    if not others:
        return moved
    best = min([errors, *(left for _, left in others)], key=lambda left: float(np.mean(left)))
    own_line = line(data, values, model.shape)
    total = _weight(errors, best)
    sums_of = {name: [0.0, 0.0] for name in model.names}
    for one, left in others:
        weight = _weight(left, best)
        total += weight
        other = dict(zip(one.names, data.fit(one).solve().tolist(), strict=True))
        other_line = line(data, other, one.shape)
        apart = {name: other[name] - values[name] for name in model.names if name in other}
        apart |= {"coulomb": other_line[0] - own_line[0], "viscous": other_line[1] - own_line[1]}
        for name in model.names:
            step = apart.get(name, 0.0)
            sums_of[name][step > 0.0] += weight * step**2
    return {name: (low / total, high / total) for name, (low, high) in sums_of.items()}


def _weight(errors: Array, best: Array) -> float:
    """Return the weight of a model by how many standard errors it validates worse than the best."""
    apart = errors - best
    spread = float(np.std(apart, ddof=1)) / math.sqrt(apart.size)
    return math.exp(-0.5 * (float(np.mean(apart)) / spread) ** 2) if spread > 0.0 else 1.0
