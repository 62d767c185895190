"""A fit of some terms: values, intervals, residuals."""

import math
from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from adaptive_ff.identify.terms import BENT, LAG, PATH, SQUARE_STICTION, STICTION
from adaptive_ff.learning.batch_least_squares import Estimate, LeastSquaresFit
from adaptive_ff.logs.derivatives import Array

SEARCHED = {"friction_lag": "friction_lag", **BENT}
"""Parameters that are searched, by the term that brings them; the lag is a term of its own."""

LOGARITHMIC = (*BENT.values(), PATH)
"""Parameters whose logarithm is regressed."""

FAR = math.log(1e6)
"""How far, as a logarithm, an end of the interval of a bend must be from it to be taken for zero or infinity."""


class Fitted(NamedTuple):
    """A fit of some terms.

    Attributes
    ----------
    terms : tuple of str
        Terms that took part: linear ones, ``friction_lag``, and ``presliding`` where the rows have a path.
    values : dict of float
        All parameters by name; ``stribeck_velocity`` in rad/s.
    regression : LeastSquaresFit
        Linearised at the solution; the Stribeck velocity as a logarithm.
    inflation : ndarray, shape (n,)
        Variances of the regression over those that independent residuals would have.
    correction : ndarray, shape (n,)
        What was added to the least squares for the noise of the columns.
    collinearities : ndarray, shape (n,)
        Variances of the regression over those without the other columns, known as variance inflation factors
        (D. Marquardt, "Generalized inverses, ridge regression, biased linear estimation, and nonlinear estimation",
        Technometrics 12, 1970).
    shown : float
        Largest share of the stiction above Coulomb friction that any row shows; one without stiction.
    lacks : bool
        Whether functions of the state explain more of what is left than chance does, see
        :mod:`adaptive_ff.identify.fitting.discrepancy`.
    """

    terms: tuple[str, ...]
    values: dict[str, float]
    regression: LeastSquaresFit
    inflation: Array
    correction: Array
    collinearities: Array
    shown: float
    lacks: bool

    @property
    def searched(self) -> dict[str, float]:
        """The parameters that were searched."""
        return {name: self.values[name] for name in SEARCHED.values() if name in self.values}

    @property
    def linear(self) -> list[str]:
        """The linear terms."""
        return linear_terms(self.terms)

    @property
    def parameters(self) -> tuple[str, ...]:
        """Names that ``estimate`` knows."""
        names = self.regression.names
        added = ("stiction", BENT[STICTION]) if self._stiction[0] in names else ()
        return tuple(dict.fromkeys((*names, *added)))

    @property
    def _stiction(self) -> tuple[str, str]:
        """Terms of the stiction above Coulomb friction, and of the speed at which that has fallen to its 1/e."""
        term = SQUARE_STICTION if SQUARE_STICTION in self.terms else STICTION
        return term, BENT[term]

    @property
    def squares(self) -> float:
        """Sum of squared residuals."""
        return float(np.sum(self.regression.residuals**2))

    def collinearity(self, name: str) -> float:
        """Return by how much the variance of a parameter is larger for the others."""
        return float(self.collinearities[self.regression.names.index(name)])

    def estimate(self, name: str) -> Estimate:
        """Return a parameter with its interval; ``stiction`` is Coulomb friction and what is above it."""
        excess, bend = self._stiction
        if name == "stiction":
            places = [self.regression.names.index(part) for part in ("coulomb", excess)]
            variance = float(np.sum(self.regression.covariance[np.ix_(places, places)]))
            return self.regression.interval(self.values["coulomb"] + self.values[excess], math.sqrt(variance))
        if name == BENT[STICTION]:
            name = bend
        found = self.regression.estimate(name)
        if name not in LOGARITHMIC:
            return found
        value = math.exp(found.value)
        lower = math.exp(found.lower) if found.value - found.lower < FAR else 0.0
        upper = math.exp(found.upper) if found.upper - found.value < FAR else math.inf
        return Estimate(value, value * found.standard_error, lower, upper)


def linear_terms(terms: Sequence[str]) -> list[str]:
    """Return the terms that are columns: all but the lag and the path."""
    return [term for term in terms if term not in (LAG, PATH)]
