"""Feedback-error learning: an inverse model, linear in its parameters, that learns from the feedback torque.

The inverse model feeds forward a weighted sum of features of the reference; whatever the feedback still has to add is
taken for its error, and the weights move along ``features * feedback torque``. Nothing of the joint is measured for
that but what the feedback needs anyway.

What the sources leave open, as chosen here:

- *Features*: acceleration, velocity, a constant, and the Coulomb and adhesion shares of friction (5), (6), once for
  each friction lag of a given set, so that a mixture of them stands for a lag in between. Each is the feedforward of a
  model with one parameter, averaged over the coming period like that of the other controllers.
- *Learning* is normalised: at a learning rate ``r`` the feedback torque is handed over to the inverse model at the rate
  ``r``, whatever the features. It pauses where the reference stands, where the measurement failed, and where the
  drive did not give what was asked, because the feedback torque is no error of the model then. The feedback
  torque of a sample is paired with the features of the period that ends with it, which are what it answers to.
- The inertia stays within the range that all controllers assume; nothing else is bounded.

The theory asks that the transfer function from the error of the inverse model to the feedback torque be strictly
positive real. For a PI loop around an inertia, ``(Kp s + Ki) / (J s^2 + Kp s + Ki)``, that is ``Kp^2 > J Ki``.

Sources: M. Kawato, K. Furukawa, R. Suzuki, "A hierarchical neural-network model for control and learning of voluntary
movement" (Biological Cybernetics, 1987); H. Gomi, M. Kawato, "Neural network control for a closed-loop system using
feedback-error-learning" (Neural Networks, 1993); J. Nakanishi, S. Schaal, "Feedback error learning and nonlinear
adaptive control" (Neural Networks, 2004) for the condition of stability.
"""

import math
from collections.abc import Sequence
from itertools import pairwise
from typing import NamedTuple

import numpy as np
from numba.extending import register_jitable
from numpy.typing import NDArray

from adaptive_ff.baselines.refusal import was_refused
from adaptive_ff.friction.bounds import INERTIA_RANGE
from adaptive_ff.friction.feedforward import FeedforwardState, step_feedforward
from adaptive_ff.friction.identifying import IdentifyingController
from adaptive_ff.friction.model import ESTIMATED, TorqueModel
from controllers import (
    ESTIMATES,
    STEPS,
    Inputs,
    Output,
    PIParameters,
    PIState,
    check_gains,
    check_positive,
    feed_back,
    initial_pi_state,
    plausible_inputs,
    present_inertia,
    with_feedforward,
)
from controllers.arrays import MutableArray

INERTIA, VISCOUS, OFFSET, FRICTION = range(4)
"""Places of the weights; from ``FRICTION`` on, Coulomb friction and stiction of each friction lag in turn."""

RATE = 0.3
"""Learning rate, as a share of the crossover ``Kp/J`` of the feedback; see ``FeedbackErrorLearning``."""

LAGS = (1.0, 3.0)
"""Friction lags of the features, in time constants ``J/Kp`` of the feedback; see ``FeedbackErrorLearning``."""

VISCOUS_SHARE = 0.2
"""Unit of the viscous coefficient, as a share of the proportional gain."""

STANDSTILL_SHARE = 0.02
"""Reference speed below which nothing is learnt, as a share of the Stribeck velocity."""


class FeedbackErrorParameters(NamedTuple):
    """Parameters of the controller.

    Attributes
    ----------
    feedback : PIParameters
        The PI loop.
    features : tuple of TorqueModel
        Models with one parameter each, of one unit: their feedforward torques are the features. The one of the
        constant is without any.
    lags : ndarray, shape (l,)
        Friction lags of the friction features, s.
    scale : ndarray, shape (3 + 2 l,)
        Unit in which each weight is learnt, of its expected size.
    torque_scale : float
        Unit of torque, N m.
    rate : float
        Learning rate, 1/s.
    slowest : float
        Reference speed below which nothing is learnt, rad/s.
    inertia : float
        Inertia that the feedback was designed for, kg m^2.
    period : float
        Nominal period, s.
    """

    feedback: PIParameters
    features: tuple[TorqueModel, ...]
    lags: NDArray[np.float64]
    scale: NDArray[np.float64]
    torque_scale: float
    rate: float
    slowest: float
    inertia: float
    period: float


class FeedbackErrorState(NamedTuple):
    """State of the controller; its arrays are changed in place.

    Attributes
    ----------
    feedback : PIState
        State of the PI loop.
    weights : ndarray, shape (3 + 2 l,)
        Weights of the features: inertia, viscous coefficient, offset, Coulomb friction and stiction of each lag.
    friction : ndarray, shape (3 + 2 l,)
        Lagged friction of each feature.
    active : ndarray, shape (3 + 2 l,)
        Features of the last period.
    reference : float
        Last reference, rad/s.
    enabled : bool
        Whether the weights adapt.
    row : ndarray, shape (3 + 2 l,)
        Scratch: features of the coming period.
    """

    feedback: PIState
    weights: MutableArray
    friction: MutableArray
    active: MutableArray
    reference: float
    enabled: bool
    row: MutableArray


def initial_feedback_error_state(block: FeedbackErrorParameters) -> FeedbackErrorState:
    """Return the state of a controller that knows nothing but the assumed inertia."""
    weights = np.zeros(block.scale.size)
    weights[INERTIA] = block.inertia
    return FeedbackErrorState(
        initial_pi_state(block.feedback),
        weights,
        np.zeros(block.scale.size),
        np.zeros(block.scale.size),
        0.0,
        True,
        np.zeros(block.scale.size),
    )


@register_jitable
def write_features(block: FeedbackErrorParameters, state: FeedbackErrorState, inputs: Inputs) -> None:
    """Write the features of the coming period into the scratch row and advance their lagged friction."""
    for i in range(block.scale.size):
        before = FeedforwardState(state.friction[i], state.reference, state.feedback.samples > 0, 0.0, 0.0, 0.0)
        torque, after = step_feedforward(block.features[i], before, inputs, block.period, block.feedback.delay)
        state.row[i] = torque
        state.friction[i] = after.friction
    state.row[OFFSET] = 1.0


@register_jitable
def learn_from_feedback_in_place(
    block: FeedbackErrorParameters, state: FeedbackErrorState, feedback_torque: float, duration: float
) -> None:
    """Move the weights along the features of the last period, times the feedback torque (N m) that they left over."""
    size = 0.0
    for i in range(block.scale.size):
        part = block.scale[i] * state.active[i]
        size += part * part  # not zero, because of the constant
    share = -math.expm1(-block.rate * duration)
    for i in range(block.scale.size):
        state.weights[i] += share * block.scale[i] * block.scale[i] * state.active[i] * feedback_torque / size
    lightest, heaviest = block.inertia / INERTIA_RANGE, block.inertia * INERTIA_RANGE
    state.weights[INERTIA] = min(max(state.weights[INERTIA], lightest), heaviest)


@register_jitable
def step_feedback_error(
    block: FeedbackErrorParameters, state: FeedbackErrorState, inputs: Inputs
) -> tuple[Output, FeedbackErrorState]:
    """Do one sample: feed forward the inverse model, then feedback, then learn from it."""
    inputs, guard = plausible_inputs(block.feedback, state.feedback, inputs)
    refused = was_refused(block.feedback, state.feedback, inputs.realised_torque, block.torque_scale)
    moving = abs(inputs.reference) >= block.slowest and abs(state.reference) >= block.slowest
    write_features(block, state, inputs)
    torque = 0.0
    for i in range(block.scale.size):
        weight = present_inertia(inputs, state.weights[i]) if i == INERTIA else state.weights[i]
        torque += weight * state.row[i]
    output, feedback = feed_back(block.feedback, state.feedback, with_feedforward(inputs, torque), guard)
    if state.enabled and state.feedback.samples > 0 and moving and not refused and math.isfinite(inputs.velocity):
        learn_from_feedback_in_place(block, state, output.torque - output.feedforward, inputs.dt)
    for i in range(block.scale.size):
        state.active[i] = state.row[i]
    return output, state._replace(feedback=feedback, reference=inputs.reference)


@register_jitable
def write_feedback_error(block: FeedbackErrorParameters, state: FeedbackErrorState, row: NDArray[np.float64]) -> None:
    """Write the physical parameters into a row: friction summed over the lags, the lag as their weighted mean."""
    coulomb, stiction, weighted = 0.0, 0.0, 0.0
    for i in range(block.lags.size):
        place = FRICTION + 2 * i
        coulomb += state.weights[place]
        stiction += state.weights[place + 1]
        weighted += block.lags[i] * (state.weights[place] + state.weights[place + 1])
    total = coulomb + stiction
    row[0] = state.weights[INERTIA]
    row[1] = coulomb
    row[2] = stiction
    row[3] = state.weights[VISCOUS]
    row[4] = min(max(weighted / total, 0.0), block.lags[-1]) if total > 0.0 else 0.0
    row[5] = state.weights[OFFSET]


STEPS[FeedbackErrorParameters] = step_feedback_error
ESTIMATES[FeedbackErrorParameters] = write_feedback_error


class FeedbackErrorLearning(IdentifyingController):
    """``u = PI(e) + weights . features(r)``, ``d weights/dt`` along ``features * PI(e)``.

    ``e = reference + correction - velocity``; ``r`` is the plan alone.

    Learning rate and friction lags did best in ``python -m benchmarks.tuning`` of those with two lags or more: one lag
    of two time constants is better still there, but worse on joints drawn at random (``adaptive-ff sweep``, seed 101),
    whose lags differ more. On 2 of 14 of these joints it is worse than ``pi``, as with half the rate.

    Parameters
    ----------
    proportional, integral : float
        Gains of the PI loop, N m s/rad and N m/rad.
    period : float
        Nominal sampling period, s.
    inertia : float
        Inertia that the feedback was designed for, kg m^2; the first estimate.
    stribeck_velocity, stribeck_shape : float
        Pre-estimated ``Vs`` (rad/s) and ``delta``.
    rate : float, optional
        Learning rate, 1/s.
    lags : sequence of float, optional
        Friction lags of the features, s, ascending; ``[0.0]`` for an inverse model without lag.
    delay : float, optional
        Computation delay of the drive, sampling periods: it applies the torque of a sample from that much later on.

    Raises
    ------
    ValueError
        A value is out of range.
    """

    estimate_names = (*ESTIMATED, "offset")

    def __init__(
        self,
        proportional: float,
        integral: float,
        period: float,
        *,
        inertia: float,
        stribeck_velocity: float,
        stribeck_shape: float = 1.0,
        rate: float | None = None,
        lags: Sequence[float] | None = None,
        delay: float = 0.0,
    ) -> None:
        feedback = check_gains(proportional, integral, period, delay)
        check_positive(
            proportional=proportional,
            inertia=inertia,
            stribeck_velocity=stribeck_velocity,
            stribeck_shape=stribeck_shape,
        )
        response = inertia / proportional
        chosen_rate = RATE / response if rate is None else rate
        chosen_lags = [share * response for share in LAGS] if lags is None else [float(lag) for lag in lags]
        check_positive(rate=chosen_rate)
        if not chosen_lags or not all(0.0 <= lag < math.inf for lag in chosen_lags):
            raise ValueError(f"lags = {lags} is not allowed: there must be one at least, none negative, all finite")
        if any(later <= earlier for earlier, later in pairwise(chosen_lags)):
            raise ValueError(f"lags = {lags} is not allowed: they must ascend strictly")
        torque_scale = proportional * stribeck_velocity
        scale = [inertia, VISCOUS_SHARE * proportional, torque_scale, *2 * len(chosen_lags) * [torque_scale]]
        parameters = FeedbackErrorParameters(
            feedback=feedback,
            features=make_features(chosen_lags, stribeck_velocity, stribeck_shape),
            lags=np.array(chosen_lags),
            scale=np.array(scale, dtype=float),
            torque_scale=float(torque_scale),
            rate=float(chosen_rate),
            slowest=STANDSTILL_SHARE * float(stribeck_velocity),
            inertia=float(inertia),
            period=float(period),
        )
        super().__init__(parameters, period, initial_feedback_error_state)


def make_features(lags: Sequence[float], stribeck_velocity: float, stribeck_shape: float) -> tuple[TorqueModel, ...]:
    """Return the models whose feedforward torques are the features."""
    without = TorqueModel(
        inertia=0.0,
        coulomb=0.0,
        stiction=0.0,
        viscous=0.0,
        friction_lag=0.0,
        stribeck_velocity=float(stribeck_velocity),
        stribeck_shape=float(stribeck_shape),
    )
    lagged = [without._replace(friction_lag=lag) for lag in lags]
    friction = [model._replace(**{name: 1.0}) for model in lagged for name in ("coulomb", "stiction")]
    return (without._replace(inertia=1.0), without._replace(viscous=1.0), without, *friction)
