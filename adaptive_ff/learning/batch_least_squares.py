"""Batch least squares, equations (7)-(9), by orthogonal factors of the scaled regressors.

The paper writes the estimate as ``(X'X)^-1 X'W``, (9). Forming ``X'X`` squares the condition number; here the columns
of ``X`` are scaled to unit length and ``X`` itself is factorised, ``X = QR``, then the small ``R`` by its singular
values. In (8) the paper's objective lacks the square; the minimiser is the same.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from scipy import special

from adaptive_ff.learning.checks import check_all, check_confidence
from controllers.arrays import ArrayLike, NDArray
from controllers.checks import checked_array

Array = NDArray[np.float64]


class Estimate(NamedTuple):
    """One estimated number with its standard error and the ends of its confidence interval."""

    value: float
    standard_error: float
    lower: float
    upper: float


@dataclass(frozen=True, eq=False)
class LeastSquaresFit:
    """Result of a batch least-squares fit."""

    names: tuple[str, ...]  # names of the parameters, in the order of the columns
    values: Array  # shape (n,); estimated parameters
    covariance: Array  # shape (n, n); their covariance
    residuals: Array  # shape (m,); output minus prediction, of the data rows
    condition_number: float  # ratio of the largest to the smallest singular value of the scaled regressors
    confidence: float  # probability that the intervals are meant to have

    @property
    def degrees_of_freedom(self) -> int:
        """Rows of data minus parameters."""
        return self.residuals.size - self.values.size

    @property
    def standard_errors(self) -> Array:
        """Standard errors of the parameters, shape (n,)."""
        errors: Array = np.sqrt(np.diag(self.covariance))
        return errors

    def estimate(self, name: str) -> Estimate:
        """Return one parameter with its interval.

        Raises
        ------
        ValueError
            There is no parameter of that name.
        """
        if name not in self.names:
            raise ValueError(f"name = {name!r} is not known; allowed: {', '.join(self.names)}")
        place = self.names.index(name)
        return self.interval(float(self.values[place]), float(self.standard_errors[place]))

    def interval(self, value: float, standard_error: float) -> Estimate:
        """Return a number derived from the parameters with its interval (Student's t)."""
        half = standard_error * float(special.stdtrit(self.degrees_of_freedom, 0.5 + 0.5 * self.confidence))
        return Estimate(value, standard_error, value - half, value + half)


def fit_least_squares(
    regressors: ArrayLike,
    outputs: ArrayLike,
    *,
    names: Sequence[str] | None = None,
    confidence: float = 0.95,
    correlated_samples: int = 0,
) -> LeastSquaresFit:
    """Fit ``outputs = regressors parameters + error``.

    Parameters
    ----------
    regressors : array_like, shape (m, n)
        One row for each equation, ``X`` of (7); more rows than columns.
    outputs : array_like, shape (m,)
        Regressed outputs, ``W`` of (7).
    names : sequence of str, optional
        Names of the parameters; ``p0``, ``p1``, ... by default.
    confidence : float, optional
        Probability that the confidence intervals are meant to have.
    correlated_samples : int, optional
        Over how many rows errors are correlated. Zero: not at all, and of equal variance. Above:
        the covariance of the parameters is that of Newey and West (Econometrica 55, 1987), with Bartlett's weights.

    Returns
    -------
    LeastSquaresFit
        The fit. Its intervals speak of random errors that are independent of the regressors; a model that is wrong,
        or noise in the regressors, shifts the estimates by more than they show.

    Raises
    ------
    ValueError
        Arguments have the wrong shape, are not finite or out of range, there are too few rows, or the columns of the
        regressors are linearly dependent.
    """
    matrix, target = _check_data(regressors, outputs)
    size = matrix.shape[1]
    labels = tuple(f"p{i}" for i in range(size)) if names is None else tuple(names)
    _check_options(labels, matrix.shape, confidence, correlated_samples)
    orthogonal, inverse, condition_number = _factorise(matrix, labels)
    values = inverse @ (orthogonal.T @ target)
    residuals = target - matrix @ values
    spread = _spread_along(orthogonal, residuals, correlated_samples)
    covariance = inverse @ spread @ inverse.T
    return LeastSquaresFit(labels, values, covariance, residuals, condition_number, float(confidence))


def _spread_along(orthogonal: Array, residuals: Array, correlated_samples: int) -> Array:
    """Return the covariance of ``Q' error``, shape (n, n), for orthonormal columns ``Q``, from what was left."""
    rows, size = orthogonal.shape
    if correlated_samples == 0:
        independent: Array = np.eye(size) * float(residuals @ residuals) / (rows - size)
        return independent
    products = orthogonal * residuals[:, np.newaxis]
    total: Array = products.T @ products
    for lag in range(1, correlated_samples + 1):
        product = products[lag:].T @ products[:-lag]
        total += (1.0 - lag / (correlated_samples + 1.0)) * (product + product.T)
    total *= rows / (rows - size)
    return total


def _factorise(matrix: Array, names: tuple[str, ...]) -> tuple[Array, Array, float]:
    """Return ``Q``, the inverse of the square factor, and the condition number; refuse dependent columns."""
    scale = np.linalg.norm(matrix, axis=0)
    for name, length in zip(names, scale, strict=True):
        if length == 0.0:
            raise ValueError(f"the regressor of {name} is zero in every row; it must vary for {name} to be estimated")
    orthogonal, triangular = np.linalg.qr(matrix / scale)
    left, singular, right = np.linalg.svd(triangular)
    limit = singular[0] * max(matrix.shape) * np.finfo(float).eps
    if singular[-1] <= limit:
        rank = int(np.count_nonzero(singular > limit))
        loudest = names[int(np.argmax(np.abs(right[-1])))]
        raise ValueError(
            f"regressors have rank {rank}; it must be {len(names)}, the number of columns: {loudest} cannot be told "
            "from the others with these data"
        )
    inverse = (right.T / singular) @ left.T / scale[:, np.newaxis]
    return orthogonal, inverse, float(singular[0] / singular[-1])


def _check_options(names: tuple[str, ...], shape: tuple[int, ...], confidence: float, correlated_samples: int) -> None:
    rows, size = shape
    if len(names) != size:
        raise ValueError(f"names = {names} has {len(names)} entries; there must be one for each of {size} columns")
    check_confidence(confidence)
    if not 0 <= correlated_samples < rows:
        raise ValueError(
            f"correlated_samples = {correlated_samples} is not allowed: it must be at least 0 and less than the "
            f"{rows} rows"
        )


def _check_data(regressors: ArrayLike, outputs: ArrayLike) -> tuple[Array, Array]:
    matrix, target = checked_array("regressors", regressors), checked_array("outputs", outputs)
    if matrix.ndim != 2 or matrix.shape[1] == 0:
        raise ValueError(f"regressors have shape {matrix.shape}; it must be (rows, columns) with a column at least")
    rows, size = matrix.shape
    if target.shape != (rows,):
        raise ValueError(f"outputs have shape {target.shape}; it must be {(rows,)}, one for each row of regressors")
    for name, array in (("regressors", matrix), ("outputs", target)):
        check_all(name, array, np.isfinite(array))
    if rows <= size:
        raise ValueError(f"regressors have {rows} rows; there must be more than the {size} parameters")
    return matrix, target
