"""Kalman filter of the coefficients: online recursive least squares behind the response of the loop.

    y = sum_i theta_i x_i + x_v + noise

``x_v`` and ``x_I`` are two states for what no column explains: white torque through the loop, much or little of it. The
filter *is* the recursive least squares of the paper behind another regression: with process noise ``(1/lambda - 1) P``
after each update, without these two states and with ``G = 1`` it is equations (11) to (13).
"""

import math
from typing import NamedTuple

import numpy as np

from controllers.arrays import MutableArray, NDArray, row_of

Array = NDArray[np.float64]

LOOP = 2
"""States of the loop, before the coefficients."""

FARTHEST = 50.0
"""Largest logarithm of the odds of one interval."""

SWEEPS = 8
"""Sweeps of the projection at most."""

RESOLVED = 1e-8
"""Least noise over what the covariance predicts: less, and what is left of it is rounding."""


class Estimate(NamedTuple):
    """Mean and covariance, a lower triangle (``controllers.arrays``); arrays are changed in place."""

    mean: MutableArray
    covariance: MutableArray


class Modes(NamedTuple):
    """White torque of two modes, as the velocity that it makes in an interval, and which of them is in force.

    Attributes
    ----------
    quiet, loud : float
        Variance of that velocity, (rad/s)^2.
    weight : float
        Probability of the loud mode.
    """

    quiet: float
    loud: float
    weight: float


class Prior(NamedTuple):
    """What is known before anything is measured."""

    mean: Array  # shape (n,); mean of each coefficient; of friction in units of the friction so far
    covariance: Array  # covariance in these units, a lower triangle; zero between coefficients in them and others
    scaled: NDArray[np.bool_]  # shape (n,); whether a coefficient is in these units
    lowest: Array  # shape (n,); lower bounds
    highest: Array  # shape (n,); upper bounds


def flow_in_place(estimate: Estimate, rate: float, proportional: float, integral: float, noise: float) -> None:
    """Predict the two states of the loop.

    Parameters
    ----------
    estimate : Estimate
        Mean and covariance.
    rate : float
        ``T/J``, s/(kg m^2).
    proportional, integral : float
        ``Kp`` (N m s/rad), and ``Ki T`` (N m s/rad).
    noise : float
        Variance of the velocity that a period of unexplained torque makes, (rad/s)^2.
    """
    mean, covariance = estimate.mean, estimate.covariance
    f00, f01 = 1.0 - rate * proportional, -rate
    f10, f11 = integral * f00, 1.0 + integral * f01
    velocity, torque = mean[0], mean[1]
    mean[0], mean[1] = f00 * velocity + f01 * torque, f10 * velocity + f11 * torque
    for i in range(LOOP, mean.size):
        row = row_of(i)
        first, second = covariance[row], covariance[row + 1]
        covariance[row], covariance[row + 1] = f00 * first + f01 * second, f10 * first + f11 * second
    p00, p01, p11 = covariance[0], covariance[1], covariance[2]
    covariance[0] = f00 * (f00 * p00 + f01 * p01) + f01 * (f00 * p01 + f01 * p11) + noise
    covariance[1] = f10 * (f00 * p00 + f01 * p01) + f11 * (f00 * p01 + f01 * p11)
    covariance[2] = f10 * (f10 * p00 + f11 * p01) + f11 * (f10 * p01 + f11 * p11)


def forget_loop_in_place(estimate: Estimate, torque: float) -> None:
    """Begin with a loop at rest whose integral may be wrong by a torque (N m)."""
    mean, covariance = estimate.mean, estimate.covariance
    mean[0], mean[1] = 0.0, 0.0
    for i in range(mean.size):
        row = row_of(i)
        for j in range(min(i + 1, LOOP)):
            covariance[row + j] = 0.0
    covariance[2] = torque * torque


def return_in_place(estimate: Estimate, prior: Prior, unit: float, kept: float) -> None:
    """Return to the prior: ``theta = a theta + (1 - a) theta_0``, ``P = a^2 P + (1 - a^2) P_0``, ``a = kept``."""
    mean, covariance = estimate.mean, estimate.covariance
    for i in range(LOOP, mean.size):
        row, before, size = row_of(i), row_of(i - LOOP), unit if prior.scaled[i - LOOP] else 1.0
        gained = (1.0 - kept * kept) * size * size
        first = prior.mean[i - LOOP] * size
        mean[i] = first + kept * (mean[i] - first)
        for j in range(LOOP):
            covariance[row + j] *= kept
        for j in range(i - LOOP + 1):
            covariance[row + LOOP + j] = (
                kept * kept * covariance[row + LOOP + j] + gained * prior.covariance[before + j]
            )


def project(estimate: Estimate, x: Array, lag: float, velocity: float, work: MutableArray) -> tuple[float, float]:
    """Write ``P h`` into ``work`` for ``h = (1, 0, x)``; return the prediction ``h' m`` and its variance ``h' P h``.

    The columns hold at ``lag`` and ``velocity``, logarithms of friction lag and Stribeck velocity.
    """
    mean, covariance = estimate.mean, estimate.covariance
    predicted, variance = mean[0], 0.0
    work[0], work[1] = covariance[0], covariance[1]
    for i in range(x.size):
        row, own = row_of(LOOP + i), x[i]
        total = covariance[row]
        work[0] += own * covariance[row]
        work[1] += own * covariance[row + 1]
        for j in range(i):
            total += covariance[row + LOOP + j] * x[j]
            work[LOOP + j] += own * covariance[row + LOOP + j]
        work[LOOP + i] = total + own * covariance[row + LOOP + i]
    variance = work[0]
    for j in range(x.size):
        variance += x[j] * work[LOOP + j]
        predicted += x[j] * mean[LOOP + j]
    predicted -= x[x.size - 2] * lag + x[x.size - 1] * velocity
    return predicted, variance


def update_in_place(
    estimate: Estimate,
    x: Array,
    y: float,
    noise: float,
    modes: Modes,
    clip: float,
    lag: float,
    velocity: float,
    work: MutableArray,
) -> tuple[float, float]:
    """Take one measurement into account; return its normalised innovation and the probability of the loud mode.

    Each mode updates the same estimate, and what they find is merged into one mean and covariance (generalised pseudo
    Bayes of first order, Ackerson and Fu 1970). With ``p = P h``, white noise ``q_j`` of the first state ``e`` and
    innovation ``nu``:

        S_j = h' P h + q_j + R,    K_j = (p + q_j e) / S_j,    w_j ~ w_j exp(-(nu^2 / S_j + ln S_j) / 2)
        P + sum_j w_j (q_j e e' - S_j K_j K_j') + w_1 w_2 nu^2 (K_2 - K_1) (K_2 - K_1)'

    An innovation beyond ``clip`` standard deviations counts less (Huber): its variance is then larger in proportion.
    """
    predicted, variance = project(estimate, x, lag, velocity, work)
    mean, covariance = estimate.mean, estimate.covariance
    innovation, least = y - predicted, variance + max(noise, RESOLVED * variance)
    quiet, loud = least + modes.quiet, least + modes.loud
    normalised = innovation / math.sqrt(quiet)
    quiet *= max(1.0, abs(normalised) / clip)
    loud *= max(1.0, abs(innovation) / (clip * math.sqrt(loud)))
    odds = -0.5 * (innovation * innovation * (1.0 / quiet - 1.0 / loud) + math.log(quiet / loud))
    weight = modes.weight / (modes.weight + (1.0 - modes.weight) * math.exp(min(FARTHEST, max(-FARTHEST, odds))))
    one, two = (1.0 - weight) / quiet, weight / loud
    between = weight * (1.0 - weight) * innovation * innovation
    apart, apart_first = 1.0 / loud - 1.0 / quiet, modes.loud / loud - modes.quiet / quiet  # K_2 - K_1, along p and e
    along = one + two - between * apart * apart
    across = one * modes.quiet + two * modes.loud - between * apart * apart_first
    first = one * modes.quiet * modes.quiet + two * modes.loud * modes.loud - between * apart_first * apart_first
    for i in range(mean.size):
        row = row_of(i)
        mean[i] += (one + two) * innovation * work[i]
        for j in range(i + 1):
            covariance[row + j] -= along * work[i] * work[j]
        covariance[row] -= across * work[i]
    mean[0] += (one * modes.quiet + two * modes.loud) * innovation
    covariance[0] += (1.0 - weight) * modes.quiet + weight * modes.loud - first - across * work[0]
    return normalised, weight


def constrain_in_place(estimate: Estimate, prior: Prior, multipliers: MutableArray) -> None:
    """Project the estimate onto its bounds, in the metric of ``P^-1`` (Hildreth's dual coordinate ascent).

    ``min (theta - m)' P^-1 (theta - m)`` for ``lowest <= theta``: ``theta = m + P lambda``, ``lambda >= 0``. Then all
    are cut off at both bounds.
    """
    mean, covariance = estimate.mean, estimate.covariance
    count = mean.size - LOOP
    violated = False
    for i in range(count - 2):
        multipliers[i] = 0.0
        violated = violated or mean[LOOP + i] < prior.lowest[i]
    for _ in range(SWEEPS):
        if violated:
            moved = False
            for i in range(count - 2):
                row = row_of(LOOP + i)
                spread = covariance[row + LOOP + i]
                if prior.lowest[i] > -math.inf and spread > 0.0:
                    old = multipliers[i]
                    new = max(0.0, old + (prior.lowest[i] - mean[LOOP + i]) / spread)
                    if new != old:
                        multipliers[i], moved = new, True
                        for j in range(mean.size):
                            place = row + j if j <= LOOP + i else row_of(j) + LOOP + i
                            mean[j] += covariance[place] * (new - old)
            violated = moved
    for i in range(count):
        mean[LOOP + i] = min(max(mean[LOOP + i], prior.lowest[i]), prior.highest[i])
