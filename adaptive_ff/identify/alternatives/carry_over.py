"""Whether a model of another family says what was held out, where the chosen one does not.

Only where none does may the machine be blamed: a model with terms too many is worse on other motion, too. One that is
poor everywhere, as one without gravity where there is gravity, is no worse there either, and tells nothing.
"""

from adaptive_ff.identify.fitting.families import family_of
from adaptive_ff.identify.fitting.fit import fit_terms
from adaptive_ff.identify.fitting.prediction import TorqueError, predict, torque_error
from adaptive_ff.identify.fitting.term_selection import Selection
from adaptive_ff.identify.rows.regressors import Problem
from adaptive_ff.identify.terms import BENT, LAG, Terms

ENOUGH = 1.5
"""Error on what was held out, over that of the fit, up to which a model carries over; and error of the fit over that of
the chosen model, up to which one counts that leaves more than the chosen one of what was held out, too."""


def carries_over(
    problem: Problem,
    held: Problem,
    selection: Selection,
    fit: TorqueError,
    validation: TorqueError,
    confidence: float,
) -> tuple[Terms, TorqueError] | None:
    """Return the model that is best on what was held out, if it is not much worse there; None where there is none.

    Of each family the simplest model and the one that validates best on the fitted part are tried. Those that leave
    more than the chosen one on both parts, and clearly more on the fitted one, do not count.

    Parameters
    ----------
    problem, held : Problem
        The rows that were fitted, and those that were held out.
    selection : Selection
        The models.
    fit, validation : TorqueError
        Errors of the chosen model on both.
    confidence : float
        Probability that the intervals are meant to have.
    """
    tried: dict[Terms, None] = {}
    families: dict[Terms, list[Terms]] = {}
    for model in sorted(selection.validated, key=lambda model: model.error):
        families.setdefault(family_of(model.terms), []).append(model.terms)
    for members in families.values():
        tried.update(dict.fromkeys((members[0], min(members, key=len))))
    starts = {model.terms: model.start for model in selection.validated}
    found = []
    for terms in tried:
        point = starts[terms]
        try:
            start = {LAG: point.lag, **dict.fromkeys(BENT.values(), point.speed)}
            fitted = fit_terms(problem, terms, confidence, start=start)
        except ValueError:
            continue  # not determined by the rows
        errors = torque_error(predict(problem, fitted)), torque_error(predict(held, fitted))
        if errors[0] is None or errors[1] is None or errors[1].rms_error > ENOUGH * errors[0].rms_error:
            continue
        if errors[1].rms_error < validation.rms_error or errors[0].rms_error <= ENOUGH * fit.rms_error:
            found.append((terms, errors[1]))
    return min(found, key=lambda pair: pair[1].rms_error, default=None)
