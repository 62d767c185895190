"""Rows and model of a log: which rows are regressed, which terms the model has, whether there is a map or a ripple."""

from collections.abc import Callable
from functools import partial
from typing import NamedTuple

from adaptive_ff.errors import InputError, counted
from adaptive_ff.identify.alternatives.bristle_path import lacks_much, select_over_path
from adaptive_ff.identify.fitting.families import AUTO
from adaptive_ff.identify.fitting.term_selection import Selection, select_terms
from adaptive_ff.identify.maps.map_columns import MapAsked, MapBasis
from adaptive_ff.identify.maps.map_selection import select_map
from adaptive_ff.identify.maps.ripple import ripple_period
from adaptive_ff.identify.preparation import Prepared, regression_problem
from adaptive_ff.identify.rows.regressors import Problem
from adaptive_ff.identify.terms import is_mapped, jumps_at_reversal
from adaptive_ff.logs.defects import Piece
from adaptive_ff.logs.log import Log

FEWEST_ROWS = 30
"""Rows at which the joint slides that a fit needs."""


class Chosen(NamedTuple):
    """Rows that are fitted, the models that were compared on them, and the map that was asked for, or found."""

    prepared: Prepared
    problem: Problem
    selection: Selection
    basis: MapBasis | None
    asked: MapAsked


def choose_model(
    prepared: Prepared,
    fitting: list[Piece],
    torque_delay: float,
    asked: MapAsked,
    *,
    family: str,
    rotary: bool,
    located: bool,
    confidence: float,
) -> Chosen:
    """Choose rows and model of some pieces of a log, in which a ripple is looked for where all logs have positions."""
    problem = regression_problem(prepared, fitting, torque_delay)
    select = partial(_select, prepared.log, family=family, rotary=rotary, confidence=confidence)
    selection = select(problem)
    if jumps_at_reversal(selection.chosen.terms):  # so it may stick while it reverses
        prepared, problem, selection = _without_stops(select, prepared, fitting, torque_delay, problem, selection)
    jumping = selection
    prepared, problem, selection = select_over_path(select, prepared, fitting, problem, selection)
    basis: MapBasis | None = None
    if asked != MapAsked():
        problem, selection, basis = select_map(problem, prepared, fitting, selection, asked, confidence)
    elif family == AUTO and located:
        found = _with_ripple(problem, prepared, fitting, selection, confidence)
        if found is not None:
            problem, selection, basis = found
            asked = basis.asked
    if lacks_much(problem, selection.chosen):
        selection = selection._replace(jumping=jumping)
    return Chosen(prepared, problem, selection, basis, asked)


def _without_stops(
    select: Callable[[Problem], Selection],
    prepared: Prepared,
    fitting: list[Piece],
    torque_delay: float,
    problem: Problem,
    selection: Selection,
) -> tuple[Prepared, Problem, Selection]:
    """Leave out the rows in which a joint stands while it reverses; short stops only where it does not creep there."""
    might_creep = any(not jumps_at_reversal(other.terms) for other in selection.validated)
    again, compared = selection, problem.rows
    for dwells in (True, False) if might_creep else (False,):
        sticking = prepared._replace(rest=prepared.rest._replace(sticks=True, dwells=dwells))
        sliding = regression_problem(sticking, fitting, torque_delay)
        rows = sliding.rows
        if not FEWEST_ROWS <= rows < problem.rows:
            continue
        if rows != compared:  # else every stop is one that the sign tells, and the models are those of these rows
            again, compared = select(sliding), rows
        if not dwells or jumps_at_reversal(again.chosen.terms):  # else it creeps, which tells of its friction
            return sticking, sliding, again
    return prepared, problem, selection


def _with_ripple(
    problem: Problem, prepared: Prepared, fitting: list[Piece], selection: Selection, confidence: float
) -> tuple[Problem, Selection, MapBasis] | None:
    """Return rows, models and functions with a ripple over the position; None where the log shows none."""
    if selection.chosen.values["coulomb"] <= 0.0:
        return None
    period = ripple_period(problem, prepared, fitting, selection.chosen)
    if period is None:
        return None
    made = select_map(problem, prepared, fitting, selection, MapAsked((period,), found=True), confidence)
    return made if any(is_mapped(term) for term in made[1].chosen.terms) else None


def _select(log: Log, problem: Problem, *, family: str, rotary: bool, confidence: float) -> Selection:
    """Choose the terms of a model on some rows of a log, where there are enough of them."""
    if problem.rows < FEWEST_ROWS:
        raise InputError(
            f"{log.name}: the joint slides in {counted(problem.rows, 'row')} (five for each cycle of the band) only; "
            f"there must be at least {FEWEST_ROWS}"
        )
    try:
        return select_terms(
            problem, family=family, both_ways=problem.moves_both_ways, rotary=rotary, confidence=confidence
        )
    except InputError:
        raise
    except ValueError as error:
        raise InputError(f"{log.name}: the log does not determine a joint: {error}") from error


def has_positions(prepared: Prepared, validation: Log | None) -> bool:
    """Tell whether positions of a log are known, and where another one is given, those of both from the same zero.

    Velocities of a log without a gap add up to positions from its begin; those of two logs to two.
    """
    if prepared.log.position is not None:
        return validation is None or validation.position is not None
    return validation is None and len(prepared.pieces) == 1 and not prepared.skipped
