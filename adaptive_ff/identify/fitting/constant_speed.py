"""Points of the friction curve from stretches of a log at constant speed, and the Stribeck curve through them."""

import warnings
from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from adaptive_ff.errors import counted
from adaptive_ff.identify.fitting.prediction import Prediction
from adaptive_ff.logs.defects import runs
from adaptive_ff.logs.derivatives import Array
from adaptive_ff.stribeck.fit import StribeckFit, fit_stribeck
from adaptive_ff.stribeck.points import SPEED_TOLERANCE, SupportPoints, support_points

CONSTANT = 0.02
"""Largest deviation of the speed from its mean in a stretch, and largest change in a cycle of the band, over it."""

INERTIAL_SHARE = 0.1
"""Largest torque of inertia in a stretch, over Coulomb friction."""

SHORTEST = 4.0
"""Cycles of the band that a stretch must have."""


class FrictionCurve(NamedTuple):
    """What stretches at constant speed show of friction.

    Attributes
    ----------
    points : SupportPoints, or None
        Mean velocity and friction torque (offset included) by speed and direction; None where there is no stretch.
    fit : StribeckFit, or None
        The Stribeck curve through them, where there are points enough.
    remark : str
        What came of it, as a sentence.
    """

    points: SupportPoints | None
    fit: StribeckFit | None
    remark: str


def friction_curve(
    predictions: Sequence[Prediction], coulomb: float, bandwidth: float, confidence: float
) -> FrictionCurve:
    """Find stretches at constant speed, average them to points, and fit the Stribeck curve.

    Parameters
    ----------
    predictions : sequence of Prediction
        Rows of the pieces.
    coulomb : float
        Coulomb friction, N m: the measure for the torque of inertia.
    bandwidth : float
        Band, Hz; readings are a cycle of it apart, so that they count as independent.
    confidence : float
        Probability that the intervals are meant to have.
    """
    speeds, torques = _readings(predictions, coulomb, bandwidth)
    if not speeds:
        return FrictionCurve(None, None, "the log has no stretch at constant speed, so no point of the Stribeck curve")
    velocity, torque = np.concatenate(speeds), np.concatenate(torques)
    label = np.repeat(_grouped(np.array([np.mean(part) for part in speeds])), [part.size for part in speeds])
    try:
        points = support_points(velocity, torque, label)
    except ValueError as error:
        return FrictionCurve(None, None, f"stretches at constant speed make no points of the Stribeck curve: {error}")
    count = points.velocity.size
    with warnings.catch_warnings(record=True) as caught:
        warnings.simplefilter("always")
        try:
            fit = fit_stribeck(points.velocity, points.torque, points.standard_error, confidence=confidence)
        except ValueError as error:
            reason = f"there is no Stribeck curve through {counted(count, 'point')} at constant speed: {error}"
            return FrictionCurve(points, None, reason)
    if caught:
        return FrictionCurve(points, fit, f"{count} points at constant speed: {caught[0].message}")
    return FrictionCurve(points, fit, f"{count} points at constant speed make a Stribeck curve")


def _readings(predictions: Sequence[Prediction], coulomb: float, bandwidth: float) -> tuple[list[Array], list[Array]]:
    """Return velocities and friction torques of each stretch."""
    speeds, torques = [], []
    for rows in predictions:
        every = max(1, round(1.0 / (bandwidth * rows.period)))
        needed = SHORTEST / (bandwidth * rows.period)
        change = np.abs(rows.acceleration)
        steady = rows.slides & (change < CONSTANT * bandwidth * np.abs(rows.velocity))
        steady &= np.abs(rows.inertia) * change < INERTIAL_SHARE * abs(coulomb)
        for start, stop in runs(steady):
            velocity = rows.velocity[start:stop]
            mean = float(np.mean(velocity))
            if stop - start >= needed and np.max(np.abs(velocity - mean)) <= CONSTANT * abs(mean):
                speeds.append(velocity[::every])
                torques.append(rows.friction[start:stop:every])
    return speeds, torques


def _grouped(means: Array) -> Array:
    """Return for each mean velocity the label of its group: neighbours within 5 % are one speed."""
    order = np.argsort(means, kind="stable")
    ranked = means[order]
    apart = np.diff(ranked) > SPEED_TOLERANCE * np.minimum(np.abs(ranked[1:]), np.abs(ranked[:-1]))
    labels = np.empty(means.size)
    labels[order] = np.concatenate([[0.0], np.cumsum(apart)])
    return labels
