"""Standard deviations of the parameters that the adaptive controller identifies, from its information matrix.

The information matrix ``M`` of the estimator is a fading mean: what is left of its start, the floor that it is drawn
to, and the gradients ``z`` of the sliding samples of the last memory, ``D``. Only the last is data. Equations
with independent errors of mean square ``s^2`` (also a fading mean) leave estimates with the covariance

    C = s^2 T / (2 memory) D^-1

where ``T`` is the sampling period; the 2, since equations are weighted with ``exp(-age/memory)``, their variances with
the square of it. What the data do not identify is as uncertain as the unit that the parameter is estimated in: the
covariance is ``(C^-1 + I)^-1`` in these units. In a time ``t`` of learning both means have come to ``1 -
exp(-t/memory)`` of what they will be.

What these numbers are not: a confidence interval. Errors of filtered equations are correlated over some ``4/pole``. The
noise of the velocity reaches them through derivatives, so it is loud far above the frequencies of the motion and
cancels there; counted as independent, it is overrated. A reversal, which alone excites the friction lag, is located
within a sampling period only; ``T / sqrt(12)`` is added to the lag's for that. And a model that is wrong (Stribeck
curve, dependence on position) shifts the estimates by more than equations can show. ``python -m benchmarks.confidence``
shows what is left.
"""

import math
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from adaptive_ff.adaptive.learning.estimator_state import EstimatorParameters, EstimatorState, initial_estimator_state
from adaptive_ff.friction.bounds import FRICTION_LAG

Array = NDArray[np.float64]

SMALLEST_LEVEL = 1e-18
"""Smallest mean squared error of the scaled equations; rounding is larger."""


class Confidence(NamedTuple):
    """Uncertainty of the parameters, given the recent data.

    Attributes
    ----------
    errors : ndarray, shape (n,)
        How far each parameter may be off, as a standard deviation, in its unit.
    together : ndarray, shape (n,)
        The same as a share of the scale that it is estimated in: 1 where it is not identifiable from the data.
    alone : ndarray, shape (n,)
        What that share would be if the other parameters were known.
    shares : ndarray, shape (n,)
        Share of data in the information: after a change of the joint, a parameter follows with the time constant
        ``memory / share``.
    """

    errors: Array
    together: Array
    alone: Array
    shares: Array


def mean_squared_error(estimator: EstimatorParameters, state: EstimatorState) -> float:
    """Return the mean squared prediction error in units of the torque scale squared; 0 before anything was learnt.

    The fading mean began at zero: what is missing of its memory is made up for.
    """
    filled = -math.expm1(-state.levels.learnt / estimator.memory)
    return float(state.levels.squared_error) / filled if filled > 0.0 else 0.0


def assess(estimator: EstimatorParameters, state: EstimatorState, period: float) -> Confidence:
    """Return how uncertain the parameters are, given the recent data.

    Parameters
    ----------
    estimator : EstimatorParameters
        The estimator.
    state : EstimatorState
        Its state; it is left as it is.
    period : float
        Sampling period, s.
    """
    size, memory = state.recursion.estimate.size, estimator.memory
    missing = math.exp(-state.levels.learnt / memory)
    known = estimator.deviation if estimator.given else estimator.scale  # what is merely assumed is not known
    if missing == 1.0:
        share = known / estimator.scale
        return Confidence(known.copy(), share, share.copy(), np.zeros(size))
    # the prior fades with the memory, to that of a unit
    prior = 1.0 + missing * ((estimator.scale / known) ** 2 - 1.0)
    start = missing * initial_estimator_state(estimator).recursion.information
    above = state.recursion.information - start
    floor = min(float(np.min(np.diag(above) - state.agreement[:, 0])), float(np.linalg.eigvalsh(above)[0]))
    own = start + max(floor, 0.0) * np.eye(size)
    data = state.recursion.information - own
    level = max(mean_squared_error(estimator, state) * period * (1.0 + missing) / (2.0 * memory), SMALLEST_LEVEL)
    values, vectors = np.linalg.eigh(data + level * np.diag(prior))
    values = np.maximum(values, level * float(np.min(prior)))  # the prior alone gives that; data lose it by rounding
    together = np.sqrt(level * (vectors**2 @ (1.0 / values)))
    alone = np.sqrt(level / (np.maximum(np.diag(data), 0.0) + level * prior))
    errors = together * estimator.scale
    errors[FRICTION_LAG] = math.hypot(errors[FRICTION_LAG], period / math.sqrt(12.0))
    shares = np.clip(1.0 - np.diag(np.linalg.solve(state.recursion.information, own)), 0.0, 1.0)
    return Confidence(errors, together, alone, shares)
