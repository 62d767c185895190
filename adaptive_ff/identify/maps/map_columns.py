"""Friction and forces over position and load, as columns of a log.

Friction is that of the model times ``1 + m``, in the form that the controller learns
(:mod:`adaptive_ff.adaptive.learning.friction_map`),

    m = sum_k (a_k cos(2 pi q/p_k) + b_k sin(2 pi q/p_k)) + sum_j c_j hat_j(q) + l (|u| - <|u|>)

with known periods ``p_k``, hats over the range of the log, and the known torque ``u``. With the friction ``F(w)`` of a
fit without the map, ``F m`` is linear in the coefficients; it lags as friction does. A force over position, as that of
cables, springs and cogging, has the same functions without the friction, and no lag.

Hats sum up to one, and so would be Coulomb friction once more; their coefficients are confined to those whose map has
no mean over the rows of the log.
"""

import math
from collections.abc import Mapping, Sequence
from typing import NamedTuple

import numpy as np
from scipy.integrate import cumulative_trapezoid
from scipy.linalg import null_space

from adaptive_ff.adaptive.learning.map_settings import map_parameters
from adaptive_ff.errors import InputError
from adaptive_ff.identify.fitting.fitted import Fitted
from adaptive_ff.identify.preparation import Prepared
from adaptive_ff.identify.rows.band import Band, band_of_motion, uniform, velocity_between, wide_velocity
from adaptive_ff.identify.rows.filtering import bent_along, over_path
from adaptive_ff.identify.rows.path_lag import OverPath
from adaptive_ff.identify.rows.regressors import Problem
from adaptive_ff.identify.terms import ASYMMETRY, BENT, FORCE_OVER, FRICTION_OVER, GRAVITY, LOAD, Terms
from adaptive_ff.logs.defects import Piece
from adaptive_ff.logs.derivatives import Array
from adaptive_ff.logs.log import KNOWN, Log

MOST_HATS = 40
"""Most hats: the products of all columns take time and memory with their square; 40 some half a minute."""

FARTHEST = 3.0
"""Longest period over the travel of a log. Of a longer one the log shows a straight line only, which fits as well with
a large friction that is far away: on 30 s of a joint with friction of 3 N m, 5 times the travel gave 2.65 to 3.47 N m,
100 times 26 N m.
"""


class MapAsked(NamedTuple):
    """What friction, and a force, may depend on.

    Attributes
    ----------
    periods : tuple of float
        Known periods, rad.
    hats : int
        Number of hats over the range of the log; none, or two at least.
    load : bool
        Whether friction may depend on the known torque.
    found : bool
        Whether the periods were not told, but found in the log; then they are those of a force only.
    """

    periods: tuple[float, ...] = ()
    hats: int = 0
    load: bool = False
    found: bool = False


class MapBasis(NamedTuple):
    """Functions of position and load.

    Attributes
    ----------
    asked : MapAsked
        Which there are.
    lowest, highest : float
        Positions of the first and of the last hat, rad.
    contrasts : ndarray, shape (hats, m)
        Hats by free coefficient: a map of them has no mean over the log.
    load : float
        Mean known torque without its sign, N m.
    """

    asked: MapAsked
    lowest: float
    highest: float
    contrasts: Array
    load: float

    def names(self) -> list[str]:
        """Return the names of the functions of the position."""
        count = len(self.asked.periods)
        waves = [f"{wave}_{k + 1}" for k in range(count) for wave in ("cosine", "sine")]
        return [*waves, *(f"hat_{k + 1}" for k in range(self.contrasts.shape[1]))]

    def over(self, position: Array) -> Array:
        """Return the functions of the position, shape (functions, n)."""
        made = []
        for period in self.asked.periods:
            phase = (2.0 * math.pi / period) * position
            made += [np.cos(phase), np.sin(phase)]
        if self.contrasts.size:
            made += list(self.contrasts.T @ hats_at(position, self.lowest, self.highest, self.asked.hats))
        return np.array(made).reshape(-1, position.size)

    def models(self) -> list[Terms]:
        """Return the sets of terms that may be added to a model, without the empty one."""
        names = self.names()
        if self.asked.found:
            return [tuple(FORCE_OVER + name for name in names)]
        waves = [name for name in names if not name.startswith("hat")]
        hats = [name for name in names if name.startswith("hat")]
        parts = [[], *(part for part in (waves, hats) if part)]
        frictions = [*parts, [*waves, *hats]] if waves and hats else parts
        loads: list[Terms] = [(), (LOAD,)] if self.asked.load else [()]
        made = [
            (*(FRICTION_OVER + name for name in friction), *load, *(FORCE_OVER + name for name in force))
            for friction in frictions
            for load in loads
            for force in parts
        ]
        return [terms for terms in made if terms]


def check_asked(asked: MapAsked, log: Log) -> None:
    """Raise ``InputError`` where a map is not allowed, or the log cannot have it."""
    try:
        map_parameters(asked.periods, asked.hats, None, 0.0, 1.0)
    except ValueError as error:
        raise InputError(str(error)) from None
    if asked.hats > MOST_HATS:
        raise InputError(f"position_hats = {asked.hats} is not allowed here: there may be at most {MOST_HATS}")
    if (asked.periods or asked.hats) and log.position is None:
        raise InputError(f"{log.name}: friction over position takes a position; the log is read with a velocity")
    if asked.load and KNOWN not in log.extra:
        raise InputError(f"{log.name}: friction over load takes a known torque; name its column with --known-torque")


def check_periods(asked: MapAsked, name: str, lowest: float, highest: float) -> None:
    """Raise ``InputError`` where a period is far longer than a log travels, between two positions, rad."""
    travel = highest - lowest
    for period in asked.periods:
        if period > FARTHEST * travel:
            raise InputError(
                f"{name}: position_periods = {period:.4g} is not allowed: the log travels {travel:.3g}, and a period "
                f"must be at most {FARTHEST:g} times that, {FARTHEST * travel:.3g}"
            )


def hats_at(position: Array, lowest: float, highest: float, count: int) -> Array:
    """Return piecewise linear functions, each one at its own position, shape (count, n); constant beyond the ends."""
    place = np.clip((position - lowest) * ((count - 1) / (highest - lowest)), 0.0, count - 1.0)
    return np.maximum(0.0, 1.0 - np.abs(place - np.arange(count)[:, np.newaxis]))


def map_basis(asked: MapAsked, prepared: Prepared, pieces: Sequence[Piece]) -> MapBasis:
    """Return the functions for the positions and loads of some pieces of a log."""
    log, period = prepared.log, prepared.period
    load = float(np.mean(np.concatenate([_load(log, piece, period) for piece in pieces]))) if asked.load else 0.0
    if not asked.hats:
        return MapBasis(asked, 0.0, 0.0, np.empty((0, 0)), load)
    position = np.concatenate([position_along(log, piece, period) for piece in pieces])
    lowest, highest = float(np.min(position)), float(np.max(position))
    mean = np.mean(hats_at(position, lowest, highest, asked.hats), axis=1)
    visited = np.flatnonzero(mean > 0.0)
    contrasts = np.zeros((asked.hats, visited.size - 1))
    contrasts[visited] = null_space(mean[np.newaxis, visited])
    return MapBasis(asked, lowest, highest, contrasts, load)


def model_friction(fitted: Fitted, velocity: Array, over: OverPath | None = None) -> Array:
    """Return the friction of a model without a map and its lag, N m: over a path where there is one, else static."""
    values = fitted.values
    direction = np.sign(velocity) if over is None else over.at_samples(np.sign)
    friction: Array = values["coulomb"] * direction + values["viscous"] * velocity
    if ASYMMETRY in values:
        friction = friction + values[ASYMMETRY] * np.abs(velocity)
    for term, bend in BENT.items():
        if term in values:
            friction = friction + values[term] * bent_along(term, values[bend], velocity, over)
    return friction


def with_map(problem: Problem, prepared: Prepared, pieces: Sequence[Piece], basis: MapBasis, fitted: Fitted) -> Problem:
    """Return a problem whose pieces have the columns of a map.

    Parameters
    ----------
    problem : Problem
        The rows of the pieces.
    prepared : Prepared
        The log that they come from.
    pieces : sequence of Piece
        The pieces, in the order of the problem's.
    basis : MapBasis
        Functions of position and load.
    fitted : Fitted
        The model whose friction they vary.
    """
    made = []
    for piece, rows in zip(pieces, problem.pieces, strict=True):
        mapped, between, edges = _columns(prepared, piece, basis, fitted)
        made.append(
            rows._replace(
                mapped=mapped, between={**_plain(rows.between), **between}, edges={**_plain(rows.edges), **edges}
            )
        )
    return problem._replace(pieces=made)


def _plain(series: Mapping[str, Array]) -> dict[str, Array]:
    return {name: column for name, column in series.items() if not name.startswith(FRICTION_OVER)}


def _columns(
    prepared: Prepared, piece: Piece, basis: MapBasis, fitted: Fitted
) -> tuple[dict[str, Array], dict[str, Array], dict[str, Array]]:
    """Return the filtered columns of a piece, and of friction what it is between samples and at edges of motions."""
    log, period, band = prepared.log, prepared.period, band_along(prepared, piece)
    over = over_path(band.velocity, period, prepared.rest.bending)
    friction = model_friction(fitted, band.velocity, over)
    fine = velocity_between(band.velocity, period) if over is None else None  # over a path it does not jump
    beyond = None if fine is None else friction - np.mean(model_friction(fitted, fine), axis=1)
    names = basis.names()
    factors = dict(zip(names, basis.over(position_along(log, piece, period)), strict=True)) if names else {}
    shares = {FRICTION_OVER + name: factor for name, factor in factors.items()}
    if basis.asked.load:
        shares[LOAD] = _load(log, piece, period) - basis.load
    mapped = {name: band.filtered(share * friction) for name, share in shares.items()}
    mapped |= {FORCE_OVER + name: band.filtered(factor) for name, factor in factors.items()}
    between = {} if beyond is None else {name: band.filtered(share * beyond) for name, share in shares.items()}
    edges = {} if band.stops == 0 else {name: band.at_edges(share * friction) for name, share in shares.items()}
    return mapped, between, edges


def band_along(prepared: Prepared, piece: Piece) -> Band:
    """Return the filters of a piece."""
    log, period, rest = prepared.log, prepared.period, prepared.rest
    motion, is_position = uniform(log, piece, period)[1], log.position is not None
    fast = wide_velocity(motion, rest.corner, period, is_position=is_position)
    return band_of_motion(fast, prepared.bandwidth, period, rest)


def position_along(log: Log, piece: Piece, period: float) -> Array:
    """Return the position of a piece at equal steps, rad: of velocities, what they add up to from the log's begin."""
    if log.position is not None:
        return uniform(log, piece, period)[1]
    return _beside(log, np.asarray(cumulative_trapezoid(log.motion, log.time, initial=0.0)), piece, period)


def _load(log: Log, piece: Piece, period: float) -> Array:
    """Return the size of the known torque of a piece at equal steps, N m."""
    return np.abs(_beside(log, log.extra[KNOWN], piece, period))


def _beside(log: Log, series: Array, piece: Piece, period: float) -> Array:
    """Return a series of a log in a piece, at equal steps."""
    part = slice(piece.start, piece.stop)
    other = Log(log.name, log.time[part], series[part], velocity=log.motion[part])
    return uniform(other, Piece(0, other.time.size), period)[2]


def excludes(model: Terms, terms: Terms) -> bool:
    """Tell whether terms of a map cannot be beside those of a model: hats of force hold gravity."""
    return GRAVITY[0] in model and any(term.startswith(FORCE_OVER + "hat") for term in terms)
