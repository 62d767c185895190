"""Which terms of the friction model a log supports: by blocked cross-validation, with intervals over what remains."""

import math
from collections.abc import Sequence
from contextlib import suppress
from typing import NamedTuple

import numpy as np

from adaptive_ff.identify.fitting.cross_validation import ALIKE, Validated, behind, choose, cross_validate, within
from adaptive_ff.identify.fitting.families import candidate_models
from adaptive_ff.identify.fitting.fit import fit_terms
from adaptive_ff.identify.fitting.fitted import Fitted
from adaptive_ff.identify.fitting.grid import BLOCKS, Grid, make_grid
from adaptive_ff.identify.fitting.grid_fit import LEAD, Point, fit_on_grid
from adaptive_ff.identify.fitting.shape_profile import Profile, profile_interval, shape_profiles
from adaptive_ff.identify.rows.regressors import Problem
from adaptive_ff.identify.terms import (
    ASYMMETRY,
    BASE,
    BENT,
    DAMPING,
    GRAVITY,
    LAG,
    PATH,
    SATURATION,
    SATURATIONS,
    SLOW_SATURATION,
    SQUARE_STICTION,
    STICTION,
    Terms,
)
from adaptive_ff.learning.batch_least_squares import Estimate

COLLINEAR = 5.0
"""Variance of an inertia over that without the other columns, from which on they are not told apart safely.

Logs of several sines have 3 at most, those of a single one 6 to 900, and inertia up to ten times the true one with an
interval of a tenth of it.
"""

ADDED = (LAG, STICTION, SATURATION, SLOW_SATURATION, ASYMMETRY, *GRAVITY)
"""Terms that are estimated beside the model, too, where it does without them."""


class Selection(NamedTuple):
    """What was fitted.

    Attributes
    ----------
    chosen : Fitted
        The model.
    alike : list of Fitted
        All models that the log cannot tell from the one that validates best, the chosen one first.
    tried : dict of Fitted
        The chosen model with a further term, by that term.
    refused : dict of str
        Terms that could not be fitted, and why.
    models : sequence of tuple of str
        The terms of every model that was allowed.
    validated : list of Validated
        Those of them that could be compared, with their errors on blocks that were held out.
    lead : float
        Time by which friction leads the motion, s, where that validates better than any lag; else zero.
    profiles : dict of list of Profile
        Of each alike model whose friction saturates, by its terms.
    grid : Grid
        The products behind them.
    varied : Fitted or None
        The model whose friction a map varies, where one was asked for.
    held : Fitted or None
        The model without its lag, fitted to a torque that is held, where that explains as much: intervals are taken
        over it, too, see :mod:`adaptive_ff.identify.alternatives.held_torque`.
    bristles : Fitted or None
        The model with viscous friction that does not lag, where that explains as much: intervals are taken over it,
        too, see :mod:`adaptive_ff.identify.alternatives.bristle_lag`.
    bent : Fitted or None
        The model whose friction follows over a path in the place of a lag, where that explains as much: intervals are
        taken over it, too, see :mod:`adaptive_ff.identify.alternatives.bristle_path`.
    jumping : Selection or None
        The comparison of models whose friction jumps or lags, where the model over a path lacks something: intervals
        are taken over these, too.
    """

    chosen: Fitted
    alike: list[Fitted]
    tried: dict[str, Fitted]
    refused: dict[str, str]
    models: Sequence[Terms]
    validated: list[Validated]
    lead: float
    profiles: dict[Terms, list[Profile]]
    grid: Grid
    varied: Fitted | None = None
    held: Fitted | None = None
    bristles: Fitted | None = None
    bent: Fitted | None = None
    jumping: "Selection | None" = None

    @property
    def allowed(self) -> list[Fitted]:
        """All fits that intervals are taken over, the chosen one first."""
        return [*self.alike, *self._beside, *([] if self.jumping is None else self.jumping.allowed)]

    @property
    def _beside(self) -> list[Fitted]:
        """Fits of other rows than those of the grid: of a later torque, of friction that lags or bends otherwise."""
        return [fitted for fitted in (self.held, self.bristles, self.bent) if fitted is not None]

    def interval(self, name: str) -> Estimate:
        """Return a parameter of the chosen model; its interval covers those of all models that are allowed."""
        estimate = self.chosen.estimate(name)
        ends = [self.ends(fitted, name) for fitted in self.allowed if name in fitted.parameters]
        lower, upper = min(low for low, _ in ends), max(high for _, high in ends)
        return Estimate(estimate.value, estimate.standard_error, lower, upper)

    def ends(self, fitted: Fitted, name: str) -> tuple[float, float]:
        """Return the ends of the interval of one of the models that are allowed."""
        if self.jumping is not None and any(fitted is other for other in self.jumping.allowed):
            return self.jumping.ends(fitted, name)
        is_beside = any(fitted is other for other in self._beside)
        profiles = None if is_beside else self.profiles.get(fitted.terms)  # which are of the rows of the grid
        if profiles is None or name not in profiles[0].values or any(name not in one.values for one in profiles):
            return fitted.estimate(name)[2:]
        return profile_interval(self.grid, profiles, fitted, name, self.chosen.regression.confidence)


def select_terms(problem: Problem, *, family: str, both_ways: bool, rotary: bool, confidence: float) -> Selection:
    """Choose the model of a log among those of a family, or of all.

    Parameters
    ----------
    problem : Problem
        The rows.
    family : str
        Key of ``FAMILIES``, or ``AUTO``.
    both_ways : bool
        Whether the joint moves both ways.
    rotary : bool
        Whether the joint turns, so that gravity may act as the sine and cosine of its position.
    confidence : float
        Probability that the intervals are meant to have.

    Raises
    ------
    ValueError
        The rows do not determine the terms of the simplest model.
    """
    has_position = all(piece.sine is not None for piece in problem.pieces)
    models = candidate_models(family, both_ways=both_ways, gravity=rotary and has_position)
    if problem.path > 0.0:
        models = [(*BASE, PATH, DAMPING, *terms[len(BASE) :]) for terms in models if LAG not in terms]
    return select_among(problem, models, confidence)


def select_among(problem: Problem, models: Sequence[Terms], confidence: float) -> Selection:
    """Choose the model of a log among some, of which the first one is the simplest; see ``select_terms``."""
    grid = make_grid(problem)
    refused: dict[str, str] = {}
    simplest = fit_terms(problem, models[0], confidence)  # says what cannot be separated
    fits: dict[Terms, Fitted] = {models[0]: simplest}
    validated = cross_validate(grid, models)
    while True:
        best, near = choose(validated, shows_lag=problem.shows_lag)
        for model in [best, *near]:
            if model.terms not in fits:
                try:
                    fits[model.terms] = fit_terms(problem, model.terms, confidence, start=_start(model.start))
                except ValueError as error:
                    refused[model.terms[-1]] = str(error)
        if best.terms in fits:
            break
        validated = [model for model in validated if model is not best]
    alike = [fits[model.terms] for model in [best, *near] if model.terms in fits]
    chosen = alike[0]
    beside = [*_of_other_shape(grid, best, models), *_without_collinear(grid, chosen, models)]
    alike += _fitted_beside(problem, beside, confidence)
    profiles = {
        fitted.terms: shape_profiles(grid, fitted.terms) for fitted in alike if {*fitted.terms} & {*SATURATIONS}
    }
    tried: dict[str, Fitted] = {}
    for term in ADDED:
        terms = next((model for model in models if set(model) == {*best.terms, term}), None)
        if terms is not None and term not in best.terms:
            start = fit_on_grid(grid, terms, np.ones(BLOCKS, dtype=np.bool_), np.zeros(BLOCKS, dtype=np.bool_))
            if terms not in fits and not math.isfinite(start.squares):
                refused[term] = "at every speed of its bend, the fit of the log has the opposite sign"
                continue
            try:
                tried[term] = fits.get(terms) or fit_terms(problem, terms, confidence, start=_start(start))
            except ValueError as error:
                refused[term] = str(error)
    lead = _lead(grid, best) if problem.shows_lag else 0.0
    return Selection(chosen, alike, tried, refused, models, validated, lead, profiles, grid)


def _of_other_shape(grid: Grid, best: Validated, models: Sequence[Terms]) -> list[Validated]:
    """Return the model with the other shape of stiction, where the log does not rule it out.

    That is, of a model with stiction, where it validates as well; of another one, where it validates better by more
    than chance explains, in the place of what saturates there. Stiction must be one of the terms of the models.
    """
    if not any(STICTION in model for model in models):
        return []
    terms = *(term for term in best.terms if term not in (STICTION, *SATURATIONS)), SQUARE_STICTION

    def allowed(other: Validated) -> bool:
        return within(other, best, ALIKE) if STICTION in best.terms else not within(best, other, ALIKE)

    return [other for other in cross_validate(grid, [terms]) if allowed(other)]


def _without_collinear(grid: Grid, chosen: Fitted, models: Sequence[Terms]) -> list[Validated]:
    """Return the models without gravity, and without the lag, where hardly more than its shape tells it from inertia.

    Along one sine of the position the acceleration is almost a gravity, and friction that lags almost an inertia: what
    an inertia is then hangs on all else that the torque has.
    """
    if chosen.collinearity("inertia") < COLLINEAR:
        return []
    fewer = [tuple(term for term in chosen.terms if term not in dropped) for dropped in (GRAVITY, (LAG,))]
    return cross_validate(grid, [terms for terms in fewer if terms != chosen.terms and terms in models])


def _fitted_beside(problem: Problem, models: Sequence[Validated], confidence: float) -> list[Fitted]:
    """Return the fits of models that only intervals are taken over, of those whose terms can be separated."""
    made = []
    for model in models:
        with suppress(ValueError):
            made.append(fit_terms(problem, model.terms, confidence, start=_start(model.start)))
    return made


def _start(point: Point) -> dict[str, float]:
    return {LAG: point.lag, **dict.fromkeys(BENT.values(), point.speed)}


def _lead(grid: Grid, best: Validated) -> float:
    """Return by how much friction leads, where that is beyond what chance explains."""
    terms = (*(term for term in best.terms if term != LAG), LEAD)
    (leading,) = cross_validate(grid, [terms]) or [best]
    worse, deviation = behind(best, leading)
    return -leading.start.lag if leading is not best and worse > ALIKE * deviation else 0.0
