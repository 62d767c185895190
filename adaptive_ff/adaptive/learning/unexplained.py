"""What the identified model leaves of the torque, and how much that is beside the friction."""

from numba.extending import register_jitable

from adaptive_ff.adaptive.learning.estimator_state import EstimatorParameters, EstimatorState
from adaptive_ff.estimation.shares import TINY, saturated
from adaptive_ff.friction.bounds import COULOMB, STICTION

LEFT = 0.01
"""Torque that a model leaves at least before it counts as one that misses something, over the friction (rms)."""


@register_jitable
def unexplained(estimator: EstimatorParameters, state: EstimatorState) -> float:
    """Return the mean squared torque that the model leaves (N^2 m^2), on rows of the reference where there are any.

    Those of the candidate in use are free of the noise of the measured velocity, and of the steps of an encoder.
    """
    if estimator.candidates.size > 0:
        return state.candidates.errors[state.candidates.chosen]  # type: ignore[no-any-return]
    return state.levels.squared_error * estimator.torque_scale * estimator.torque_scale


@register_jitable
def breakaway(estimator: EstimatorState) -> float:
    """Return the friction at which the joint breaks away, N m, as it is identified."""
    return max(estimator.recursion.estimate[COULOMB], estimator.recursion.estimate[STICTION])  # type: ignore[no-any-return]


@register_jitable
def missing_share(state: EstimatorState, squared: float) -> float:
    """Return the share to which what the model leaves, squared (N^2 m^2), counts beside the friction."""
    least = LEFT * breakaway(state)
    return saturated(squared / (least * least + TINY) - 1.0)
