"""Columns of the joint's equation for a log in its band.

``torque = J a + f + offset + Gs sin q + Gc cos q``, where ``f`` follows ``F(w)`` with a lag, ``tau df/dt + f = F(w)``,
(1), and

    F(w) = Fc sgn(w) + sigma w + b |w| + (Fs - Fc) sgn(w) exp(-|w|/Vs) + S s(w/Vc)

that is (3) with a shape factor of one; viscous friction that may differ by direction, ``sigma + b`` forward and
``sigma - b`` backward; and viscous friction that may saturate, as that of harmonic drives does: steep at low speed, by
``S`` higher than Coulomb friction and with the slope ``sigma`` at high speed; ``s`` is ``tanh(x)``, the slower
``sgn(x) (1 - exp(-|x|))``, or ``x/(1 + |x|)``, which has the longest tail. Coulomb friction that differs by
direction is an offset as long as the joint slides, and cannot be separated from one. Friction and forces over position
and load are further linear terms where they are asked for, see :mod:`adaptive_ff.identify.maps.map_columns`.
"""

import math
from collections.abc import Mapping, Sequence
from typing import NamedTuple

import numpy as np

from adaptive_ff.identify.rows.band import transferred
from adaptive_ff.identify.rows.filtering import Conditioned
from adaptive_ff.identify.rows.sampled_lag import sampled_share
from adaptive_ff.identify.terms import BENT, DAMPING, DIRECT, FORCE_OVER
from adaptive_ff.logs.derivatives import Array

FEWEST_REVERSALS, SMALLEST_SHARE = 2, 0.25
"""Reversals in motion, and how many over those at which the joint stands, from which on a log shows a friction lag."""


BOTH_WAYS = 0.02
"""Share of the rows that the rarer direction must have for the joint to count as moving both ways."""


class Problem(NamedTuple):
    """What is regressed.

    Attributes
    ----------
    pieces : sequence of Conditioned
        Rows of the pieces.
    speeds : mapping of ndarray, shape (k,)
        Grid of speeds of each bent term, rad/s.
    longest_lag : float
        Largest friction lag that is looked for, s.
    noise : dict of float
        Variance of the noise of a column, by its term.
    unlagged : sequence of str
        Terms of friction that do not lag where the others do.
    path : float
        Path over which friction of these rows follows, rad; zero where it jumps.
    """

    pieces: Sequence[Conditioned]
    speeds: Mapping[str, Array]
    longest_lag: float
    noise: Mapping[str, float] = {}
    unlagged: Sequence[str] = ()
    path: float = 0.0

    @property
    def rows(self) -> int:
        """Number of rows that are regressed."""
        return sum(int(np.count_nonzero(piece.slides)) for piece in self.pieces)

    @property
    def moves_both_ways(self) -> bool:
        """Whether the joint moves both ways; else an offset cannot be told from Coulomb friction."""
        direction = np.concatenate([piece.direction[piece.slides] for piece in self.pieces])
        return bool(min(np.mean(direction > 0.5), np.mean(direction < -0.5)) >= BOTH_WAYS)

    @property
    def shows_lag(self) -> bool:
        """Whether the joint reverses in motion, which alone tells a lag from an inertia smaller by ``sigma lag``."""
        turns, stops = sum(piece.reversals for piece in self.pieces), sum(piece.stops for piece in self.pieces)
        return turns >= max(FEWEST_REVERSALS, SMALLEST_SHARE * stops)


def measured_torque(problem: Problem) -> Array:
    """Return the torque of the regressed rows, shape (rows,)."""
    return np.concatenate([piece.moving_torque[piece.slides] for piece in problem.pieces])


def design(problem: Problem, terms: Sequence[str], searched: Mapping[str, float]) -> Array:
    """Return the columns of linear terms on the regressed rows, shape (rows, terms); see ``piece_columns``."""
    return np.concatenate(
        [
            piece_columns(piece, problem.speeds, terms, searched, problem.unlagged)[piece.slides]
            for piece in problem.pieces
        ]
    )


def path_slope(problem: Problem, values: Mapping[str, float]) -> Array:
    """Return the derivative of the torque of a model, by the values of its terms, by the logarithm of the path."""
    made, lag = [], values.get("friction_lag", 0.0)
    for piece in problem.pieces:
        parts = [
            values[term] * _of_term(slopes, problem.speeds, term, values)
            for term, slopes in piece.path_slopes.items()
            if term in values
        ]
        slope: Array = np.sum(parts, axis=0)
        if lag != 0.0:
            slope = transferred(slope, lambda s: 1.0 / (1.0 + lag * s), piece.period)
        made.append(slope[piece.slides])
    return np.concatenate(made)


def piece_columns(
    piece: Conditioned,
    speeds: Mapping[str, Array],
    terms: Sequence[str],
    searched: Mapping[str, float],
    unlagged: Sequence[str] = (),
) -> Array:
    """Return the columns of linear terms on all rows of a piece.

    Parameters
    ----------
    piece : Conditioned
        The rows.
    speeds : mapping of ndarray, shape (k,)
        Grid of speeds of each bent term, rad/s.
    terms : sequence of str
        Linear terms.
    searched : mapping of float
        ``friction_lag`` (s, zero where it is not given; a negative one leads), ``stribeck_velocity`` and
        ``saturation_velocity`` (rad/s).
    unlagged : sequence of str
        Terms of friction that do not lag.

    Returns
    -------
    ndarray, shape (rows, terms)
        One column for each term.
    """
    lag = searched.get("friction_lag", 0.0)
    made = []
    for term in terms:
        if term in DIRECT or term.startswith(FORCE_OVER):
            made.append(direct_column(piece, term))
        else:
            made.append(_lagged(piece, speeds, term, searched, 0.0 if term in unlagged else lag))
    return np.column_stack(made)


def _lagged(
    piece: Conditioned, speeds: Mapping[str, Array], term: str, searched: Mapping[str, float], lag: float
) -> Array:
    """Return the column of a term of friction with its lag, as it is sampled.

    Friction that lags is ``L x``, ``lag (L x)' + L x = x``, and what is regressed of it is ``m L x``, with ``m`` one
    where the joint moves. From ``lag (m L x)' + m L x = m x + lag m' L x`` it is ``L (m x + lag m' x)`` where friction
    beside a rest has had the time to follow: the impulses ``m' x`` are those at the edges of the motions.
    """
    column = friction_column(piece, speeds, term, searched)
    if lag == 0.0:
        return column
    between, edges = (
        _of_term(series[term], speeds, term, searched) if term in series else 0.0
        for series in (piece.between, piece.edges)
    )
    mean = transferred(column - between + lag * edges, lambda s: 1.0 / (1.0 + lag * s), piece.period)
    return mean + sampled_share(piece.sample_time, lag) * between


def direct_column(piece: Conditioned, term: str) -> Array:
    """Return the column of a term that does not lag."""
    if term in piece.mapped:
        return piece.mapped[term]
    if term == "offset":
        return piece.moves
    column = {
        "inertia": piece.acceleration,
        "gravity_sine": piece.sine,
        "gravity_cosine": piece.cosine,
        DAMPING: piece.bristle_rate,
    }[term]
    assert column is not None
    return column


def friction_column(piece: Conditioned, speeds: Mapping[str, Array], term: str, searched: Mapping[str, float]) -> Array:
    """Return the column of a term of friction, before its lag."""
    if term in piece.mapped:
        return piece.mapped[term]
    straight = {"coulomb": piece.direction, "viscous": piece.velocity, "viscous_asymmetry": piece.speed}
    return straight[term] if term in straight else _of_term(piece.bent[term], speeds, term, searched)


def _of_term(series: Array, speeds: Mapping[str, Array], term: str, searched: Mapping[str, float]) -> Array:
    """Return a series of a term of friction; of a bent one at its bend, between those of its grid."""
    return _at_bend(series, speeds[term], searched[BENT[term]]) if term in BENT else series


def _at_bend(columns: Array, grid: Array, bend: float) -> Array:
    """Return a column at a bend between those of its grid."""
    ratio = math.log(bend / grid[0]) / math.log(grid[1] / grid[0])
    place = min(max(math.floor(ratio), 1), grid.size - 3)
    x = ratio - place  # cubic of Lagrange through four neighbours of the grid
    weights = [-x * (x - 1) * (x - 2) / 6, (x + 1) * (x - 1) * (x - 2) / 2]
    weights += [-(x + 1) * x * (x - 2) / 2, (x + 1) * x * (x - 1) / 6]
    column: Array = np.array(weights) @ columns[place - 1 : place + 3]
    return column
