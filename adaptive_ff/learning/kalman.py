"""Kalman filter of the coefficients: online recursive least squares behind the response of the loop.

    y = sum_i theta_i x_i + x_v + noise

``x_v`` and ``x_I`` are two states for what no column explains: white torque through the loop. The filter *is* the
recursive least squares of the paper behind another regression: with process noise ``(1/lambda - 1) P`` after each
update, without these two states and with ``G = 1`` it is equations (11) to (13).
"""

import math
from typing import NamedTuple

import numpy as np

from controllers.arrays import MutableArray, NDArray

Array = NDArray[np.float64]

LOOP = 2
"""States of the loop, before the coefficients."""

SWEEPS = 8
"""Sweeps of the projection at most."""


class Member(NamedTuple):
    """Estimate and covariance; arrays are changed in place."""

    mean: MutableArray
    covariance: MutableArray


class Prior(NamedTuple):
    """What is known before anything is measured.

    Attributes
    ----------
    mean : ndarray, shape (n,)
        Mean of each coefficient; of friction in units of the friction seen so far.
    covariance : ndarray, shape (n, n)
        Covariance, in the same units.
    scaled : ndarray of bool, shape (n,)
        Whether a coefficient is in these units.
    lowest, highest : ndarray, shape (n,)
        Bounds.
    """

    mean: Array
    covariance: Array
    scaled: NDArray[np.bool_]
    lowest: Array
    highest: Array


def flow_in_place(member: Member, rate: float, proportional: float, integral: float, noise: float) -> None:
    """Predict the two states of the loop.

    Parameters
    ----------
    member : Member
        Estimate and covariance.
    rate : float
        ``T/J``, s/(kg m^2).
    proportional, integral : float
        ``Kp`` (N m s/rad), and ``Ki T`` (N m s/rad).
    noise : float
        Variance of the velocity that a period of unexplained torque makes, (rad/s)^2.
    """
    mean, covariance = member.mean, member.covariance
    f00, f01 = 1.0 - rate * proportional, -rate
    f10, f11 = integral * f00, 1.0 + integral * f01
    velocity, torque = mean[0], mean[1]
    mean[0], mean[1] = f00 * velocity + f01 * torque, f10 * velocity + f11 * torque
    for j in range(LOOP, mean.size):
        first, second = covariance[0, j], covariance[1, j]
        covariance[0, j], covariance[1, j] = f00 * first + f01 * second, f10 * first + f11 * second
        covariance[j, 0], covariance[j, 1] = covariance[0, j], covariance[1, j]
    p00, p01, p11 = covariance[0, 0], covariance[0, 1], covariance[1, 1]
    covariance[0, 0] = f00 * (f00 * p00 + f01 * p01) + f01 * (f00 * p01 + f01 * p11) + noise
    covariance[0, 1] = f10 * (f00 * p00 + f01 * p01) + f11 * (f00 * p01 + f01 * p11)
    covariance[1, 0] = covariance[0, 1]
    covariance[1, 1] = f10 * (f10 * p00 + f11 * p01) + f11 * (f10 * p01 + f11 * p11)


def forget_loop_in_place(member: Member, torque: float) -> None:
    """Begin with a loop at rest whose integral may be wrong by a torque (N m)."""
    mean, covariance = member.mean, member.covariance
    for i in range(LOOP):
        mean[i] = 0.0
        for j in range(mean.size):
            covariance[i, j] = 0.0
            covariance[j, i] = 0.0
    covariance[1, 1] = torque * torque


def return_in_place(member: Member, prior: Prior, unit: float, kept: float) -> None:
    """Return to the prior: ``theta = a theta + (1 - a) theta_0``, ``P = a^2 P + (1 - a^2) P_0``, ``a = kept``."""
    mean, covariance = member.mean, member.covariance
    size, gained = mean.size, 1.0 - kept * kept
    for i in range(LOOP, size):
        first = prior.mean[i - LOOP] * (unit if prior.scaled[i - LOOP] else 1.0)
        mean[i] = first + kept * (mean[i] - first)
        for j in range(LOOP):
            covariance[i, j] *= kept
            covariance[j, i] = covariance[i, j]
        own = gained * (unit if prior.scaled[i - LOOP] else 1.0)
        for j in range(LOOP, i + 1):
            spread = own * (unit if prior.scaled[j - LOOP] else 1.0) * prior.covariance[i - LOOP, j - LOOP]
            covariance[i, j] = kept * kept * covariance[i, j] + spread
            covariance[j, i] = covariance[i, j]


def project(member: Member, x: Array, lag: float, velocity: float, work: MutableArray) -> tuple[float, float]:
    """Write ``P h`` into ``work`` for ``h = (1, 0, x)``; return the prediction ``h' m`` and its variance ``h' P h``.

    The columns hold at ``lag`` and ``velocity``, logarithms of friction lag and Stribeck velocity.
    """
    mean, covariance = member.mean, member.covariance
    predicted, variance = mean[0], 0.0
    for i in range(mean.size):
        total = covariance[i, 0]
        for j in range(x.size):
            total += covariance[i, LOOP + j] * x[j]
        work[i] = total
    variance = work[0]
    for j in range(x.size):
        variance += x[j] * work[LOOP + j]
        predicted += x[j] * mean[LOOP + j]
    predicted -= x[x.size - 2] * lag + x[x.size - 1] * velocity
    return predicted, variance


def update_in_place(
    member: Member, x: Array, y: float, noise: float, clip: float, lag: float, velocity: float, work: MutableArray
) -> tuple[float, float]:
    """Take one measurement into account; return its normalised innovation and its log-likelihood.

    An innovation beyond ``clip`` standard deviations counts less (Huber): its variance is then larger in proportion.
    """
    predicted, variance = project(member, x, lag, velocity, work)
    mean, covariance = member.mean, member.covariance
    innovation, spread = y - predicted, variance + noise
    normalised = innovation / math.sqrt(spread)
    weight = max(1.0, abs(normalised) / clip)
    spread *= weight
    likelihood = -0.5 * (innovation * innovation / spread + math.log(spread))
    for i in range(mean.size):
        gain = work[i] / spread
        mean[i] += gain * innovation
        for j in range(i + 1):
            covariance[i, j] -= gain * work[j]
            covariance[j, i] = covariance[i, j]
    return normalised, likelihood


def constrain_in_place(member: Member, prior: Prior, multipliers: MutableArray) -> None:
    """Project the estimate onto its bounds, in the metric of ``P^-1`` (Hildreth's dual coordinate ascent).

    ``min (theta - m)' P^-1 (theta - m)`` for ``lowest <= theta``: ``theta = m + P lambda``, ``lambda >= 0``. Then all
    are cut off at both bounds.
    """
    mean, covariance = member.mean, member.covariance
    count = mean.size - LOOP
    violated = False
    for i in range(count - 2):
        multipliers[i] = 0.0
        violated = violated or mean[LOOP + i] < prior.lowest[i]
    for _ in range(SWEEPS):
        if violated:
            moved = False
            for i in range(count - 2):
                spread = covariance[LOOP + i, LOOP + i]
                if prior.lowest[i] > -math.inf and spread > 0.0:
                    old = multipliers[i]
                    new = max(0.0, old + (prior.lowest[i] - mean[LOOP + i]) / spread)
                    if new != old:
                        multipliers[i], moved = new, True
                        for j in range(mean.size):
                            mean[j] += covariance[j, LOOP + i] * (new - old)
            violated = moved
    for i in range(count):
        mean[LOOP + i] = min(max(mean[LOOP + i], prior.lowest[i]), prior.highest[i])


def mix_in_place(first: Member, second: Member, weight: float, rate: float) -> float:
    """Let two members interact (interacting multiple models, Blom and Bar-Shalom 1988); return the second's weight.

    Parameters
    ----------
    first, second : Member
        The members.
    weight : float
        Probability of the second.
    rate : float
        Probability that the one in force changes in this period.
    """
    following = weight * (1.0 - rate) + (1.0 - weight) * rate
    to_first, to_second = weight * rate / (1.0 - following), (1.0 - weight) * rate / following
    a, b = first.mean, second.mean
    size = a.size
    for i in range(size):
        for j in range(i + 1):
            spread = (b[i] - a[i]) * (b[j] - a[j])
            p, q = first.covariance[i, j], second.covariance[i, j]
            one = p + to_first * (q - p) + to_first * (1.0 - to_first) * spread
            two = q + to_second * (p - q) + to_second * (1.0 - to_second) * spread
            first.covariance[i, j], first.covariance[j, i] = one, one
            second.covariance[i, j], second.covariance[j, i] = two, two
    for i in range(size):
        difference = b[i] - a[i]
        a[i] += to_first * difference
        b[i] -= to_second * difference
    return following
