"""Why a model is much worse on what was held out: units, other terms, another load, or another machine there."""

from typing import NamedTuple

from adaptive_ff.identify.alternatives.carry_over import carries_over
from adaptive_ff.identify.alternatives.held_out_error import error_with_other_load, has_changed
from adaptive_ff.identify.alternatives.other_units import other_units
from adaptive_ff.identify.fitting.prediction import TorqueError
from adaptive_ff.identify.fitting.term_selection import Selection
from adaptive_ff.identify.rows.regressors import Problem
from adaptive_ff.identify.terms import Terms


class Reasons(NamedTuple):
    """Fields of the result that say why, see :class:`adaptive_ff.identify.result.LogIdentification`."""

    other_units: str | None
    carries_over: tuple[Terms, TorqueError] | None
    has_other_load: bool
    has_changed: bool


def reasons(
    problem: Problem, held: Problem, selection: Selection, fit: TorqueError, validation: TorqueError, *, of_log: bool
) -> Reasons:
    """Return why a model is much worse on what was held out, which may be of another log.

    Parameters
    ----------
    problem, held : Problem
        The rows that were fitted, and those that were held out.
    selection : Selection
        The models.
    fit, validation : TorqueError
        Errors of the chosen model on both.
    of_log : bool
        Whether what was held out is another log.
    """
    confidence = selection.chosen.regression.confidence
    foreign = other_units(problem, held) if of_log else None
    carrying = carries_over(problem, held, selection, fit, validation, confidence)
    loaded = None if foreign else error_with_other_load(held, selection, fit, validation)
    if loaded is not None and carrying is not None:
        loaded, carrying = (loaded, None) if loaded < carrying[1].rms_error else (None, carrying)
    is_unexplained = not foreign and loaded is None and carrying is None
    changed = is_unexplained and has_changed(held, selection, fit, validation, confidence)
    return Reasons(foreign, carrying, loaded is not None, changed)
