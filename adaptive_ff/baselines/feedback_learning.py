"""Weights of a feedforward that descend along the gradient of the feedback torque: the rule of two baselines.

M. Kawato's feedback-error learning, normalised: at a rate ``r`` (1/s) the feedback torque is handed over to the
feedforward at the rate ``r``, whatever the features,

    dw_i/dt = rate scale_i^2 phi_i u_fb / sum (scale_j phi_j)^2

Nothing is learnt where the reference stands, where the measurement failed, and where the drive did not give what was
commanded, because the feedback torque is no error of the feedforward then.
"""

import math
from typing import Any

import numpy as np
from numpy.typing import NDArray

from controllers.arrays import MutableArray
from controllers.pi import PIParameters, PIState, asked_torque
from controllers.registry import Inputs

INERTIA, VISCOUS, OFFSET, FIRST = range(4)
"""Places of the features; those of friction begin at the last."""

REFUSED_FRACTION = 0.05
"""Torque that the drive did not give beyond which nothing is learnt, over the unit of torque."""

STANDSTILL_FRACTION = 0.02
"""Reference speed below which nothing is learnt, over the Stribeck velocity."""


def first_weights(parameters: Any) -> MutableArray:
    """Return the weights of a feedforward that knows nothing but the assumed inertia."""
    weights = no_features(parameters)
    weights[INERTIA] = parameters.inertia
    return weights


def no_features(parameters: Any) -> MutableArray:
    """Return a zero for each feature."""
    return np.zeros(parameters.scale.size)


def was_refused(feedback: PIParameters, state: PIState, realised: float, unit: float) -> bool:
    """Return whether the realised torque (N m) missed the commanded one; ``unit`` is that of torque, N m."""
    return abs(realised - asked_torque(feedback, state)) > REFUSED_FRACTION * unit


def moves(inputs: Inputs, last_reference: float, stribeck_velocity: float) -> bool:
    """Return whether the reference moves, now and at the last sample (rad/s)."""
    slowest = STANDSTILL_FRACTION * stribeck_velocity
    return abs(inputs.reference) >= slowest and abs(last_reference) >= slowest


def learn_in_place(
    weights: MutableArray,
    features: NDArray[np.float64],
    scale: NDArray[np.float64],
    torque: float,
    fraction: float,
    least: float,
    most: float,
) -> None:
    """Move the weights along the features of the last period, times the feedback torque (N m) that they left over.

    The fraction of it that is handed over is ``1 - exp(-rate dt)``; the inertia stays within bounds (kg m^2).
    """
    size = 0.0
    for i in range(scale.size):
        scaled = scale[i] * features[i]
        size += scaled * scaled  # not zero, because of the constant
    for i in range(scale.size):
        weights[i] += fraction * scale[i] * scale[i] * features[i] * torque / size
    weights[INERTIA] = min(max(weights[INERTIA], least), most)


def handed_over(rate: float, duration: float) -> float:
    """Return the fraction of the feedback torque that a rate (1/s) hands over in a time (s)."""
    return -math.expm1(-rate * duration)
