"""Least squares on the columns of a log: linear but for the friction lag and the Stribeck velocity, which are searched.

For given lag and ``Vs`` the linear rest is solved for (variable projection), from the best point of the grid of
:mod:`adaptive_ff.identify.fitting.grid`. At the solution the regression is linearised, so that all parameters together
get a covariance that knows of correlated residuals (Newey and West, see
:mod:`adaptive_ff.estimation.batch_least_squares`), and of what the model lacks
(:mod:`adaptive_ff.identify.fitting.discrepancy`).
"""

import math
from collections.abc import Mapping, Sequence
from dataclasses import replace
from typing import NamedTuple

import numpy as np

from adaptive_ff.estimation.batch_least_squares import Estimate, LeastSquaresFit, fit_least_squares
from adaptive_ff.identify.fitting.discrepancy import discrepancy_covariance, state_functions
from adaptive_ff.identify.rows.regressors import Problem, design, measured_torque
from adaptive_ff.identify.terms import BENT, LAG, SQUARE_STICTION, STICTION
from adaptive_ff.logs.derivatives import Array

SEARCHED = {"friction_lag": "friction_lag", **BENT}
"""Parameters that are searched, by the term that brings them; the lag is a term of its own."""

INSIDE = 1e-3
"""Distance of the start of a search from the ends of the range, over the range."""

STEPS, LONGEST, CLOSE = 12, 0.05, 1e-4
"""Steps of the search at most, and the longest and shortest of them, over the range."""

TIMES_ANDREWS = 2.0
"""Reach of the correlation of residuals over that of the rule of Andrews."""

SLOPE_STEP = 1e-4
"""Step of the difference quotients by a searched parameter, over its range."""

FAR = math.log(1e6)
"""How far, as a logarithm, an end of the interval of a bend must be from it to be taken for zero or infinity."""


class Fitted(NamedTuple):
    """A fit of some terms.

    Attributes
    ----------
    terms : tuple of str
        Terms that took part: linear ones, and ``friction_lag``.
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
    """

    terms: tuple[str, ...]
    values: dict[str, float]
    regression: LeastSquaresFit
    inflation: Array
    correction: Array
    collinearities: Array
    shown: float

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
        if name not in BENT.values():
            return found
        value = math.exp(found.value)
        lower = math.exp(found.lower) if found.value - found.lower < FAR else 0.0
        upper = math.exp(found.upper) if found.upper - found.value < FAR else math.inf
        return Estimate(value, value * found.standard_error, lower, upper)


def linear_terms(terms: Sequence[str]) -> list[str]:
    """Return the terms that are columns: all but the lag."""
    return [term for term in terms if term != LAG]


def fit_terms(
    problem: Problem, terms: tuple[str, ...], confidence: float, *, start: Mapping[str, float] | None = None
) -> Fitted:
    """Fit the torque by some terms.

    Parameters
    ----------
    problem : Problem
        The rows.
    terms : tuple of str
        Linear terms, and ``friction_lag``.
    confidence : float
        Probability that the intervals are meant to have.
    start : mapping of float, optional
        Where the search starts, by name of what is searched: the best point of a grid. Needed where something is.

    Returns
    -------
    Fitted
        The fit.

    Raises
    ------
    ValueError
        The rows do not determine the terms separately.
    """
    target = measured_torque(problem)
    linear = linear_terms(terms)
    names = [SEARCHED[term] for term in terms if term in SEARCHED]
    point = _search(problem, linear, names, target, start or {})
    matrix = design(problem, linear, _searched(names, point))
    rough = fit_least_squares(matrix, target, names=linear, confidence=confidence)
    slopes = [_slope(problem, linear, names, point, rough.values, place) for place in range(len(names))]
    full = np.column_stack([matrix, *slopes])
    outputs = target + full[:, len(linear) :] @ point
    correlated = correlation_length(rough.residuals)
    regression = fit_least_squares(
        full, outputs, names=[*linear, *names], confidence=confidence, correlated_samples=correlated
    )
    alone = np.sum(np.square(regression.inverse), axis=1)  # variances for independent errors of a variance of one
    independent = alone * float(regression.residuals @ regression.residuals) / regression.degrees_of_freedom
    lacks = discrepancy_covariance(state_functions(problem), full, regression.inverse, rough.residuals, correlated)
    covariance = regression.covariance * small_sample(correlated / target.size) + lacks
    inflation = np.diag(covariance) / independent
    # where the search ended at the end of a range, or nothing depends on it, the linearised solution lies elsewhere
    regression = replace(
        regression, values=np.concatenate([rough.values, point]), covariance=covariance, residuals=rough.residuals
    )
    solved = regression.values
    regression = _without_attenuation(problem, full, regression)
    found = dict(zip(linear, regression.values.tolist(), strict=False))
    return Fitted(
        terms,
        {**found, **_searched(names, regression.values[len(linear) :])},
        regression,
        inflation,
        regression.values - solved,
        alone * np.sum(np.square(full), axis=0),
        _shown_stiction(matrix, linear),
    )


def _shown_stiction(matrix: Array, linear: Sequence[str]) -> float:
    """Return the largest share of a stiction above Coulomb friction in the rows of a design; one without stiction."""
    places = [linear.index(term) for term in (STICTION, SQUARE_STICTION) if term in linear]
    return float(np.max(np.abs(matrix[:, places]))) if places else 1.0


def _without_attenuation(problem: Problem, matrix: Array, regression: LeastSquaresFit) -> LeastSquaresFit:
    """Undo, to first order, what noise in its columns takes from a fit; half of it is added to the errors."""
    variance = np.array([problem.noise.get(name, 0.0) for name in regression.names])
    if not np.any(variance):
        return regression
    scale = np.linalg.norm(matrix, axis=0)
    scaled = matrix / scale
    drawn = matrix.shape[0] * variance * regression.values / scale
    correction = np.linalg.lstsq(scaled.T @ scaled, drawn, rcond=1e-12)[0] / scale
    searched = [place for place, name in enumerate(regression.names) if name in SEARCHED.values()]
    correction[searched] = 0.0
    covariance = regression.covariance + 0.25 * np.outer(correction, correction)
    return replace(regression, values=regression.values + correction, covariance=covariance)


def lag_profile(problem: Problem, fitted: Fitted, lags: Array) -> Array:
    """Return the relative error of the torque over friction lags (s), all linear terms fitted anew at each."""
    target = measured_torque(problem)
    others = {name: value for name, value in fitted.searched.items() if name != "friction_lag"}
    errors: list[float] = []
    for lag in lags.tolist():
        matrix = design(problem, fitted.linear, {**others, "friction_lag": lag})
        errors.append(float(np.linalg.norm(_residual(matrix, target)) / np.linalg.norm(target)))
    return np.array(errors)


def correlation_length(residuals: Array) -> int:
    """Return over how many rows residuals are to be taken as correlated.

    The rule of D. Andrews (Econometrica 59, 1991) for Bartlett's weights, with a first-order autoregression:
    ``1.1447 (4 r^2 n / (1 - r^2)^2)^(1/3)``; twice that, as residuals of a model that lacks something are no
    autoregression.
    """
    size = int(residuals.size)
    power = float(residuals @ residuals)
    if power == 0.0:
        return 0
    correlation: float = min(abs(float(residuals[1:] @ residuals[:-1])) / power, 0.99)
    length: float = 1.1447 * (4.0 * correlation**2 * size / (1.0 - correlation**2) ** 2) ** (1.0 / 3.0)
    return min(math.ceil(TIMES_ANDREWS * length), size // 4)


def small_sample(share: float) -> float:
    """Return the factor of a variance of Newey and West for weights that reach over a share of the rows.

    N. Kiefer, T. Vogelsang, Econometric Theory 21, 2005, table 1: the critical value 1.96 becomes
    ``1.96 + 2.9694 b + 0.416 b^2 - 0.5324 b^3``.
    """
    return ((1.96 + 2.9694 * share + 0.416 * share**2 - 0.5324 * share**3) / 1.96) ** 2


def _ranges(problem: Problem, names: list[str]) -> list[tuple[float, float]]:
    """Return where each searched parameter is looked for, the Stribeck velocity as a logarithm."""
    known = {"friction_lag": (-problem.longest_lag, problem.longest_lag)}
    for term, speeds in problem.speeds.items():
        known[BENT[term]] = (math.log(speeds[0]), math.log(speeds[-1]))
    return [known[name] for name in names]


def _searched(names: list[str], point: Array) -> dict[str, float]:
    pairs = zip(names, point.tolist(), strict=True)
    return {name: math.exp(value) if name in BENT.values() else value for name, value in pairs}


def _search(problem: Problem, linear: list[str], names: list[str], target: Array, start: Mapping[str, float]) -> Array:
    """Return the searched parameters at the least squares, by steps of Gauss and Newton within their ranges."""
    if not names:
        return np.empty(0)
    low, high = np.array(_ranges(problem, names)).T
    span = high - low
    point = np.array([math.log(start[name]) if name in BENT.values() else start[name] for name in names])
    point = np.clip(point, low + INSIDE * span, high - INSIDE * span)
    squares = math.inf
    step = np.zeros_like(point)
    for _ in range(STEPS):
        matrix = design(problem, linear, _searched(names, point))
        values = _solve(matrix, target)
        residual = target - matrix @ values
        now = float(residual @ residual)
        if now > squares:  # too far: back by half
            step *= 0.5
            point = point - step
            continue
        squares = now
        slopes = [_slope(problem, linear, names, point, values, place) for place in range(len(names))]
        solved = _solve(np.column_stack([matrix, *slopes]), residual)
        step = np.clip(point + np.clip(solved[len(linear) :], -LONGEST * span, LONGEST * span), low, high) - point
        if np.all(np.abs(step) < CLOSE * span):
            break
        point = point + step
    return np.asarray(point)


def _solve(matrix: Array, target: Array) -> Array:
    """Return the least squares by scaled normal equations: good enough to search with, and quick."""
    scale = np.linalg.norm(matrix, axis=0)
    scale[scale == 0.0] = 1.0
    scaled = matrix / scale
    solved: Array = np.linalg.lstsq(scaled.T @ scaled, scaled.T @ target, rcond=1e-13)[0] / scale
    return solved


def _residual(matrix: Array, target: Array) -> Array:
    residual: Array = target - matrix @ _solve(matrix, target)
    return residual


def _slope(problem: Problem, linear: list[str], names: list[str], point: Array, values: Array, place: int) -> Array:
    """Return the derivative of the fitted torque by a searched parameter, the linear ones held."""
    low, high = _ranges(problem, names)[place]
    step = np.zeros_like(point)
    step[place] = SLOPE_STEP * (high - low)
    after, before = (design(problem, linear, _searched(names, point + side * step)) for side in (1.0, -1.0))
    slope: Array = (after - before) @ values / (2.0 * step[place])
    return slope
