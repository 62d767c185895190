"""Support points of a friction curve: readings of drives at constant speed, averaged.

At constant speed the drive's torque is the friction torque. Each drive gives one point: the mean of its readings, with
their spread and the standard error of the mean.
"""

import math
from dataclasses import dataclass

import numpy as np
from scipy.optimize import brentq
from scipy.special import polygamma, psi

from adaptive_ff.learning.checks import check_all
from controllers.arrays import ArrayLike, NDArray
from controllers.checks import checked_array

Array = NDArray[np.float64]

SMALLEST_TREND = 5
"""Number of points from which a trend of the spread with the speed is estimated."""


@dataclass(frozen=True, eq=False)
class SupportPoints:
    """Averaged points of a friction curve."""

    velocity: Array  # shape (n,); mean velocity, rad/s, ascending; its sign is the direction
    torque: Array  # shape (n,); mean torque of the drive, N m
    spread: Array  # shape (n,); standard deviation of the torque readings, N m
    count: NDArray[np.int64]  # shape (n,); number of readings
    # shape (n,); standard error of the mean torque, N m; from the spread of the point and that of its neighbours, see
    # :func:`support_points`
    standard_error: Array


def support_points(velocity: ArrayLike, torque: ArrayLike, drive: ArrayLike | None = None) -> SupportPoints:
    """Average the readings of drives at constant speed.

    A spread from few readings is itself uncertain, and weights made from it spoil the intervals of a fit (measured:
    with five readings a point, 95 % intervals of the Stribeck velocity held the truth in 85 % of cases). So the
    standard errors borrow from the other points, as much as the data say that spreads follow a common trend with the
    speed: G. K. Smyth, "Linear models and empirical Bayes methods" (Stat. Appl. Genet. Mol. Biol. 3, 2004).

    Parameters
    ----------
    velocity : array_like, shape (n,) or (drives, readings)
        Measured velocity, rad/s, of the part of each drive where it has become constant.
    torque : array_like, of the same shape
        Torque of the drive, N m, positive where it acts forward. Readings are taken as independent; leave out those
        that follow each other faster than the noise changes.
    drive : array_like, shape (n,), optional
        Which drive a reading belongs to: equal labels, such as the commanded velocity, make one point. Not given where
        each row is a drive.

    Returns
    -------
    SupportPoints
        One point for each drive, in ascending order of velocity.

    Raises
    ------
    ValueError
        Shapes do not agree, a value is not finite, a drive has fewer than two readings or all alike, or does not move.
    """
    speeds, torques = checked_array("velocity", velocity), checked_array("torque", torque)
    labels = _check_readings(speeds, torques, drive)
    _, place, count = np.unique(labels, return_inverse=True, return_counts=True)
    if np.any(count < 2):
        raise ValueError("a drive has a single reading; there must be at least two to know their spread")
    speeds, torques = speeds.ravel(), torques.ravel()
    mean_speed = np.bincount(place, speeds) / count
    mean_torque = np.bincount(place, torques) / count
    spread = np.sqrt(np.bincount(place, (torques - mean_torque[place]) ** 2) / (count - 1))
    for name, values, fault in (("velocity", mean_speed, "does not move"), ("torque", spread, "has no spread")):
        if np.any(values == 0.0):
            drives = np.nonzero(values == 0.0)[0]
            raise ValueError(
                f"{name}: drive {int(drives[0])} {fault}; all must move, and their readings differ (readings that a "
                "coarse resolution makes equal need a standard error of one's own)"
            )
    error = _shared_spread(np.log(np.abs(mean_speed)), spread, count) / np.sqrt(count)
    order = np.argsort(mean_speed, kind="stable")
    return SupportPoints(
        mean_speed[order], mean_torque[order], spread[order], count[order].astype(np.int64), error[order]
    )


def _shared_spread(log_speed: Array, spread: Array, count: NDArray[np.intp]) -> Array:
    """Return spreads drawn towards their trend with the speed, by what chance alone explains of their scatter."""
    freedom = count - 1.0
    level = 2.0 * np.log(spread) - psi(0.5 * freedom) + np.log(0.5 * freedom)  # unbiased for the log of the variance
    degree = 1 if spread.size >= SMALLEST_TREND and np.ptp(log_speed) > 0.0 else 0
    trend = np.polyval(np.polyfit(log_speed, level, degree), log_speed)
    scatter = float(np.sum((level - trend) ** 2)) / max(1, spread.size - degree - 1)
    excess = scatter - float(np.mean(polygamma(1, 0.5 * freedom)))
    common = np.exp(trend)
    if spread.size <= degree + 1:
        return spread  # nothing to borrow from
    if excess <= polygamma(1, 1e6):
        return np.asarray(np.sqrt(common))  # chance alone explains the scatter
    weight = 2.0 * brentq(lambda half: polygamma(1, half) - excess, 1e-3, 1e6) if excess < polygamma(1, 1e-3) else 0.0
    common *= math.exp(float(psi(0.5 * weight)) - math.log(0.5 * weight)) if weight > 0.0 else 1.0
    return np.asarray(np.sqrt((weight * common + freedom * spread**2) / (weight + freedom)))


def _check_readings(velocity: Array, torque: Array, drive: ArrayLike | None) -> NDArray[np.generic]:
    """Return the label of each reading, flat."""
    if velocity.shape != torque.shape or velocity.size == 0:
        raise ValueError(f"velocity has shape {velocity.shape}, torque {torque.shape}; they must be alike, not empty")
    if drive is None:
        if velocity.ndim != 2:
            raise ValueError(
                f"velocity has {velocity.ndim} dimension(s) and drive is not given; without it there must be two, "
                "one row for each drive"
            )
        labels: NDArray[np.generic] = np.repeat(np.arange(velocity.shape[0]), velocity.shape[1])
    else:
        labels = np.asarray(drive)
        if labels.shape != velocity.shape or velocity.ndim != 1:
            raise ValueError(f"drive has shape {labels.shape}, velocity {velocity.shape}; both must be (readings,)")
        if labels.dtype.kind == "f" and not np.all(np.isfinite(labels)):
            raise ValueError("drive has a label that is not a finite number")
    for name, values in (("velocity", velocity), ("torque", torque)):
        check_all(name, values, np.isfinite(values), "all readings must be finite")
    return labels
