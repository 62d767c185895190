"""Pre-estimation of the Stribeck curve, paper V-C: ``Fc, Fs, sigma, Vs, delta`` of (3) from quasi-static points.

It is the first step of an identification: the estimators assume ``Vs`` and ``delta``. At constant speed the torque of
the drive is the friction torque; :func:`adaptive_ff.stribeck.points.support_points` averages readings of such drives.
"""

import math
import warnings
from dataclasses import dataclass

import numpy as np
from scipy import linalg, stats

from adaptive_ff.errors import counted
from adaptive_ff.learning.batch_least_squares import Estimate
from adaptive_ff.learning.confidence import check_confidence
from adaptive_ff.stribeck.problem import BEND, FLAT, Array, Points, exponent, make_problem, solve_linear
from adaptive_ff.stribeck.profile import Estimated, interval_end, search
from controllers.arrays import ArrayLike
from controllers.checks import checked_array

LARGEST_RATIO = 10.0
"""Ratio of the ends of an interval of Vs or delta above which the points are said not to identify it."""

FEWEST_SPEEDS = 5
"""Number of different speeds that a fit needs: as many as (3) has parameters."""

EXACT = 1e-9
"""Residual, relative to the largest torque, below which points count as free of error."""


@dataclass(frozen=True, eq=False)
class StribeckFit:
    """A fitted Stribeck curve.

    Attributes
    ----------
    estimates : dict of Estimate
        ``coulomb``, ``stiction`` (N m), ``viscous`` (N m s/rad), ``stribeck_velocity`` (rad/s), ``stribeck_shape`` and,
        where both directions were given, ``offset`` (N m), with their intervals. An interval ends at zero or
        infinity where the points set no bound.
    covariance : ndarray, shape (n, n)
        Covariance of the estimates in that order, to first order; infinite where the points do not determine them.
    residuals : ndarray, shape (points,)
        Measured minus fitted torque, N m.
    scatter : float
        Root of the weighted mean square of the residuals, per degree of freedom: near one where the standard errors
        given are right and the curve is; in N m where none were given. The intervals take it into account.
    confidence : float
        Probability that the intervals are meant to have.
    determined : bool
        Whether the points identify Vs and delta, and Coulomb friction from zero.
    """

    estimates: dict[str, Estimate]
    covariance: Array
    residuals: Array
    scatter: float
    confidence: float
    determined: bool

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
        with np.errstate(over="ignore"):  # the share is then zero
            share = np.exp(-((np.abs(speeds) / self.stribeck_velocity) ** self.stribeck_shape))
        sliding = value["coulomb"] * (1.0 - share) + value["stiction"] * share
        friction: Array = np.sign(speeds) * sliding + value["viscous"] * speeds
        return friction


def fit_stribeck(
    velocity: ArrayLike, torque: ArrayLike, standard_error: ArrayLike | None = None, *, confidence: float = 0.95
) -> StribeckFit:
    """Fit the Stribeck curve (3) to measured points.

    Levenberg-Marquardt from several starts; see :mod:`adaptive_ff.stribeck.profile`. Friction is kept possible:
    ``Fs >= Fc >= 0``, ``sigma >= 0``, and positive Vs and delta (the paper allows a negative delta, which turns the
    curve over). The intervals are of the profile likelihood: in simulations they held the truth as often as they say
    where linearised ones did not (95 % intervals, twelve points with 3 % error each: 94 to 96 % against 86 to 96 %).

    Parameters
    ----------
    velocity : array_like, shape (n,)
        Velocities of the points, rad/s, taken as exact. Where both signs occur, both directions are fitted
        jointly, with an offset of the torque (gravity, a sensor's zero) as sixth parameter; where friction differs by
        direction, fit each alone. For averaged directions see ``SupportPoints.averaged_directions``.
    torque : array_like, shape (n,)
        Torque of the drive at these velocities, N m, positive where it acts forward.
    standard_error : array_like, shape (n,), optional
        Standard errors of the torques, N m; only their ratios matter. By default all are alike.
    confidence : float, optional
        Probability that the confidence intervals are meant to have.

    Returns
    -------
    StribeckFit
        The curve.

    Raises
    ------
    ValueError
        Arguments are of the wrong shape, not finite or out of range, there are too few points or speeds, or the torque
        is not that of a drive against friction.
    TypeError
        An argument is no number.

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
    problem = make_problem(points)
    bend, squares = search(problem)
    excess, coulomb, viscous = (float(value) for value in solve_linear(problem, bend).coefficients)
    values = {"coulomb": coulomb, "stiction": coulomb + excess, "viscous": viscous}
    values.update(zip(BEND, bend.tolist(), strict=True))
    fitted, slopes = _curve_and_slopes(points.velocity, values)
    if points.with_offset:
        values["offset"] = float(np.average(points.torque - fitted, weights=points.weight**2))
    residuals = points.torque - fitted - values.get("offset", 0.0)
    freedom = points.torque.size - len(values)
    variance = max(squares / freedom, (EXACT * float(np.max(np.abs(points.torque) * points.weight))) ** 2)
    covariance = variance * _inverse_information(slopes[:, : len(values)] * points.weight[:, np.newaxis])
    bound = float(stats.t.ppf(0.5 + 0.5 * confidence, freedom))
    estimates = _estimates(points, values, np.sqrt(np.diag(covariance)), bound, variance, squares)
    natural = np.array([estimates[name].value if name in BEND else 1.0 for name in values])
    vague = [name for name in BEND if not estimates[name].upper <= LARGEST_RATIO * estimates[name].lower]
    vague += ["coulomb"] * (estimates["coulomb"].lower == 0.0)
    if vague:
        _warn_of_vague(vague, estimates, points, confidence)
    covariance *= np.outer(natural, natural)
    return StribeckFit(estimates, covariance, residuals, math.sqrt(squares / freedom), float(confidence), not vague)


def _estimates(
    points: Points, values: dict[str, float], errors: Array, bound: float, variance: float, squares: float
) -> dict[str, Estimate]:
    """Return all parameters with the ends of their intervals.

    Parameters
    ----------
    points : Points
        The points.
    values : dict of float
        Parameters by name, Vs and delta as logarithms.
    errors : ndarray, shape (n,)
        Their standard errors, to first order: where the ends are looked for.
    bound : float
        Student's t at the ends.
    variance, squares : float
        Variance of a weighted residual, and their least sum of squares.
    """
    bend = np.array([values[name] for name in BEND])
    estimates = {}
    for (name, value), error in zip(values.items(), errors.tolist(), strict=True):
        sought = Estimated(name, value, bound * error if 0.0 < error < math.inf else max(abs(value), 1.0))
        lower, upper = (interval_end(points, sought, bend, squares, bound**2 * variance, side) for side in (-1.0, 1.0))
        estimates[name] = Estimate(value, error, lower, upper)
        if name in BEND:
            natural = math.exp(value)
            estimates[name] = Estimate(natural, error * natural, math.exp(lower), math.exp(upper))
    return estimates


def _curve_and_slopes(velocity: Array, values: dict[str, float]) -> tuple[Array, Array]:
    """Return the curve and its derivatives by the parameters, Vs and delta as logarithms, and by an offset."""
    bend = np.array([values[name] for name in BEND])
    power, ratio = exponent(np.log(np.abs(velocity)), bend)
    share, sign = np.exp(-power), np.sign(velocity)
    excess = values["stiction"] - values["coulomb"]
    curve = sign * (values["coulomb"] + excess * share) + values["viscous"] * velocity
    by_velocity = sign * excess * share * power * math.exp(bend[1])
    ones = np.ones_like(velocity)
    return curve, np.column_stack(
        [sign * (1.0 - share), sign * share, velocity, by_velocity, -by_velocity * ratio, ones]
    )


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


def _warn_of_vague(names: list[str], estimates: dict[str, Estimate], points: Points, confidence: float) -> None:
    ranges = [f"{name} from {estimates[name].lower:.3g} to {estimates[name].upper:.3g}" for name in names]
    speeds = np.abs(points.velocity)
    warnings.warn(
        f"the points, from {speeds.min():.3g} to {speeds.max():.3g} rad/s, do not identify the Stribeck curve: at a "
        f"confidence of {confidence:g} they allow {' and '.join(ranges)}; it takes points where friction falls, and "
        "some on either side",
        stacklevel=3,
    )


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
        if not np.all(np.isfinite(values)):
            place = int(np.argmin(np.isfinite(values)))
            raise ValueError(f"{name}[{place}] = {values[place]} is not allowed: all must be finite")
    for name, values, rule in (
        ("velocity", np.abs(speeds), "at rest friction is whatever torque there is; it must not be zero"),
        ("standard_error", errors, "it must be positive"),
    ):
        if np.any(values <= 0.0):
            place = int(np.argmax(values <= 0.0))
            shown = errors[place] if name == "standard_error" else speeds[place]
            raise ValueError(f"{name}[{place}] = {shown:g} is not allowed: {rule}")
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
