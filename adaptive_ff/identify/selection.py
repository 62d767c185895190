"""Which model a log shows: the textbook's first, refined only where what was left out of the fit says so."""

import math
from collections.abc import Iterator
from typing import NamedTuple

import numpy as np
from scipy import optimize

from adaptive_ff.identify.averaging import averaged, estimated, with_intervals
from adaptive_ff.identify.columns import CARRIED, GRAVITY, Shape, is_friction
from adaptive_ff.identify.motion import Array
from adaptive_ff.identify.preparation import Prepared, narrowed
from adaptive_ff.identify.regression import Fit, Model, left_out_errors


class Rule(NamedTuple):
    """When further terms are taken.

    The standard errors over the folds by which the mean square error must fall, and the fraction of the rms residual
    that must go.
    """

    errors: float
    gain: float


REFINEMENT, WEIGHT = Rule(1.5, 0.1), Rule(0.7, 0.03)
"""For refinements, and for gravity, which most rotary joints have."""

DIFFERENT = REFINEMENT._replace(gain=0.0)
"""For models that only count in the intervals."""

LAGS = (0.02, 0.04, 0.08, 0.16, 0.3, 0.6)
"""Friction lags that are tried, in cycles of the band."""

PATHS = (0.002, 0.008, 0.03)
"""Paths that are tried, over the way in a second at the usual speed."""

SPEEDS = (0.02, 0.04, 0.08, 0.15, 0.3)
"""Stribeck velocities that are tried, over the usual speed."""

NEAR = 0.4
"""Logarithm of the factor within which a shape is looked for around the best tried one."""


class Selection(NamedTuple):
    """The textbook's model, that with the refinements that were taken, and what each textbook column has of its own.

    The tolerance is the fraction of a column that the others do not explain, gravity's among them on a rotary axis.
    """

    textbook: Fit
    refined: Fit | None
    taken: tuple[str, ...]
    tolerance: dict[str, float]


def is_better(old: Array, new: Array, rule: Rule) -> bool:
    """Tell whether errors of folds fall by what a rule asks for."""
    fall = old - new
    spread = float(np.std(fall, ddof=1)) / math.sqrt(fall.size)
    return float(np.mean(fall)) > rule.errors * spread and np.mean(new) < (1.0 - rule.gain) ** 2 * np.mean(old)


def refinements(data: Prepared, model: Model) -> Iterator[tuple[str, Model]]:
    """Yield models that have one thing more, each with what that is."""
    names, shape = model
    band, fast = data.band, data.fast
    if "coulomb" in names and not (shape.friction_lag or shape.path):
        for cycles in LAGS:
            yield "lag", Model(names, shape._replace(friction_lag=cycles / band))
        for seconds in PATHS:
            yield "path", Model(names, shape._replace(path=seconds * fast))
    if "coulomb" in names and not shape.stribeck_velocity:
        for fraction in SPEEDS:
            yield "stribeck", Model((*names, "stiction_excess"), shape._replace(stribeck_velocity=fraction * fast))
    if "coulomb" in names and "load_friction" not in names:
        yield "load", Model((*names, "load_friction"), shape._replace(load=data.load))
    for kind, further in _linear(data, model):
        if further and not set(further) <= set(names):
            yield kind, Model((*names, *further), shape)


def _linear(data: Prepared, model: Model) -> Iterator[tuple[str, tuple[str, ...]]]:
    """Yield terms that need no shape."""
    if "coulomb" in model.names:
        yield "directions", ("viscous_asymmetry",)
        yield "friction over position", tuple(f"friction_{name}" for name in data.place.names)
    if not data.delay_known:
        yield "delay", ("torque_delay",)
    yield "force over position", tuple(f"force_{name}" for name in data.place.names)


def tried(data: Prepared, model: Model) -> dict[str, tuple[Model, Array]]:
    """Return the best model of each kind of refinement, with the errors of its folds."""
    cache: dict[tuple[str, Shape], Array] = {}
    best: dict[str, tuple[Model, Array]] = {}
    for kind, one in refinements(data, model):
        shapes = model.shape, one.shape._replace(load=()), one.shape
        keys = [(name, shapes[is_friction(name) + (name == "load_friction")]) for name in one.names]
        for name, shape in keys:
            if (name, shape) not in cache:
                cache[name, shape] = data.columns((name,), shape)[:, 0]
        errors = left_out_errors(data.sums(one.names, np.column_stack([cache[key] for key in keys])))
        if kind not in best or np.mean(errors) < np.mean(best[kind][1]):
            best[kind] = one, errors
    return best


def select(
    data: Prepared, terms: tuple[str, ...], confidence: float, *, weight: bool | None, refine: bool
) -> Selection:
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
    if not data.has_known:
        found = dict(zip(model.names, data.fit(model).solve().tolist(), strict=True))
        data = data._replace(load=tuple(found.get(name, 0.0) for name in CARRIED))
    around = tried(data, model) if refine else {}
    models = [(model, errors), *(one for one in around.values() if is_better(errors, one[1], DIFFERENT))]
    taken: list[str] = []
    while around:
        kind, (better, new) = min(around.items(), key=lambda item: float(np.mean(item[1][1])))
        if not is_better(errors, new, REFINEMENT):
            break
        taken.append(kind)
        model, errors = better, new
        around = tried(data, model)
    if taken:
        models.append((_polished(data, model), errors))
    narrower = narrowed(data)
    estimates = [estimated(data, narrower, *one) for one in models]
    refined = with_intervals(data, estimates[-1], confidence) if taken else None
    return Selection(averaged(data, estimates, confidence), refined, tuple(taken), tolerance)


COLLINEAR = 1e-3
"""Fraction of a column that the others must leave for its parameter to be identifiable."""


def _identifiable(data: Prepared, terms: tuple[str, ...]) -> tuple[Model, dict[str, float]]:
    """Return the textbook's model of the terms that the motion tells apart, and how far it does."""
    judged = terms + (GRAVITY if data.rotary else ())
    folds = data.fit(Model(judged))
    tolerance = folds.of(terms).tolerance()
    noise = data.noise["inertia"] * folds.rows.sum()
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


def _polished(data: Prepared, model: Model) -> Model:
    """Return a model with the shape between the tried ones that leaves least."""
    for name, value in model.shape.bends.items():

        def left(log_value: float, name: str = name, model: Model = model) -> float:
            one = model._replace(shape=model.shape.bent(name, math.exp(log_value)))
            folds = data.fit(one)
            values = folds.solve()
            return float(values @ folds.gram.sum(axis=0) @ values - 2.0 * values @ folds.moment.sum(axis=0))

        ends = math.log(value) - NEAR, math.log(value) + NEAR
        found = optimize.minimize_scalar(left, bounds=ends, method="bounded", options={"xatol": 0.02})
        model = model._replace(shape=model.shape.bent(name, math.exp(found.x)))
    return model
