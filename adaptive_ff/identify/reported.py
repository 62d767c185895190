"""Parameters of the report: which are told by the log, and which are part of the model."""

from adaptive_ff.estimation.batch_least_squares import Estimate
from adaptive_ff.identify.fit import Fitted
from adaptive_ff.identify.result import Reported
from adaptive_ff.identify.term_selection import BASE, BESIDE, Selection

SIGNED = ("offset", BESIDE)
"""Parameters that may be negative."""


def reported(selection: Selection) -> dict[str, Reported]:
    """Return all parameters that could be estimated, by name, in the order of a report."""
    chosen = selection.chosen
    parameters = {}
    for name in BASE:
        if name in chosen.values:
            estimate = chosen.estimate(name)
            parameters[name] = Reported(estimate, _is_apart(estimate, name), True)
    for term, names in (("friction_lag", ("friction_lag",)), ("stiction_excess", ("stiction", "stribeck_velocity"))):
        fitted = _holding(selection, term)
        if fitted is not None:
            told = fitted is chosen
            parameters.update({name: Reported(fitted.estimate(name), told, told) for name in names})
    if BESIDE in selection.tried:
        estimate = selection.tried[BESIDE].estimate(BESIDE)
        parameters[BESIDE] = Reported(estimate, _is_apart(estimate, BESIDE), False)
    return parameters


def _holding(selection: Selection, term: str) -> Fitted | None:
    """Return the fit that holds an added term."""
    return selection.chosen if term in selection.chosen.terms else selection.tried.get(term)


def _is_apart(estimate: Estimate, name: str) -> bool:
    """Tell whether an interval does not hold zero, and is on the side where the parameter can be."""
    return estimate.lower > 0.0 or (name in SIGNED and estimate.upper < 0.0)
