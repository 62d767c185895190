"""Whether the torque of a log acts later than its stamp says, as one that a drive holds until the next sample does.

A torque that is stamped when it is commanded, and held for a period, acts half a period later in the mean. Taken as one
that acts at its stamp it puts ``J delay`` times the jerk into the balance. Where a joint stands at its reversals, so
that only friction that rises with the speed shows a lag, a lag of ``sqrt(J delay / sigma)`` does the same, and makes
inertia too large by ``sigma`` times that: of a joint of 0.5 kg m^2 and 1.5 N m s/rad by 5 % for a delay of 1 ms, with
an interval of a tenth of that. So the chosen terms are fitted once more, without their lag, to the torque half a period
later; nothing else of the rows depends on it. Where that does as well as a lag, intervals are taken over it, too.

A log may have fewer rows than the drive has periods, and then the delay is any part of half a sample time: so, in the
place of such a lag, the delay that it amounts to is tried as well.
"""

import math
import sys
from typing import NamedTuple

import numpy as np

from adaptive_ff.identify.fitting.fit import fit_terms
from adaptive_ff.identify.fitting.fitted import Fitted
from adaptive_ff.identify.fitting.grid import BLOCKS
from adaptive_ff.identify.fitting.term_selection import Selection
from adaptive_ff.identify.preparation import Prepared
from adaptive_ff.identify.rows.filtering import moving_torque
from adaptive_ff.identify.rows.regressors import Problem
from adaptive_ff.identify.terms import LAG
from adaptive_ff.logs.defects import Piece

DEVIATIONS, LESS = 3.0, 0.05
"""Standard errors of the difference between both fits, over blocks of rows, and share of the squares, by which a torque
must fit better as one that is held; in the place of a friction lag it need not fit worse, with a parameter less."""


class Later(NamedTuple):
    """A fit to a torque that acts later than its stamp.

    Attributes
    ----------
    delay : float
        Time after its stamp at which it acts, s.
    fitted : Fitted
        The chosen terms without a lag.
    """

    delay: float
    fitted: Fitted


def fit_if_held(problem: Problem, prepared: Prepared, pieces: list[Piece], selection: Selection) -> Later | None:
    """Return the fit to a torque that is held, where it seems to be and friction does not seem to lead; else None.

    Parameters
    ----------
    problem : Problem
        The rows, of the torque at its stamps.
    prepared : Prepared
        The log that they come from.
    pieces : list of Piece
        Its pieces, in the order of the problem's.
    selection : Selection
        What was chosen.
    """
    chosen = selection.chosen
    if selection.lead > prepared.period:
        return None
    later: Later | None = None
    for delay in [0.5 * prepared.period] + ([] if problem.shows_lag else _delays_like_lag(chosen)):
        fitted = fit_later(problem, prepared, pieces, chosen, delay)
        if fitted is not None and (later is None or is_clearly_less(gain(later.fitted, fitted), DEVIATIONS)):
            later = Later(delay, fitted)
    if later is None:
        return None
    less = gain(chosen, later.fitted)
    return later if (less[0] > 0.0 if LAG in chosen.terms else is_clearly_less(less, DEVIATIONS)) else None


def is_clearly_less(less: tuple[float, float], deviations: float) -> bool:
    """Tell whether a fit leaves less by so many standard errors, and enough, from what ``gain`` says of it."""
    return less[0] > max(deviations * less[1], LESS)


def _delays_like_lag(chosen: Fitted) -> list[float]:
    """Return the delay of the torque, s, that a lag of viscous friction alone amounts to; none without such a lag."""
    lag, viscous = chosen.values.get(LAG, 0.0), chosen.values["viscous"]
    inertia = chosen.values["inertia"] - viscous * lag
    delay = viscous * lag**2 / inertia if inertia > 0.0 else 0.0
    return [delay] if 0.0 < delay < lag else []


def fit_later(problem: Problem, prepared: Prepared, pieces: list[Piece], chosen: Fitted, delay: float) -> Fitted | None:
    """Return the fit of the terms of a model but its lag to the torque so many s later; None where there is none."""
    terms = tuple(term for term in chosen.terms if term != LAG)
    rows = rows_of_later(problem, prepared, pieces, delay)
    try:
        return fit_terms(rows, terms, chosen.regression.confidence, start=chosen.values)
    except ValueError:
        return None


def rows_of_later(problem: Problem, prepared: Prepared, pieces: list[Piece], delay: float) -> Problem:
    """Return the rows with the torque of so many s later."""
    log, band, period, rest = prepared.log, prepared.bandwidth, prepared.period, prepared.rest
    made = [
        rows._replace(moving_torque=moving_torque(log, piece, band, period, rest, delay))
        for piece, rows in zip(pieces, problem.pieces, strict=True)
    ]
    return problem._replace(pieces=made)


def gain(chosen: Fitted, later: Fitted) -> tuple[float, float]:
    """Return which share of its squares a model leaves less as fitted to a later torque, and the standard error."""
    less = np.square(chosen.regression.residuals) - np.square(later.regression.residuals)
    blocks = np.array([float(np.sum(block)) for block in np.array_split(less, BLOCKS)])
    blocks /= max(chosen.squares, sys.float_info.min)
    return float(np.sum(blocks)), math.sqrt(BLOCKS * float(np.var(blocks, ddof=1)))
