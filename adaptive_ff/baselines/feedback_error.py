"""Feedback-error learning: an inverse model, linear in its parameters, that learns from the feedback torque.

The inverse model feeds forward a weighted sum of features of the reference; whatever the feedback still has to add is
taken for its error (:mod:`adaptive_ff.baselines.feedback_learning`).

What the sources leave open, as chosen here:

- *Features*: acceleration, velocity, a constant, and the Coulomb and adhesion parts of friction (5), (6), once for
  each friction lag of a given set, so that a mixture of them stands for a lag in between. Each is the feedforward of a
  model with one parameter, averaged over the coming period like that of the other controllers.
- The feedback torque of a sample is paired with the features of the period that ends with it, which it answers to.
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
from typing import Any, NamedTuple

import numpy as np

from adaptive_ff.baselines.feedback_learning import (
    FIRST,
    INERTIA,
    OFFSET,
    VISCOUS,
    first_weights,
    handed_over,
    learn_in_place,
    moves,
    no_features,
    was_refused,
)
from adaptive_ff.friction.bounds import INERTIA_RANGE, VISCOUS_SHARE
from adaptive_ff.friction.feedforward import FeedforwardState, step_feedforward
from adaptive_ff.friction.identifying import IdentifyingController
from adaptive_ff.friction.model import ESTIMATED, TorqueModel
from controllers.arrays import MutableArray, NDArray
from controllers.checks import check_positive
from controllers.declaration import argument, as_given, begin, controller, derived, positive
from controllers.loops import DesignedLoop
from controllers.pi import PIState, feed_back, plausible_inputs
from controllers.registry import Inputs, Output, present_inertia, with_feedforward

RATE = 0.3
"""Learning rate, over the crossover ``Kp/J`` of the feedback; see ``FeedbackErrorLearning``."""

LAGS = (1.0, 3.0)
"""Friction lags of the features, in time constants ``J/Kp`` of the feedback; see ``FeedbackErrorLearning``."""


class FeedbackErrorState(NamedTuple):
    """State of the controller; its arrays, one number for each feature, are changed in place."""

    feedback: PIState
    weights: MutableArray = begin(first_weights)  # inertia, viscous coefficient, offset, Fc and Fs of each lag
    friction: MutableArray = begin(no_features)  # lagged friction of each feature
    active: MutableArray = begin(no_features)  # features of the last period
    reference: float = 0.0  # last reference, rad/s
    enabled: bool = True  # whether the weights adapt
    row: MutableArray = begin(no_features)  # features of the coming period


def write_features(parameters: "FeedbackErrorLearning", state: FeedbackErrorState, inputs: Inputs) -> None:
    """Write the features of the coming period into the scratch row and advance their lagged friction."""
    delay = parameters.feedback.delay
    for i in range(parameters.scale.size):
        before = FeedforwardState(state.friction[i], state.reference, state.feedback.samples > 0, 0.0, 0.0, 0.0)
        torque, after = step_feedforward(parameters.features[i], before, inputs, parameters.period, delay)
        state.row[i] = torque
        state.friction[i] = after.friction
    state.row[OFFSET] = 1.0


def step_feedback_error(
    parameters: "FeedbackErrorLearning", state: FeedbackErrorState, inputs: Inputs
) -> tuple[Output, FeedbackErrorState]:
    """Do one sample: feed forward the inverse model, then feedback, then learn from it."""
    inputs, guard = plausible_inputs(parameters.feedback, state.feedback, inputs)
    refused = was_refused(parameters.feedback, state.feedback, inputs.realised_torque, parameters.torque_scale)
    moving = moves(inputs, state.reference, parameters.stribeck_velocity)
    write_features(parameters, state, inputs)
    torque = 0.0
    for i in range(parameters.scale.size):
        weight = present_inertia(inputs, state.weights[i]) if i == INERTIA else state.weights[i]
        torque += weight * state.row[i]
    output, feedback = feed_back(parameters.feedback, state.feedback, with_feedforward(inputs, torque), guard)
    if state.enabled and state.feedback.samples > 0 and moving and not refused and math.isfinite(inputs.velocity):
        least, most = parameters.inertia / INERTIA_RANGE, parameters.inertia * INERTIA_RANGE
        left, fraction = output.torque - output.feedforward, handed_over(parameters.learning_rate, inputs.dt)
        learn_in_place(state.weights, state.active, parameters.scale, left, fraction, least, most)
    for i in range(parameters.scale.size):
        state.active[i] = state.row[i]
    return output, state._replace(feedback=feedback, reference=inputs.reference)


def write_feedback_error(parameters: "FeedbackErrorLearning", state: FeedbackErrorState, row: MutableArray) -> None:
    """Write the physical parameters into a row: friction summed over the lags, the lag as their weighted mean."""
    coulomb, stiction, weighted = 0.0, 0.0, 0.0
    for i in range(parameters.lag_grid.size):
        place = FIRST + 2 * i
        coulomb += state.weights[place]
        stiction += state.weights[place + 1]
        weighted += parameters.lag_grid[i] * (state.weights[place] + state.weights[place + 1])
    total = coulomb + stiction
    row[0] = state.weights[INERTIA]
    row[1] = coulomb
    row[2] = stiction
    row[3] = state.weights[VISCOUS]
    row[4] = min(max(weighted / total, 0.0), parameters.lag_grid[-1]) if total > 0.0 else 0.0
    row[5] = state.weights[OFFSET]


@controller(step_feedback_error, FeedbackErrorState, estimates=write_feedback_error)
class FeedbackErrorLearning(DesignedLoop, IdentifyingController):
    """``u = PI(e) + weights . features(r)``, ``d weights/dt`` along ``features * PI(e)``."""

    estimate_names = (*ESTIMATED, "offset")

    stribeck_velocity: float = argument(positive, "Pre-estimated ``Vs``, rad/s.")
    stribeck_shape: float = argument(positive, "Pre-estimated ``delta``.", default=1.0)
    rate: float | None = argument(
        as_given, "Learning rate, 1/s; by default 0.3 times ``Kp/J``.", default=None, kept=False
    )
    lags: Sequence[float] | None = argument(
        as_given,
        "Friction lags of the features, s, ascending; ``[0.0]`` for an inverse model without lag. By default one and "
        "three time constants ``J/Kp``.",
        default=None,
        kept=False,
    )
    learning_rate: float = derived("Learning rate, 1/s.")
    lag_grid: NDArray[np.float64] = derived("Friction lags of the friction features, s.")
    features: tuple[TorqueModel, ...] = derived("Models with one parameter each, of one unit, whose torques are fed.")
    scale: NDArray[np.float64] = derived("Unit in which each weight is learnt, of its expected size.")
    torque_scale: float = derived("Unit of torque, N m.")

    def derive(self) -> dict[str, Any]:
        """Return features, their units, and the rate and the lags that are chosen where none are given."""
        response = self.inertia / self.proportional
        rate = RATE / response if self.rate is None else self.rate
        lags = [lag * response for lag in LAGS] if self.lags is None else [float(lag) for lag in self.lags]
        check_positive(rate=rate)
        if not lags or not all(0.0 <= lag < math.inf for lag in lags):
            raise ValueError(
                f"lags = {self.lags} is not allowed: there must be one at least, none negative, all finite"
            )
        if any(later <= earlier for earlier, later in pairwise(lags)):
            raise ValueError(f"lags = {self.lags} is not allowed: they must ascend strictly")
        torque = self.proportional * self.stribeck_velocity
        scale = [self.inertia, VISCOUS_SHARE * self.proportional, torque, *2 * len(lags) * [torque]]
        return {
            "learning_rate": float(rate),
            "lag_grid": np.array(lags),
            "features": make_features(lags, self.stribeck_velocity, self.stribeck_shape),
            "scale": np.array(scale),
            "torque_scale": torque,
        }


def make_features(lags: Sequence[float], stribeck_velocity: float, stribeck_shape: float) -> tuple[TorqueModel, ...]:
    """Return the models whose feedforward torques are the features; the one of the constant is without any."""
    without = TorqueModel(0.0, 0.0, 0.0, 0.0, 0.0, stribeck_velocity, stribeck_shape)
    lagged = [without._replace(friction_lag=lag) for lag in lags]
    friction = [model._replace(**{name: 1.0}) for model in lagged for name in ("coulomb", "stiction")]
    return (without._replace(inertia=1.0), without._replace(viscous=1.0), without, *friction)
