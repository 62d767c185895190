"""Least squares by folds of rows: estimates, errors out of sample, and the spread of repetition."""

import math
from itertools import pairwise
from typing import NamedTuple

import numpy as np
from scipy import optimize, special

from adaptive_ff.identify.columns import Shape
from adaptive_ff.identify.motion import TUNING, Array
from controllers.arrays import NDArray

NOT_NEGATIVE = frozenset({"inertia", "coulomb", "viscous"})
"""Parameters whose estimates are bounded."""

TORQUES = ("offset", "gravity_", "force_")
"""Beginnings of names of parameters that are torques without dissipation: about as large as the log's, beforehand."""


class Model(NamedTuple):
    """Terms of a model, and the shape of their columns."""

    names: tuple[str, ...]
    shape: Shape = Shape()


class Parameter(NamedTuple):
    """A parameter with its interval."""

    value: float
    lower: float
    upper: float

    @property
    def half_width(self) -> float:
        """Half width of the interval over the value."""
        return 0.5 * (self.upper - self.lower) / abs(self.value) if self.value else math.inf


class Fit(NamedTuple):
    """A fitted model with its parameters, and what it leaves of folds left out, see :func:`remainder`."""

    model: Model
    parameters: dict[str, Parameter]
    left: float

    @property
    def values(self) -> dict[str, float]:
        """Estimates by name."""
        return {name: one.value for name, one in self.parameters.items()}


class Folds(NamedTuple):
    """Sums over the rows of each fold: all that least squares needs.

    Products of the columns, and the same freed of the noise of the measured motion in them and with the prior's;
    products of columns and torque; square of the torque, and number of rows.
    """

    names: tuple[str, ...]
    gram: Array
    clean: Array
    moment: Array
    power: Array
    rows: Array

    def solve(self, *, bounded: bool = True) -> Array:
        """Return the estimates of all rows."""
        return solve(self.clean.sum(axis=0), self.moment.sum(axis=0), self.names, bounded=bounded)

    def tolerance(self) -> dict[str, float]:
        """Return the fraction of each column that the others do not explain."""
        return dict(zip(self.names, tolerance(self.gram.sum(axis=0)).tolist(), strict=True))


def tolerance(gram: Array) -> Array:
    """Return the fraction of each column that the others do not explain, from the products of the columns."""
    return np.asarray(1.0 / np.diag(np.linalg.inv(_scaled(gram)[0])))


def _scaled(gram: Array) -> tuple[Array, Array]:
    """Return products of columns of unit length, and their lengths."""
    scale = np.sqrt(np.maximum(np.diag(gram), 1e-300))
    return gram / np.outer(scale, scale) + TUNING.ridge * np.eye(scale.size), scale


def sums(
    names: tuple[str, ...], columns: Array, torque: Array, fold: NDArray[np.int64], noise: dict[str, float]
) -> Folds:
    """Return the sums of rows by the number of their fold; ``noise`` is the variance in a row by column."""
    edges = np.searchsorted(fold, np.arange(int(fold[-1]) + 2))
    parts = [slice(start, stop) for start, stop in pairwise(edges)]
    gram = np.array([columns[part].T @ columns[part] for part in parts])
    moment = np.array([columns[part].T @ torque[part] for part in parts])
    power = np.array([float(torque[part] @ torque[part]) for part in parts])
    count = np.diff(edges).astype(float)
    clean, variance = gram.copy(), np.array([noise.get(name, 0.0) for name in names])
    places = np.arange(len(names))
    own = gram[:, places, places]
    prior = _prior(names, gram.sum(axis=0), moment.sum(axis=0), power.sum(), count.sum()) / count.size**2
    clean[:, places, places] = own - np.minimum(np.outer(count, variance), TUNING.most_noise * own) + prior
    return Folds(names, gram, clean, moment, power, count)


def _prior(names: tuple[str, ...], gram: Array, moment: Array, power: float, rows: float) -> Array:
    """Return the precision of the prior, in units of that of a row, were all errors of a fold one.

    Over a short way offset and both parts of gravity are nearly one column: least squares would find a hundred times
    the torque of the log, with opposite signs.
    """
    values = solve(gram, moment, names)
    left = max(0.0, power - 2.0 * float(values @ moment) + float(values @ gram @ values)) / max(power, 1e-300)
    return np.array([left * rows if name.startswith(TORQUES) else 0.0 for name in names])


def solve(gram: Array, moment: Array, names: tuple[str, ...], *, bounded: bool = True) -> Array:
    """Return least-squares estimates; what cannot be negative is not."""
    scaled, scale = _scaled(gram)
    right = moment / scale
    values = np.linalg.solve(scaled, right)
    low = lowest(names)
    if bounded and np.any(values < low):
        powers, axes = np.linalg.eigh(scaled)
        root = np.sqrt(np.maximum(powers, 1e-9))
        rows, right = root[:, np.newaxis] * axes.T, (axes.T @ right) / root
        values = optimize.lsq_linear(rows, right, (low, np.inf), method="bvls").x
    return np.asarray(values / scale)


def lowest(names: tuple[str, ...]) -> Array:
    """Return the lower bounds of parameters: zero of what cannot be negative."""
    return np.array([0.0 if name in NOT_NEGATIVE else -np.inf for name in names])


def _without_each(folds: Folds, *, bounded: bool) -> Array:
    """Return the estimates without each fold in turn, a row a fold."""
    gram, moment = folds.clean.sum(axis=0), folds.moment.sum(axis=0)
    pairs = zip(folds.clean, folds.moment, strict=True)
    return np.array([solve(gram - own, moment - right, folds.names, bounded=bounded) for own, right in pairs])


def left_out_errors(folds: Folds) -> Array:
    """Return the mean square error in each fold of the model that was fitted to the others."""
    each = _without_each(folds, bounded=True)
    fitted = np.einsum("ki,kij,kj->k", each, folds.gram, each) - 2.0 * np.sum(each * folds.moment, axis=1)
    return np.asarray(np.maximum(0.0, folds.power + fitted) / folds.rows)


def spread(folds: Folds) -> Array:
    """Return the covariance that leaving out each fold in turn tells (B. Efron 1982): that of repetition."""
    each = _without_each(folds, bounded=False)
    return np.asarray(np.cov(each.T, ddof=0) * (len(each) - 1)).reshape(each.shape[1], -1)


def remainder(squares: Array, torque: Array, names: tuple[str, ...]) -> float:
    """Return the rms error of a model over the torque's; where it has an offset, over the torque's about its mean."""
    whole = np.var(torque) if "offset" in names else np.mean(torque**2)
    return math.sqrt(float(np.mean(squares)) / max(float(whole), 1e-300))


def quantile(folds: int, confidence: float) -> float:
    """Return the half width of an interval over the standard error: Student's t of the number of folds."""
    return float(special.stdtrit(max(1, folds - 1), 0.5 + 0.5 * confidence))
