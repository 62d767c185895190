"""Least squares on the columns of a log: linear but for the friction lag and the Stribeck velocity, which are searched.

For given lag and ``Vs`` the linear rest is solved for (variable projection), from the best point of the grid of
:mod:`adaptive_ff.identify.fitting.grid`. At the solution the regression is linearised, so that all parameters together
get a covariance that knows of correlated residuals (Newey and West, see
:mod:`adaptive_ff.learning.batch_least_squares`), and of what the model lacks
(:mod:`adaptive_ff.identify.fitting.discrepancy`).
"""

import math
from collections.abc import Mapping, Sequence
from dataclasses import replace

import numpy as np

from adaptive_ff.identify.fitting.discrepancy import discrepancy_covariance, state_functions
from adaptive_ff.identify.fitting.fitted import SEARCHED, Fitted, linear_terms
from adaptive_ff.identify.fitting.search import search, searched_values, slope_by
from adaptive_ff.identify.rows.regressors import Problem, design, measured_torque, path_slope
from adaptive_ff.identify.terms import PATH, SQUARE_STICTION, STICTION
from adaptive_ff.learning.batch_least_squares import LeastSquaresFit, fit_least_squares
from adaptive_ff.logs.derivatives import Array

TIMES_ANDREWS = 2.0
"""Reach of the correlation of residuals over that of the rule of Andrews."""


def fit_terms(
    problem: Problem, terms: tuple[str, ...], confidence: float, *, start: Mapping[str, float] | None = None
) -> Fitted:
    """Fit the torque by some terms.

    Parameters
    ----------
    problem : Problem
        The rows.
    terms : tuple of str
        Linear terms, ``friction_lag``, and ``presliding`` where the rows have a path, which stays as it is.
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
    point = search(problem, linear, names, target, start or {})
    matrix = design(problem, linear, searched_values(names, point))
    rough = fit_least_squares(matrix, target, names=linear, confidence=confidence)
    slopes = [slope_by(problem, linear, names, point, rough.values, place) for place in range(len(names))]
    if PATH in terms:  # found already, and only its error is a matter of this fit
        searched = searched_values(names, point)
        slopes.append(path_slope(problem, dict(zip(linear, rough.values.tolist(), strict=True)) | searched))
        names, point = [*names, PATH], np.append(point, math.log(problem.path))
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
        {**found, **searched_values(names, regression.values[len(linear) :])},
        regression,
        inflation,
        regression.values - solved,
        alone * np.sum(np.square(full), axis=0),
        _shown_stiction(matrix, linear),
        bool(np.any(lacks)),
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
    searched = [place for place, name in enumerate(regression.names) if name in (*SEARCHED.values(), PATH)]
    correction[searched] = 0.0
    covariance = regression.covariance + 0.25 * np.outer(correction, correction)
    return replace(regression, values=regression.values + correction, covariance=covariance)


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
