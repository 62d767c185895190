"""Pre-estimation of the Stribeck curve, paper V-C: ``Fc, Fs, sigma, Vs, delta`` of (3) from quasi-static points.

At constant speed the torque of the drive is the friction torque. For given ``Vs`` and ``delta`` the curve is linear in
``Fc``, ``Fs - Fc`` and ``sigma``, none of them negative, and in an offset; so only ``log Vs`` and ``log delta`` are
searched (variable projection: G. Golub, V. Pereyra 1973). Without the signs noisy points are fitted best by curves such
as ``Fc`` = -736 N m, ``Vs`` = 5.6 rad/s. Intervals are of the profile likelihood (D. Bates, D. Watts, "Nonlinear
Regression Analysis and Its Applications", 1988, chapter 6): they need no symmetry and no end where the data give none.
"""

import math
import warnings
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from scipy import linalg, special
from scipy.optimize import brentq, least_squares, nnls

from adaptive_ff.errors import counted
from adaptive_ff.learning.batch_least_squares import Estimate
from adaptive_ff.learning.checks import check_all, check_confidence
from controllers.arrays import ArrayLike, NDArray
from controllers.checks import checked_array

Array = NDArray[np.float64]

BEND = ("stribeck_velocity", "stribeck_shape")
"""Parameters that are searched, as logarithms."""

LARGEST_RATIO = 10.0
"""Ratio of the ends of an interval of Vs or delta above which the points are said not to identify it."""

FEWEST_SPEEDS = 5
"""Number of different speeds that a fit needs: as many as (3) has parameters."""

EXACT, FLAT = 1e-9, 1e-10
"""Residual, over the largest torque, below which points are free of error; size below which columns are dependent."""

SHAPE_STARTS, VELOCITY_STARTS = (0.5, 1.0, 2.0, 4.0, 8.0), 12
"""Shape factors from which the search starts, each at the best of so many Stribeck velocities."""

FARTHEST = 5.0
"""Logarithm of the factor beyond which the end of an interval counts as infinite, and of the range searched."""


@dataclass(frozen=True, eq=False)
class StribeckFit:
    """A fitted Stribeck curve."""

    # ``coulomb``, ``stiction`` (N m), ``viscous`` (N m s/rad), ``stribeck_velocity`` (rad/s), ``stribeck_shape`` and,
    # where both directions were given, ``offset`` (N m), with their intervals. An interval ends at zero or infinity
    # where the points set no bound
    estimates: dict[str, Estimate]
    # shape (n, n); covariance of the estimates in that order, to first order; infinite where the points do not
    # determine them
    covariance: Array
    residuals: Array  # shape (points,); measured minus fitted torque, N m
    # root of the weighted mean square of the residuals per degree of freedom: near one where standard errors and curve
    # are right; in N m where none were given. The intervals take it into account
    scatter: float
    confidence: float  # probability that the intervals are meant to have
    determined: bool  # whether the points identify Vs and delta, and Coulomb friction from zero

    @property
    def stribeck_velocity(self) -> float:
        """Stribeck velocity ``Vs``, rad/s, as the estimators assume it."""
        return self.estimates["stribeck_velocity"].value

    @property
    def stribeck_shape(self) -> float:
        """Stribeck shape factor ``delta``, as the estimators assume it."""
        return self.estimates["stribeck_shape"].value

    def curve(self, velocity: ArrayLike) -> Array:
        """Return the friction torque (3), N m, without the offset, at velocities in rad/s; zero at rest."""
        value = {name: estimate.value for name, estimate in self.estimates.items()}
        speeds = checked_array("velocity", velocity)
        with np.errstate(over="ignore"):  # the fraction is then zero
            fraction = np.exp(-((np.abs(speeds) / self.stribeck_velocity) ** self.stribeck_shape))
        sliding = value["coulomb"] * (1.0 - fraction) + value["stiction"] * fraction
        return np.asarray(np.sign(speeds) * sliding + value["viscous"] * speeds)


class Points(NamedTuple):
    """Velocities (rad/s), torques (N m), one over their standard errors, and whether the torque may have an offset."""

    velocity: Array
    torque: Array
    weight: Array
    with_offset: bool


def fit_stribeck(
    velocity: ArrayLike, torque: ArrayLike, standard_error: ArrayLike | None = None, *, confidence: float = 0.95
) -> StribeckFit:
    """Fit the Stribeck curve (3) to measured points, with ``Fs >= Fc >= 0``, ``sigma >= 0``, positive Vs and delta.

    Parameters
    ----------
    velocity : array_like, shape (n,)
        Velocities of the points, rad/s, taken as exact. Where both signs occur, both directions are fitted
        jointly, with an offset of the torque as sixth parameter; where friction differs by direction, fit each alone.
    torque : array_like, shape (n,)
        Torque of the drive at these velocities, N m, positive where it acts forward.
    standard_error : array_like, shape (n,), optional
        Standard errors of the torques, N m; only their ratios matter. By default all are alike.
    confidence : float, optional
        Probability that the confidence intervals are meant to have.

    Raises
    ------
    ValueError
        Arguments are of the wrong shape, not finite or out of range, there are too few points or speeds, or the torque
        is not that of a drive against friction.

    Warns
    -----
    UserWarning
        The points do not identify Vs or delta, or whether there is Coulomb friction at all.

    Examples
    --------
    >>> speed = np.geomspace(0.005, 0.3, 20)  # rad/s
    >>> fit = fit_stribeck(speed, 60.0 + 30.0 * np.exp(-speed / 0.05) + 80.0 * speed)
    >>> round(fit.stribeck_velocity, 6), round(fit.stribeck_shape, 6)
    (0.05, 1.0)
    """
    points = _check_points(velocity, torque, standard_error, confidence)
    bend, squares = search(points)
    (excess, coulomb, viscous), _ = solve_linear(points, bend)
    sizes = (coulomb, coulomb + excess, viscous, *bend)
    values = dict(zip(("coulomb", "stiction", "viscous", *BEND), map(float, sizes), strict=True))
    fitted, slopes = _curve_and_slopes(points.velocity, values)
    if points.with_offset:
        values["offset"] = float(np.average(points.torque - fitted, weights=points.weight**2))
    residuals = points.torque - fitted - values.get("offset", 0.0)
    freedom = points.torque.size - len(values)
    variance = max(squares / freedom, (EXACT * float(np.max(np.abs(points.torque) * points.weight))) ** 2)
    covariance = variance * _inverse_information(slopes[:, : len(values)] * points.weight[:, np.newaxis])
    bound = float(special.stdtrit(freedom, 0.5 + 0.5 * confidence))
    estimates, natural = {}, np.ones(len(values))
    for place, (name, value) in enumerate(values.items()):
        error = math.sqrt(covariance[place, place])
        step = bound * error if 0.0 < error < math.inf else max(abs(value), 1.0)
        ends = [
            _interval_end(points, (name, value, step), bend, (squares, bound**2 * variance), side)
            for side in (-1.0, 1.0)
        ]
        if name in BEND:
            natural[place] = value = math.exp(value)
            ends, error = [math.exp(end) for end in ends], error * value
        estimates[name] = Estimate(value, error, *ends)
    vague = [name for name in BEND if not estimates[name].upper <= LARGEST_RATIO * estimates[name].lower]
    vague += ["coulomb"] * (estimates["coulomb"].lower == 0.0)
    if vague:
        ranges = [f"{name} from {estimates[name].lower:.3g} to {estimates[name].upper:.3g}" for name in vague]
        speeds = np.abs(points.velocity)
        warnings.warn(
            f"the points, from {speeds.min():.3g} to {speeds.max():.3g} rad/s, do not identify the Stribeck curve: at "
            f"a confidence of {confidence:g} they allow {' and '.join(ranges)}; it takes points where friction falls, "
            "and some on either side",
            stacklevel=2,
        )
    covariance *= np.outer(natural, natural)
    return StribeckFit(estimates, covariance, residuals, math.sqrt(squares / freedom), float(confidence), not vague)


def _fraction(velocity: Array, bend: Array) -> tuple[Array, Array, Array]:
    """Return ``exp(-x)``, ``x = (|w|/Vs)^delta``, cut off where the fraction is zero, and ``log(|w|/Vs)``."""
    ratio = np.log(np.abs(velocity)) - bend[0]
    power = np.exp(np.minimum(math.exp(bend[1]) * ratio, math.log(50.0)))
    return np.exp(-power), power, ratio


def solve_linear(points: Points, bend: Array, held: tuple[str, float] = ("", 0.0)) -> tuple[Array, Array]:
    """Return ``Fs - Fc``, ``Fc`` and ``sigma`` (those that are free) at a bend, and the weighted residuals.

    A parameter may be held at a value.
    """
    velocity, torque, weight, with_offset = points
    name, value = held
    sign = np.sign(velocity)
    falling = sign * _fraction(velocity, bend)[0] - (sign if name == "stiction" else 0.0)
    taken = {"coulomb": sign, "stiction": sign, "viscous": velocity, "offset": np.ones_like(sign)}
    columns = [falling, *(taken[key] for key in ("coulomb", "viscous") if key != name)]
    if name == "stiction":
        del columns[1]
    matrix = np.column_stack([*columns, torque - value * taken.get(name, np.zeros_like(sign))]) * weight[:, np.newaxis]
    if with_offset and name != "offset":
        unit = weight / np.linalg.norm(weight)
        matrix -= np.outer(unit, unit @ matrix)
    found = nnls(matrix[:, :-1], matrix[:, -1])[0]
    return found, matrix[:, :-1] @ found - matrix[:, -1]


def _minimise(points: Points, start: Array, held: tuple[str, float], tolerance: float) -> tuple[Array, float]:
    """Follow a start (``log Vs``, ``log delta``) to its minimum; return it and the weighted sum of squares there."""
    free = np.array([name != held[0] for name in BEND])
    speeds = np.log(np.abs(points.velocity))
    lowest, highest = np.array([speeds.min(), 0.0]) - FARTHEST, np.array([speeds.max(), 0.0]) + FARTHEST

    def full(searched: Array) -> Array:
        bend = np.full(2, held[1])
        bend[free] = np.clip(searched, lowest[free], highest[free])
        return bend

    result = least_squares(
        lambda searched: solve_linear(points, full(searched), held)[1],
        start[free],
        method="lm",
        ftol=tolerance,
        xtol=tolerance,
        gtol=1e-15,
    )
    return full(result.x), 2.0 * float(result.cost)


def search(points: Points, held: tuple[str, float] = ("", 0.0)) -> tuple[Array, float]:
    """Return the best minimum (bend and weighted sum of squares) found from several starts."""
    speeds = np.log(np.abs(points.velocity))
    found = []
    for shape in SHAPE_STARTS:
        starts = [np.array([one, math.log(shape)]) for one in np.linspace(speeds.min(), speeds.max(), VELOCITY_STARTS)]
        squares = [float(np.sum(solve_linear(points, start, held)[1] ** 2)) for start in starts]
        found.append(_minimise(points, starts[int(np.argmin(squares))], held, 1e-12))
    return min(found, key=lambda minimum: minimum[1])


def _interval_end(
    points: Points, sought: tuple[str, float, float], bend: Array, squares: tuple[float, float], side: float
) -> float:
    """Return where the sum of squares, minimised over all else, has risen to the bound; infinite where it does not.

    ``sought`` is a name (Vs, delta as logarithms), its value and the expected distance; ``squares`` the least sum of
    squares and its rise; ``side`` 1 for the upper end, -1 for the lower.
    """
    name, value, step = sought
    reach, limit = FARTHEST, side * math.inf
    if name not in BEND:
        reach = math.exp(FARTHEST) * (abs(value) + step)
        if side < 0.0 and name != "offset":
            reach, limit = value, 0.0  # none is negative
    near, known = [bend], {0.0: -1.0}

    def beyond(distance: float) -> float:
        if distance not in known:
            near[0], there = _minimise(points, near[0], (name, value + side * distance), 1e-6)
            known[distance] = math.sqrt(max(there - squares[0], 0.0) / squares[1]) - 1.0
        return known[distance]

    inside, outside = 0.0, min(step, reach, 1.0 if name in BEND else math.inf)
    while beyond(outside) < 0.0:
        if outside >= reach:
            return limit
        inside, outside = outside, min(1.6 * outside, reach)
    return value + side * float(brentq(beyond, inside, outside, xtol=3e-3 * outside, rtol=1e-3))


def _curve_and_slopes(velocity: Array, values: dict[str, float]) -> tuple[Array, Array]:
    """Return the curve and its derivatives by the parameters, Vs and delta as logarithms, and by an offset."""
    bend, sign = np.array([values[name] for name in BEND]), np.sign(velocity)
    fraction, power, ratio = _fraction(velocity, bend)
    excess = values["stiction"] - values["coulomb"]
    curve = sign * (values["coulomb"] + excess * fraction) + values["viscous"] * velocity
    by_velocity = sign * excess * fraction * power * math.exp(bend[1])
    ones = np.ones_like(velocity)
    slopes = [sign * (1.0 - fraction), sign * fraction, velocity, by_velocity, -by_velocity * ratio, ones]
    return curve, np.column_stack(slopes)


def _inverse_information(slopes: Array) -> Array:
    """Return ``(X'X)^-1`` by singular values; infinite for what the columns do not determine."""
    length = np.linalg.norm(slopes, axis=0)
    scale = np.where(length > 0.0, length, 1.0)
    _, singular, right = linalg.svd(slopes / scale, full_matrices=False)
    known = singular > FLAT * singular[0]
    root = right[known].T / singular[known] / scale[:, np.newaxis]
    inverse: Array = root @ root.T
    lost = np.any(np.abs(right[~known]) > 1e-6, axis=0)
    inverse[lost, :] = inverse[:, lost] = math.inf
    return inverse


def _check_points(
    velocity: ArrayLike, torque: ArrayLike, standard_error: ArrayLike | None, confidence: float
) -> Points:
    check_confidence(confidence)
    speeds, torques = checked_array("velocity", velocity), checked_array("torque", torque)
    errors = np.ones_like(torques) if standard_error is None else checked_array("standard_error", standard_error)
    if speeds.ndim != 1:
        raise ValueError(f"velocity has shape {speeds.shape}; it must be (points,)")
    for name, values in (("velocity", speeds), ("torque", torques), ("standard_error", errors)):
        if values.shape != speeds.shape:
            raise ValueError(f"{name} has shape {values.shape}; it must be {speeds.shape}, as velocity")
        check_all(name, values, np.isfinite(values))
    check_all("velocity", speeds, speeds != 0.0, "at rest friction is whatever torque there is; it must not be zero")
    check_all("standard_error", errors, errors > 0.0, "it must be positive")
    with_offset = bool(np.any(speeds > 0.0) and np.any(speeds < 0.0))
    different = np.unique(np.round(np.log(np.abs(speeds)), 9)).size
    fewest = FEWEST_SPEEDS + 1 + with_offset
    if speeds.size < fewest or different < FEWEST_SPEEDS:
        raise ValueError(
            f"velocity has {counted(speeds.size, 'point')} at {counted(different, 'different speed')}; there must be "
            f"at least {fewest} points at {FEWEST_SPEEDS} speeds"
        )
    forward, backward = torques[speeds > 0.0], torques[speeds < 0.0]
    rise = float(np.mean(forward) - np.mean(backward)) if with_offset else float(np.mean(np.sign(speeds) * torques))
    if rise <= 0.0:
        raise ValueError(
            f"torque is {rise:g} N m higher in the direction of motion than against it; it must be higher: the torque "
            "of the drive has the sign of the velocity"
        )
    return Points(speeds, torques, 1.0 / errors, with_offset)
