"""Blocked cross-validation: which models of a log say the torque of a block that they have not seen.

Rows of a log depend on their neighbours, so what is held out are whole blocks (P. Burman, E. Chow, D. Nolan, Biometrika
81, 1994). Differences between models are judged by their scatter over the blocks: a model whose error is larger than
the smallest by no more than chance explains is one that the log cannot tell from the best (the rule of one standard
error: L. Breiman et al., "Classification and Regression Trees", 1984, section 3.4.3, on paired differences).
"""

import math
from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from adaptive_ff.identify.families import Terms
from adaptive_ff.identify.grid import BLOCKS, Grid, Point, fit_on_grid
from adaptive_ff.logs.derivatives import Array

SIMPLER = 1.0
"""Standard errors by which a simpler model may validate worse than the best and is still preferred."""

ALIKE = 2.0
"""Standard errors within which models count as not distinguishable by the log: intervals are taken over them."""


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
    for terms in models:
        start = fit_on_grid(grid, terms, np.zeros(BLOCKS, dtype=np.bool_))
        held = np.array([fit_on_grid(grid, terms, np.arange(BLOCKS) == block).held for block in range(BLOCKS)])
        if math.isfinite(start.squares) and np.all(np.isfinite(held)):
            made.append(Validated(terms, start, held))
    return made


def behind(one: Validated, other: Validated) -> tuple[float, float]:
    """Return by how much a model validates worse than another one, and the standard error of that."""
    difference = one.held - other.held
    return float(np.sum(difference)), math.sqrt(BLOCKS * float(np.var(difference, ddof=1)))


def choose(validated: Sequence[Validated]) -> tuple[Validated, list[Validated]]:
    """Return the model to be used, and all that the log cannot tell from the best one, without it.

    Used is the one of fewest terms whose error is within one standard error of the smallest; of equal ones the best.
    """
    best = min(validated, key=lambda model: model.error)
    near = [model for model in validated if _within(model, best, SIMPLER)]
    chosen = min(near, key=lambda model: (len(model.terms), model.error))
    alike = [model for model in validated if _within(model, best, ALIKE)]
    # a model with more terms that validates no better only widens the intervals
    return chosen, [model for model in alike if model.error < chosen.error or len(model.terms) < len(chosen.terms)]


def _within(model: Validated, best: Validated, errors: float) -> bool:
    worse, deviation = behind(model, best)
    return worse <= errors * deviation
