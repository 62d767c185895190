"""Which terms of the friction model a log tells."""

from typing import NamedTuple

import numpy as np

from adaptive_ff.identify.fit import SEARCHED, Fitted, at_end_of_range, fit_terms
from adaptive_ff.identify.regressors import Problem, design, measured_torque

BASE = ("inertia", "coulomb", "viscous", "offset")
"""Terms of every model."""

ADDED = ("friction_lag", "stiction_excess")
"""Terms that are added where the log tells them, and that the simulated joint has, too."""

BESIDE = "viscous_asymmetry"
"""Term that is estimated beside the model, and not used in it: the simulated joint is the same in both directions."""


class Selection(NamedTuple):
    """What was fitted.

    Attributes
    ----------
    chosen : Fitted
        The model.
    tried : dict of Fitted
        The model with a further term, by that term: those that were not told, and the asymmetry.
    refused : dict of str
        Terms that could not be fitted, and why.
    """

    chosen: Fitted
    tried: dict[str, Fitted]
    refused: dict[str, str]


def select_terms(problem: Problem, *, both_ways: bool, confidence: float) -> Selection:
    """Fit the base model, and add one by one the terms that the log tells.

    A term is told where its interval lies above zero, what was searched for it does not end where the search does, and
    it foretells: fitted to either half of the rows, it lowers the residual of the other. (On short logs of robots
    intervals alone let terms in that made the validation worse.) Of several the one that lowers the residual most comes
    first.

    Parameters
    ----------
    problem : Problem
        The rows.
    both_ways : bool
        Whether the joint moves both ways; else an offset is no term, as it cannot be told from Coulomb friction.
    confidence : float
        Probability that the intervals are meant to have.

    Raises
    ------
    ValueError
        The rows do not tell the terms of the base model from each other.
    """
    chosen = fit_terms(problem, BASE if both_ways else BASE[:-1], confidence)
    tried: dict[str, Fitted] = {}
    refused: dict[str, str] = {}
    left = list(ADDED)
    while left:
        for term in left:
            _try(problem, chosen, term, confidence, tried, refused)
        told = [
            term
            for term in left
            if term in tried
            and is_told(problem, tried[term], term)
            and foretells(problem, chosen.terms, (*chosen.terms, term), confidence)
        ]
        if not told:
            break
        best = min(told, key=lambda term: tried[term].squares)
        chosen = tried.pop(best)
        left.remove(best)
    for term in [term for term in chosen.terms if term in ADDED and not is_told(problem, chosen, term)]:
        tried[term] = chosen  # a later term explains what this one did
        chosen = fit_terms(problem, tuple(name for name in chosen.terms if name != term), confidence)
    if both_ways:
        _try(problem, chosen, BESIDE, confidence, tried, refused)
    return Selection(chosen, tried, refused)


def is_told(problem: Problem, fitted: Fitted, term: str) -> bool:
    """Tell whether a log tells an added term."""
    searched = SEARCHED[term]
    return fitted.estimate(term).lower > 0.0 and not at_end_of_range(problem, searched, fitted.values[searched])


def foretells(problem: Problem, fewer: tuple[str, ...], more: tuple[str, ...], confidence: float) -> bool:
    """Tell whether more terms, fitted to one half of the rows, lower the residual of the other half."""
    times = np.concatenate([piece.time[piece.slides] for piece in problem.pieces])
    order = np.cumsum([0, *(int(np.count_nonzero(piece.slides)) for piece in problem.pieces)])
    middle = times.size // 2
    halves = []
    for side in (False, True):
        pieces = []
        for start, piece in zip(order[:-1], problem.pieces, strict=True):
            rank = start + np.cumsum(piece.slides) - 1
            pieces.append(piece._replace(slides=piece.slides & ((rank >= middle) == side)))
        halves.append(problem._replace(pieces=pieces))
    squares = []
    for terms in (fewer, more):
        total = 0.0
        for fitted_to, other in (halves, halves[::-1]):
            try:
                fitted = fit_terms(fitted_to, terms, confidence)
            except ValueError:
                return False  # half of the rows do not tell the terms from each other
            values = np.array([fitted.values[name] for name in fitted.linear])
            residual = measured_torque(other) - design(other, fitted.linear, fitted.searched) @ values
            total += float(residual @ residual)
        squares.append(total)
    return squares[1] < squares[0]


def _try(
    problem: Problem,
    chosen: Fitted,
    term: str,
    confidence: float,
    tried: dict[str, Fitted],
    refused: dict[str, str],
) -> None:
    tried.pop(term, None)
    refused.pop(term, None)
    try:
        tried[term] = fit_terms(problem, (*chosen.terms, term), confidence)
    except ValueError as error:
        refused[term] = str(error)
