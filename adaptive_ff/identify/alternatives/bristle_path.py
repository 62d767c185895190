"""Whether friction follows the path of the joint since it reversed, instead of the time, and over which path.

Bristles, belts and seals bend before they slide. Where that takes more than a thousandth of the strokes, friction rises
after a reversal as the joint goes, slower where it reverses slowly, which no lag does: taken for a lag, inertia comes
out up to 15 % too large. So the terms that were chosen are fitted with friction that follows over a path
(:mod:`adaptive_ff.identify.rows.path_lag`) instead of a lag, over paths of up to a stroke, and the path of the least
squares is kept. Where it leaves clearly less than all models that the log did not tell apart, all models are
compared once more, with friction that follows over that path in each; where it only leaves no more than the chosen one,
intervals are taken over it, too.

A joint that sticks and slips has a stiction that the model over a path does not find, and Coulomb friction that is too
large for it. Where so much of the torque is left that noise does not explain it, intervals are taken over the models
that were compared before, too.
"""

import math
from collections.abc import Callable, Mapping, Sequence
from functools import partial
from typing import NamedTuple

import numpy as np
from scipy.optimize import minimize_scalar

from adaptive_ff.identify.alternatives.held_torque import gain, is_clearly_less
from adaptive_ff.identify.fitting.cross_validation import ALIKE
from adaptive_ff.identify.fitting.fit import fit_terms
from adaptive_ff.identify.fitting.fitted import Fitted
from adaptive_ff.identify.fitting.search import left_by_linear_terms
from adaptive_ff.identify.fitting.term_selection import Selection
from adaptive_ff.identify.maps.map_columns import band_along
from adaptive_ff.identify.preparation import Prepared
from adaptive_ff.identify.rows.band import Band
from adaptive_ff.identify.rows.filtering import condition, over_path
from adaptive_ff.identify.rows.path_lag import Bending, OverPath
from adaptive_ff.identify.rows.regressors import Problem, design, measured_torque
from adaptive_ff.identify.terms import BASE, BENT, DAMPING, JUMPING, LAG, PATH, STICTION, bent_friction
from adaptive_ff.logs.defects import Piece
from adaptive_ff.logs.derivatives import Array

SHORTEST, LONGEST, POINTS = 2e-4, 1.0, 11
"""Shortest and longest path that is looked for, over the mean stroke, and how many are tried first."""

CLOSE = 0.01
"""How closely the path is looked for, as a logarithm."""

PASSES = 3
"""How often the path is looked for with the terms chosen before."""

MOST_EXCESS = 3.0
"""Most of stiction above Coulomb friction, over that, by which bristles are taken to bend over more of a path."""

AROUND = 2.0 ** np.linspace(-2.0, 2.0, 5)
"""Paths that are tried around one, over it."""

LEAVES = 0.05
"""Share of the torque that is left, from which on a model over a path that lacks something is not taken to be right."""


class Bent(NamedTuple):
    """Rows whose friction follows over a path.

    Attributes
    ----------
    prepared : Prepared
        The log, with the path.
    problem : Problem
        The rows.
    fitted : Fitted
        The terms that were chosen, without their lag, fitted to them.
    is_clear : bool
        Whether that leaves clearly less than each of the models that the log does not tell from the best.
    """

    prepared: Prepared
    problem: Problem
    fitted: Fitted
    is_clear: bool


def select_over_path(
    select: Callable[[Problem], Selection],
    prepared: Prepared,
    pieces: Sequence[Piece],
    problem: Problem,
    selection: Selection,
) -> tuple[Prepared, Problem, Selection]:
    """Choose among models whose friction follows over a path, where the log shows that it does.

    Parameters
    ----------
    select : callable
        Chooses the model of some rows.
    prepared : Prepared
        The log.
    pieces : list of Piece
        Its pieces, in the order of the problem's.
    problem : Problem
        Their rows, of friction that jumps.
    selection : Selection
        What was chosen for these.
    """
    bent = fit_over_path(problem, prepared, pieces, selection)
    if bent is None or not bent.is_clear:
        return prepared, problem, selection._replace(bent=None if bent is None else bent.fitted)
    prepared, problem, selection = bent.prepared, bent.problem, select(bent.problem)
    fitted = selection.tried.get(STICTION, selection.chosen)  # which shows only on bristles as stiff at low speed
    for _ in range(PASSES):
        again = closer_path(problem, prepared, pieces, fitted)
        if again is not None:
            prepared, problem = again
            selection = select(problem)
        elif fitted is selection.chosen:
            break
        fitted = selection.chosen
    return prepared, problem, selection


def lacks_much(problem: Problem, chosen: Fitted) -> bool:
    """Tell whether a model over a path leaves much of the torque, and more than chance explains."""
    if PATH not in chosen.terms or not chosen.lacks:
        return False
    return math.sqrt(chosen.squares) > LEAVES * float(np.linalg.norm(measured_torque(problem)))


def fit_over_path(problem: Problem, prepared: Prepared, pieces: Sequence[Piece], selection: Selection) -> Bent | None:
    """Return rows whose friction follows over the best path; None where no path leaves as little as the chosen model.

    Parameters
    ----------
    problem : Problem
        The rows.
    prepared : Prepared
        The log that they come from.
    pieces : list of Piece
        Its pieces, in the order of the problem's.
    selection : Selection
        What was chosen.
    """
    chosen = selection.chosen
    if not problem.shows_lag:
        return None
    values = {name: value for name, value in chosen.values.items() if name != LAG}
    bands = [band_along(prepared, piece) for piece in pieces]
    squares = squares_over_paths(problem, bands, chosen.linear, values)
    bending = best_path(squares, [Bending(path) for path in _paths(problem, bands)], below=chosen.squares)
    if bending is None:
        return None
    terms = (*BASE, PATH, *(term for term in chosen.terms[len(BASE) :] if term != LAG))
    bent, rows = rows_over(problem, prepared, pieces, bending)
    try:
        fitted = fit_terms(rows, terms, chosen.regression.confidence, start=values)
    except ValueError:
        return None
    if gain(chosen, fitted)[0] <= 0.0 or fitted.values["coulomb"] <= 0.0:
        return None
    is_clear = all(is_clearly_less(gain(other, fitted), ALIKE) for other in selection.alike)
    return Bent(bent, rows, fitted, is_clear)


def closer_path(
    problem: Problem, prepared: Prepared, pieces: Sequence[Piece], chosen: Fitted
) -> tuple[Prepared, Problem] | None:
    """Return a log and its rows with the best path for a model; None where they have it already.

    The bristles are as stiff at low speed where the model has a stiction.
    """
    last, values = prepared.rest.bending, chosen.values
    assert last is not None
    bands = [band_along(prepared, piece) for piece in pieces]
    squares = squares_over_paths(problem, bands, chosen.linear, values)
    excess = max(values.get(STICTION, 0.0) / values["coulomb"], 0.0) if values["coulomb"] > 0.0 else 0.0
    known = Bending(last.path, min(excess, MOST_EXCESS), values.get(BENT[STICTION], last.speed))
    bending = best_path(squares, [known._replace(path=known.path * times) for times in AROUND])
    if bending is None or _is_alike(bending, last):
        return None
    return rows_over(problem, prepared, pieces, bending)


def _is_alike(one: Bending, other: Bending) -> bool:
    """Tell whether two paths are the same, as closely as they are looked for."""
    apart = max(abs(math.log(one.path / other.path)), abs(one.excess - other.excess))
    return apart < CLOSE and (one.excess == 0.0 or abs(math.log(one.speed / other.speed)) < CLOSE / one.excess)


def rows_over(
    problem: Problem, prepared: Prepared, pieces: Sequence[Piece], bending: Bending
) -> tuple[Prepared, Problem]:
    """Return a log and its rows with friction that follows over a path."""
    bent = prepared._replace(rest=prepared.rest._replace(bending=bending))
    made = [
        condition(bent.log, piece, bent.bandwidth, bent.period, bent.rest)._replace(moving_torque=rows.moving_torque)
        for piece, rows in zip(pieces, problem.pieces, strict=True)
    ]
    return bent, problem._replace(pieces=made, path=bending.path)


def best_path(
    squares: Callable[[Bending], float], paths: Sequence[Bending], *, below: float = math.inf
) -> Bending | None:
    """Return the path of the least squares, from the best of some; None where that is an end or leaves more."""
    tried = [squares(bending) for bending in paths]
    place = int(np.argmin(tried))
    if not 0 < place < len(paths) - 1 or tried[place] >= below:
        return None
    ends = math.log(paths[place - 1].path), math.log(paths[place + 1].path)

    def at(point: float) -> Bending:
        return paths[place]._replace(path=math.exp(point))

    found = minimize_scalar(lambda point: squares(at(point)), bounds=ends, method="bounded", options={"xatol": CLOSE})
    return at(float(found.x))


def _paths(problem: Problem, bands: Sequence[Band]) -> list[float]:
    """Return the paths that are tried, rad."""
    way = sum(float(np.sum(np.abs(band.velocity))) * band.period for band in bands)
    stroke = way / sum(piece.reversals for piece in problem.pieces)
    paths: list[float] = np.geomspace(SHORTEST * stroke, LONGEST * stroke, POINTS).tolist()
    return paths


def squares_over_paths(
    problem: Problem, bands: Sequence[Band], linear: Sequence[str], values: Mapping[str, float]
) -> Callable[[Bending], float]:
    """Return the least squares of some linear terms, as a function of the path over which friction follows.

    Parameters
    ----------
    problem : Problem
        The rows.
    bands : sequence of Band
        The filters of the pieces of the log that they come from, in the order of the problem's.
    linear : sequence of str
        The terms.
    values : mapping of float
        Speeds of bends (rad/s) by name; they stay.
    """
    target = measured_torque(problem)
    matrix = design(problem, ["offset" if term == DAMPING else term for term in linear], values)
    series: dict[int, Callable[[OverPath], Array]] = {
        linear.index("coulomb"): lambda over: over.at_samples(np.sign),
    }
    if DAMPING in linear:
        series[linear.index(DAMPING)] = OverPath.rate
    for term in JUMPING:
        if term in linear:
            shape = partial(bent_friction, term, bend=values[BENT[term]])
            series[linear.index(term)] = partial(OverPath.at_samples, static=shape)

    def squares(bending: Bending) -> float:
        first = 0
        for band, rows in zip(bands, problem.pieces, strict=True):
            over = over_path(band.velocity, band.period, bending)
            assert over is not None
            last = first + int(np.count_nonzero(rows.slides))
            for place, made in series.items():
                matrix[first:last, place] = band.filtered(made(over))[rows.slides]
            first = last
        residual = left_by_linear_terms(matrix, target)
        return float(residual @ residual)

    return squares
