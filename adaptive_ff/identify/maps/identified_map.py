"""Friction and force over position and load as they were identified, for tables, pictures and a controller."""

import math
from typing import Any, NamedTuple

import numpy as np

from adaptive_ff.identify.fitting.fitted import Fitted
from adaptive_ff.identify.maps.map_columns import MapBasis
from adaptive_ff.identify.terms import FORCE_OVER, FRICTION_OVER, LOAD, is_mapped
from adaptive_ff.learning.batch_least_squares import Estimate
from adaptive_ff.logs.derivatives import Array

POINTS = 400
"""Positions at which a map is read."""


class Curve(NamedTuple):
    """A function of the position with its interval at each; shape (n,) each."""

    value: Array
    lower: Array
    upper: Array


class IdentifiedMap(NamedTuple):
    """How friction, and a force, depend on position and load.

    Attributes
    ----------
    position : ndarray, shape (n,)
        Positions, rad: the range of the log where there are hats, else one of the longest period.
    friction : Curve or None
        Friction over that of the model, with its interval; None where it does not depend on position.
    force : Curve or None
        Torque over position beside friction, N m; None where there is none.
    load_share : Estimate or None
        Share of the friction without a load by which it rises for each N m of known torque, 1/(N m).
    periods : tuple of float
        Known periods that friction depends on, rad.
    hats : int
        Number of hats that friction depends on.
    range : tuple of float
        Positions of the first and of the last hat, rad.
    coefficients : tuple of float
        Of friction over position, in the order of the controller's map: cosine and sine of each period, hats.
    standard_errors : tuple of float
        Of these coefficients, in their order; infinite for a hat that the log did not visit, whose coefficient is zero.
    load_mean : float
        Mean known torque without its sign, N m, at which friction is that of the model.
    force_periods : tuple of float
        Periods that the force depends on, rad.
    force_coefficients : tuple of Estimate
        Cosine and sine of each of these periods, N m.
    """

    position: Array
    friction: Curve | None
    force: Curve | None
    load_share: Estimate | None
    periods: tuple[float, ...]
    hats: int
    range: tuple[float, float]
    coefficients: tuple[float, ...]
    standard_errors: tuple[float, ...]
    load_mean: float
    force_periods: tuple[float, ...]
    force_coefficients: tuple[Estimate, ...]

    @property
    def ripple_sizes(self) -> tuple[float, ...]:
        """Amplitude of the force over each of its periods, N m."""
        values = [one.value for one in self.force_coefficients]
        return tuple(math.hypot(*pair) for pair in zip(values[::2], values[1::2], strict=True))

    def to_dict(self) -> dict[str, Any]:
        """Return plain values; the keys of the controller's map are those of a scenario's ``[adaptation]``."""
        curves = {"friction": self.friction, "force": self.force}
        result: dict[str, Any] = {
            "position_periods": list(self.periods),
            "force_periods": list(self.force_periods),
            "force_coefficients": [one._asdict() for one in self.force_coefficients],
            "position_hats": self.hats,
            "position_range": list(self.range) if self.hats else None,
            "load_friction": None if self.load_share is None else self.load_share._asdict(),
            "coefficients": list(self.coefficients),
            "standard_errors": [error if np.isfinite(error) else None for error in self.standard_errors],
        }
        if self.friction is not None or self.force is not None:
            result["position"] = self.position.tolist()
        for name, curve in curves.items():
            result[name] = None if curve is None else {key: part.tolist() for key, part in curve._asdict().items()}
        return result


def identified_map(fitted: Fitted, basis: MapBasis, positions: tuple[float, float]) -> IdentifiedMap | None:
    """Return the map of a fit, between the lowest and the highest position (rad) of its log; None without one."""
    mapped = [term for term in fitted.terms if is_mapped(term)]
    if not mapped:
        return None
    if not any("hat" in term for term in mapped) and basis.asked.periods:
        positions = 0.0, max(basis.asked.periods)
    position = np.linspace(*positions, POINTS)
    functions = dict(zip(basis.names(), basis.over(position), strict=True))
    names = [term.removeprefix(FRICTION_OVER) for term in mapped if term.startswith(FRICTION_OVER) and term != LOAD]
    waves = sum(name.startswith("cosine") for name in names)
    with_hats = any(name.startswith("hat") for name in names)
    free = np.array([fitted.values[FRICTION_OVER + name] for name in names if name.startswith("hat")])
    hats = (basis.contrasts @ free).tolist() if with_hats else []
    coefficients = [fitted.values[FRICTION_OVER + name] for name in names if not name.startswith("hat")]
    over_periods = [term for term in mapped if term.startswith((FORCE_OVER + "cosine", FORCE_OVER + "sine"))]
    return IdentifiedMap(
        position=position,
        friction=_curve(fitted, FRICTION_OVER, names, functions, 1.0),
        force=_curve(fitted, FORCE_OVER, [name for name in functions if FORCE_OVER + name in mapped], functions, 0.0),
        load_share=_load_share(fitted, basis.load) if LOAD in mapped else None,
        periods=basis.asked.periods if waves else (),
        hats=basis.asked.hats if with_hats else 0,
        range=(basis.lowest, basis.highest),
        coefficients=(*coefficients, *hats),
        standard_errors=_standard_errors(fitted, basis, names),
        load_mean=basis.load,
        force_periods=basis.asked.periods if over_periods else (),
        force_coefficients=tuple(fitted.regression.estimate(term) for term in over_periods),
    )


def _standard_errors(fitted: Fitted, basis: MapBasis, names: list[str]) -> tuple[float, ...]:
    """Return the standard errors of the waves' coefficients and of those of all hats."""
    places = [fitted.regression.names.index(FRICTION_OVER + name) for name in names]
    covariance = fitted.regression.covariance[np.ix_(places, places)]
    free = np.array([name.startswith("hat") for name in names], dtype=bool)
    errors = np.sqrt(np.maximum(np.diag(covariance), 0.0))[~free].tolist()
    if np.any(free):
        squared = np.einsum("hi,ij,hj->h", basis.contrasts, covariance[np.ix_(free, free)], basis.contrasts)
        visited = np.any(basis.contrasts != 0.0, axis=1)
        errors += np.where(visited, np.sqrt(np.maximum(squared, 0.0)), np.inf).tolist()
    return tuple(errors)


def _curve(fitted: Fitted, kind: str, names: list[str], functions: dict[str, Array], mean: float) -> Curve | None:
    """Return what some terms make of the position, beside a mean that is known."""
    if not names:
        return None
    places = [fitted.regression.names.index(kind + name) for name in names]
    rows = np.array([functions[name] for name in names])
    value = mean + np.array([fitted.values[kind + name] for name in names]) @ rows
    covariance = fitted.regression.covariance[np.ix_(places, places)]
    errors = np.sqrt(np.maximum(np.einsum("in,ij,jn->n", rows, covariance, rows), 0.0))
    estimates = [fitted.regression.interval(*pair) for pair in zip(value.tolist(), errors.tolist(), strict=True)]
    return Curve(value, *(np.array([getattr(one, end) for one in estimates]) for end in ("lower", "upper")))


def _load_share(fitted: Fitted, mean: float) -> Estimate:
    """Return the rise of friction with the load over friction without a load: ``l/(1 - l <|u|>)``."""
    found = fitted.regression.estimate(LOAD)
    unloaded = 1.0 - found.value * mean
    value = found.value / unloaded
    return fitted.regression.interval(value, found.standard_error / unloaded**2)
