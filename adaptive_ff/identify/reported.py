"""Parameters of the report: which are identifiable, which are part of the model, and which are confounded."""

import math
import sys
from typing import NamedTuple

from adaptive_ff.identify.fitting.fitted import Fitted
from adaptive_ff.identify.fitting.term_selection import Selection
from adaptive_ff.identify.terms import (
    ASYMMETRY,
    BASE,
    BENT,
    GRAVITY,
    LAG,
    PATH,
    SATURATIONS,
    SQUARE_STICTION,
    STICTION,
    is_mapped,
    mapped_word,
)
from adaptive_ff.learning.batch_least_squares import Estimate

SIGNED = ("offset", ASYMMETRY, *GRAVITY)
"""Parameters that may be negative."""

NEUTRAL = (LAG, ASYMMETRY, *GRAVITY)
"""Parameters that a model without them has as zero."""

VAGUE = 0.25
"""Half width of an interval over its value, from which a parameter counts as confounded where another one moves it."""

TIED = 0.95
"""Correlation of two estimates from which they count as tied to each other."""

SLOW = math.exp(-1.0)
"""Share of the stiction above Coulomb friction that a log shows where the joint is as slow as the Stribeck velocity."""

UNTIED = math.sqrt(1.0 - TIED**2)
"""What knowing one of them leaves of the interval of the other."""


def interval_words(estimate: Estimate, digits: int) -> tuple[str, str]:
    """Return the ends of an interval as they are printed, with so many digits."""
    lower, upper = (f"{end:.{digits}g}" if math.isfinite(end) else "∞" for end in (estimate.lower, estimate.upper))
    return lower, upper


class Reported(NamedTuple):
    """A parameter of the report.

    Attributes
    ----------
    estimate : Estimate
        Value and interval.
    identifiable : bool
        Whether the log determines it: its interval does not hold zero, and what is negative can be.
    used : bool
        Whether it is part of the model that was validated.
    confounded : tuple of str
        Terms between which and this parameter the log does not decide, where its interval is wide for that.
    """

    estimate: Estimate
    identifiable: bool
    used: bool
    confounded: tuple[str, ...] = ()

    @property
    def holds_zero(self) -> bool:
        """Whether zero lies in the interval."""
        return self.estimate.lower <= 0.0 <= self.estimate.upper

    @property
    def is_known(self) -> bool:
        """Whether the log determines it by itself."""
        return self.identifiable and self.used and not self.confounded and not self.holds_zero


def reported(selection: Selection) -> dict[str, Reported]:
    """Return all parameters that could be estimated, by name, in the order of a report."""
    parameters: dict[str, Reported] = {}
    for name in (*BASE, "offset", *GRAVITY):
        if name in selection.chosen.parameters:
            apart = _is_apart(selection.interval(name), name)
            parameters[name] = Reported(_interval(selection, name), apart, True, _confounded(selection, name))
    for term, names in (
        (LAG, (LAG,)),
        (PATH, (PATH,)),
        (STICTION, ("stiction", BENT[STICTION])),
        *((shape, (shape, BENT[shape])) for shape in SATURATIONS),
        (ASYMMETRY, (ASYMMETRY,)),
        *((name, (name,)) for name in GRAVITY),
    ):
        for name in names:
            entry = _added(selection, term, name)
            if entry is not None and name not in parameters:
                parameters[name] = entry
    return parameters


def _added(selection: Selection, term: str, name: str) -> Reported | None:
    """Return a parameter that a term brings; where the model does without it, the estimate beside the model."""
    if term in selection.chosen.terms:
        confounded = _confounded(selection, name)
        if name == BENT.get(term) and _vanishes(selection, term):
            confounded = tuple(dict.fromkeys((term, *confounded)))  # of a term that may not be there, it is none
        return Reported(_interval(selection, name), True, True, confounded)
    fitted: Fitted | None = selection.tried.get(term)
    if fitted is None or name not in fitted.parameters:
        return None
    return Reported(fitted.estimate(name), False, False, ())


def _vanishes(selection: Selection, term: str) -> bool:
    """Tell whether the interval of a term of the model holds zero."""
    is_reported = term in selection.chosen.parameters
    estimate = selection.interval(term) if is_reported else selection.chosen.estimate(term)
    return bool(estimate.lower <= 0.0)


def _interval(selection: Selection, name: str) -> Estimate:
    """Return a parameter of the model with an interval over all models that are alike, those without it, too."""
    estimate = _as_far_as_slow(selection, name)
    if not _without(selection, name):
        return estimate
    return estimate._replace(lower=min(estimate.lower, 0.0), upper=max(estimate.upper, 0.0))


def _as_far_as_slow(selection: Selection, name: str) -> Estimate:
    """Return a parameter with an interval over all models; that of a stiction begins at the friction that was seen.

    Where the joint is nowhere as slow as the Stribeck velocity, the rest of the stiction is what its shape makes of
    the begin of the rise: a friction that rises no further has a stiction of what was seen, and a Stribeck velocity of
    the slowest speed.
    """
    estimate, shown = selection.interval(name), selection.chosen.shown
    if shown < SLOW and name == "stiction":
        seen = selection.interval("coulomb").lower + shown * selection.chosen.values[STICTION]
        return estimate._replace(lower=min(estimate.lower, seen))
    if shown < SLOW and name == BENT[STICTION]:
        return estimate._replace(upper=max(estimate.upper, -math.log(max(shown, sys.float_info.min)) * estimate.upper))
    return estimate


def _without(selection: Selection, name: str) -> list[Fitted]:
    """Return the models that are alike and have a parameter of the chosen one as zero."""
    if name not in NEUTRAL or name not in selection.chosen.parameters:
        return []
    return [other for other in selection.allowed if name not in other.parameters]


def _is_apart(estimate: Estimate, name: str) -> bool:
    """Tell whether an interval does not hold zero, and is on the side where the parameter can be."""
    return bool(estimate.lower > 0.0 or (name in SIGNED and estimate.upper < 0.0))


def _confounded(selection: Selection, name: str) -> tuple[str, ...]:
    """Return the terms that move a parameter by so much that its interval is vague.

    These are terms that some of the models have, between which the log does not decide, and others have not.
    """
    estimate = _interval(selection, name)
    own, sides = selection.chosen, (estimate.value - estimate.lower, estimate.upper - estimate.value)
    extrapolated = name in ("stiction", BENT[STICTION]) and own.shown < SLOW
    if (max(sides) if extrapolated else 0.5 * sum(sides)) < VAGUE * abs(estimate.value):
        return ()
    bound = 0.5 * (own.estimate(name).upper - own.estimate(name).lower)
    found: dict[str, None] = {}
    for other in selection.allowed[1:]:
        if name in other.parameters and abs(other.estimate(name).value - estimate.value) > 0.5 * bound:
            unlike = {*own.terms} ^ {*other.terms}
            if SQUARE_STICTION in unlike:
                unlike.discard(STICTION)  # one shape instead of the other
            found.update(dict.fromkeys(sorted(unlike)))
    for other in _without(selection, name):
        found.update(dict.fromkeys(_moved(own, other)))
    found.update(dict.fromkeys([*_tied(own, name), *_bent(selection, name)]))
    if extrapolated:
        found[SQUARE_STICTION] = None
    terms = (mapped_word(term) if is_mapped(term) else term for term in found if term != name)
    return tuple(dict.fromkeys(terms))


def _moved(own: Fitted, other: Fitted) -> list[str]:
    """Return the parameters that another model has elsewhere, beyond the interval of one of them."""
    pairs = ((name, own.estimate(name), other.estimate(name)) for name in own.linear if name in other.linear)
    return [name for name, first, second in pairs if not first.lower <= second.value <= first.upper]


def _tied(fitted: Fitted, name: str) -> list[str]:
    """Return the parameters whose estimates go up and down with that of a parameter."""
    names = fitted.regression.names
    if name not in names:
        return []
    place, errors = names.index(name), fitted.regression.standard_errors
    row = fitted.regression.covariance[place]
    return [
        other
        for other, covariance, error in zip(names, row, errors, strict=True)
        if other != name and abs(covariance) > TIED * errors[place] * error
    ]


def _bent(selection: Selection, name: str) -> list[str]:
    """Return the saturation of the model, where a parameter's interval is wide for its shapes and bends.

    That is where, were both known, the interval would be as much narrower as that of an estimate which is tied.
    """
    own = selection.chosen
    names, covariance = own.regression.names, own.regression.covariance
    shapes = [term for term in SATURATIONS if term in own.terms and term != name and name in names]
    if not shapes or name == BENT[shapes[0]]:
        return []
    place, bend = names.index(name), names.index(BENT[shapes[0]])
    lower, upper = selection.ends(own, name)
    estimate = own.estimate(name)
    known = math.sqrt(
        max(1.0 - covariance[place, bend] ** 2 / (covariance[place, place] * covariance[bend, bend]), 0.0)
    )
    return shapes if known * (estimate.upper - estimate.lower) < UNTIED * (upper - lower) else []
