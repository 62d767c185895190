"""Blocked cross-validation: which models of a log say the torque of a block that they have not seen.

Rows of a log depend on their neighbours, so what is held out are whole blocks, and the blocks next to it are not fitted
either (P. Burman, E. Chow, D. Nolan, Biometrika 81, 1994). Differences between models are judged by their scatter over
the blocks: a model whose error is larger than the smallest by no more than chance explains is one that the log cannot
tell from the best.

The rule of one standard error (L. Breiman et al., "Classification and Regression Trees", 1984, section 3.4.3), on
paired differences, chooses among models of one family, which differ in the shape of friction. Between families it is
two: gravity and friction by direction act where the joint is and which way it goes, so a block that was left out may
be the only one that shows them.
"""

import math
from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from adaptive_ff.identify.fitting.families import family_of
from adaptive_ff.identify.fitting.grid import BLOCKS, Grid
from adaptive_ff.identify.fitting.grid_fit import Point, fit_on_grid
from adaptive_ff.identify.terms import LAG, Terms
from adaptive_ff.logs.derivatives import Array

NEIGHBOURS = 1
"""Blocks on either side of the one held out that are not fitted."""

ALIKE = 2.0
"""Standard errors within which models count as not distinguishable by the log: the simplest family is used."""

SHAPE = 1.0
"""Standard errors within which the simplest model of that family is used instead of the best one."""

ROUNDING = 1e-14
"""Squares, over those of the torque, within which models are the same: one whose further term comes out as zero."""


class Validated(NamedTuple):
    """A model with its errors.

    Attributes
    ----------
    terms : tuple of str
        Its terms.
    start : Point
        Its fit to all blocks, on the grid.
    held : ndarray, shape (blocks,)
        Squares of each block, left by the fit to all others, over those of the torque of the log.
    """

    terms: Terms
    start: Point
    held: Array

    @property
    def error(self) -> float:
        """Error on blocks that were held out, over the torque."""
        return math.sqrt(float(np.sum(self.held)))


def cross_validate(grid: Grid, models: Sequence[Terms]) -> list[Validated]:
    """Return the models that can be fitted to all but any one block, in the order given."""
    made = []
    nothing = np.zeros(BLOCKS, dtype=np.bool_)
    for terms in models:
        start = fit_on_grid(grid, terms, np.ones(BLOCKS, dtype=np.bool_), nothing)
        if start.at_end:
            continue  # the bend lies beyond the speeds of the log: what it does is not separate from other terms
        distance = np.abs(np.subtract.outer(np.arange(BLOCKS), np.arange(BLOCKS)))
        held = np.array([fit_on_grid(grid, terms, row > NEIGHBOURS, row == 0).held for row in distance])
        if math.isfinite(start.squares) and np.all(np.isfinite(held)):
            made.append(Validated(terms, start, held))
    return made


def behind(one: Validated, other: Validated) -> tuple[float, float]:
    """Return by how much a model validates worse than another one, and the standard error of that."""
    difference = one.held - other.held
    return float(np.sum(difference)), math.sqrt(BLOCKS * float(np.var(difference, ddof=1)))


def choose(validated: Sequence[Validated], *, shows_lag: bool = True) -> tuple[Validated, list[Validated]]:
    """Return the model to be used, and all that the log cannot tell from the best one, without it.

    Used is the simplest family that has a model within ``ALIKE`` standard errors of the best, and of it the simplest
    model within ``SHAPE`` of the best of the family. Intervals are taken over it, the simplest model of the family
    within ``ALIKE``, and those which validate better than that one, though by no more than chance explains. Of a log
    that does not show a friction lag, models with one are a family of their own.
    """
    best = min(validated, key=lambda model: model.error)
    alike = [model for model in validated if within(model, best, ALIKE)]

    def family_of_model(model: Validated) -> Terms:
        family = family_of(model.terms)
        return family if shows_lag or LAG not in model.terms else (*family, LAG)

    family = min((family_of_model(model) for model in alike), key=len)
    members = [model for model in validated if family_of_model(model) == family]
    chosen, simplest = (_simplest(members, bound) for bound in (SHAPE, ALIKE))
    # a model with more terms that validates no better only widens the intervals
    near = [model for model in alike if model.error < simplest.error and model is not chosen]
    return chosen, near if simplest is chosen else [simplest, *near]


def _simplest(models: Sequence[Validated], bound: float) -> Validated:
    best = min(models, key=lambda model: model.error)
    near = [model for model in models if within(model, best, bound)]
    return min(near, key=lambda model: (len(model.terms), model.error))


def within(model: Validated, best: Validated, bound: float) -> bool:
    """Tell whether a model validates worse than another one by no more than so many standard errors."""
    worse, deviation = behind(model, best)
    return worse <= bound * deviation + ROUNDING
