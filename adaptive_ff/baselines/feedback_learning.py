"""Feedforwards that are linear in their weights, which the feedback torque corrects online.

The inverse model feeds forward a weighted sum of features of the reference; whatever the feedback still has to add is
taken for its error. The weights descend along the gradient of the feedback torque (M. Kawato's feedback-error
learning), normalised: at a rate ``r`` (1/s) the feedback torque is handed over to the feedforward at the rate ``r``,
whatever the features,

    dw_i/dt = rate scale_i^2 phi_i u_fb / sum (scale_j phi_j)^2

Nothing is learnt where the reference stands, where the measurement failed, and where the drive did not give what was
commanded, because the feedback torque is no error of the feedforward then. It is paired with the features of the period
that ends with its sample, which it answers to. Three baselines, by their features along the reference; each has
inertia, viscous friction and a constant beside them. Inertia stays within a range, nothing else is bounded.

- Feedback-error learning: Coulomb and adhesion parts of friction (5), (6), once for each friction lag of a given set,
  so that a mixture of them stands for a lag in between. Each is the feedforward of a model with one parameter, averaged
  over the coming period like that of the other controllers. The theory asks that the transfer function from the error
  of the inverse model to the feedback torque be strictly positive real. For a PI loop around an inertia, ``(Kp s + Ki)
  / (J s^2 + Kp s + Ki)``, that is ``Kp^2 > J Ki``.
- Maxwell slip: stop operators of the planned position with fixed reaches, the elements of a Maxwell-slip model whose
  strengths are learnt. After the idea of A. Amthor, S. Zschaek, C. Ament, "High precision position control using an
  adaptive friction compensation approach" (2010), and of the Maxwell-slip regressors of D. Rizos, S. Fassois (2009);
  neither text could be compared, and no number of theirs is claimed.
- Radial basis: bells over the planned velocity, the common small network for friction that has no formula. Each bell is
  lagged, since friction follows the velocity late.

Sources: M. Kawato, K. Furukawa, R. Suzuki, "A hierarchical neural-network model for control and learning of voluntary
movement" (Biological Cybernetics, 1987); H. Gomi, M. Kawato, "Neural network control for a closed-loop system using
feedback-error-learning" (Neural Networks, 1993); J. Nakanishi, S. Schaal, "Feedback error learning and nonlinear
adaptive control" (Neural Networks, 2004) for the condition of stability.
"""

import math
from collections.abc import Callable, Sequence
from itertools import pairwise
from typing import Any, NamedTuple

import numpy as np

from adaptive_ff.baselines.bounds import INERTIA_RANGE, VISCOUS_UNIT
from adaptive_ff.friction.feedforward import FeedforwardState, coming_plan, step_feedforward
from adaptive_ff.friction.identifying import IdentifyingController
from adaptive_ff.friction.model import ESTIMATED, TorqueModel
from controllers.arrays import MutableArray, NDArray
from controllers.checks import check_positive, checked_array
from controllers.declaration import argument, as_given, begin, controller, derived, not_negative, positive
from controllers.loops import DesignedLoop
from controllers.pi import PIParameters, PIState, asked_torque, feed_back, plausible_inputs
from controllers.registry import Inputs, Output, present_inertia, with_feedforward

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
        before = FeedforwardState(state.friction[i], state.reference, state.feedback.samples > 0, 0.0, 0.0)
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
        left, fraction = output.torque - output.feedforward, -math.expm1(-parameters.learning_rate * inputs.dt)
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
        given = [lag * response for lag in LAGS] if self.lags is None else self.lags
        lags = _ascending("lags", given, lambda lag: 0.0 <= lag < math.inf, "finite, not negative")
        check_positive(rate=rate)
        if not lags:
            raise ValueError("lags = [] is not allowed: there must be one at least")
        torque = self.proportional * self.stribeck_velocity
        scale = [self.inertia, VISCOUS_UNIT * self.proportional, torque, *2 * len(lags) * [torque]]
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


LASTING = 3.0
"""Refusal that lasts longer is no mere lag of the drive, in time constants of the integral's anti-windup ..."""

UNWOUND = 3.0
"""... and for so long after it nothing is learnt either."""

VISCOUS_FRACTION = 0.1
"""Unit of the viscous coefficient, over the proportional gain."""


class LearntState(NamedTuple):
    """State of the controller; its arrays, one number for each feature, are changed in place."""

    feedback: PIState
    weights: MutableArray = begin(first_weights)
    features: MutableArray = begin(no_features)  # of the last period; those of friction are operators that remember
    reference: float = 0.0  # last reference, rad/s
    enabled: bool = True  # whether the weights adapt
    refused: float = 0.0  # for how long the drive has given less than was commanded, less the time since then, s


def advance_features_in_place(parameters: "LearntFeedforward", state: LearntState, inputs: Inputs) -> None:
    """Advance the features to the period in which the coming torque acts."""
    past = FeedforwardState(0.0, state.reference, state.feedback.samples > 0, 0.0, 0.0)
    start, end = coming_plan(past, inputs, parameters.feedback.delay)
    velocity = 0.5 * (start + end)
    state.features[INERTIA] = (end - start) / parameters.period
    state.features[VISCOUS] = velocity
    state.features[OFFSET] = 1.0
    count = parameters.stops.size
    for i in range(count):
        stretched = state.features[FIRST + i] + velocity * parameters.period / parameters.stops[i]
        state.features[FIRST + i] = min(max(stretched, -1.0), 1.0)
    place = math.asinh(velocity / parameters.stribeck_velocity)
    keep = math.exp(-parameters.period / parameters.lag) if parameters.lag > 0.0 else 0.0
    for i in range(parameters.places.size):
        distance = (place - parameters.places[i]) / parameters.width
        bell = math.exp(-0.5 * distance * distance)
        before = state.features[FIRST + count + i]
        state.features[FIRST + count + i] = bell + keep * (before - bell)


def unwinding_time(feedback: PIParameters) -> float:
    """Return the time constant with which back-calculation takes refused torque out of the integral, s."""
    return feedback.proportional / feedback.integral if feedback.integral > 0.0 else 0.0


def advance_refused(parameters: "LearntFeedforward", state: LearntState, refused: bool, duration: float) -> float:
    """Return the time for which torque was refused, less the time since then, s.

    A joint that a weak drive holds back at every reversal would teach the weights a friction that passes from limit
    to limit as the feedback does: after refusal that lasted, nothing is learnt until it is unwound.
    """
    if refused:
        return min(state.refused + duration, (LASTING + UNWOUND) * unwinding_time(parameters.feedback))
    return max(state.refused - duration, 0.0)


def step_learnt(parameters: "LearntFeedforward", state: LearntState, inputs: Inputs) -> tuple[Output, LearntState]:
    """Do one sample: learn from what the last features left over, feed the coming ones forward, then feedback."""
    inputs, guard = plausible_inputs(parameters.feedback, state.feedback, inputs)
    last, inertia = state.feedback, parameters.inertia
    refused = was_refused(parameters.feedback, last, inputs.realised_torque, parameters.torque_scale)
    time_refused = advance_refused(parameters, state, refused, inputs.dt)
    unwound = not refused and time_refused <= LASTING * unwinding_time(parameters.feedback)
    moving = moves(inputs, state.reference, parameters.stribeck_velocity)
    if state.enabled and last.samples > 0 and moving and unwound and math.isfinite(inputs.velocity):
        error = inputs.reference + inputs.correction - inputs.velocity
        left = parameters.feedback.proportional * error + last.integral
        fraction = -math.expm1(-parameters.rate * inputs.dt)
        learn_in_place(state.weights, state.features, parameters.scale, left, fraction, 0.5 * inertia, 2.0 * inertia)
    advance_features_in_place(parameters, state, inputs)
    torque = present_inertia(inputs, state.weights[INERTIA]) * state.features[INERTIA]
    for i in range(VISCOUS, parameters.scale.size):
        torque += state.weights[i] * state.features[i]
    output, feedback = feed_back(parameters.feedback, last, with_feedforward(inputs, torque), guard)
    return output, state._replace(feedback=feedback, reference=inputs.reference, refused=time_refused)


@controller(step_learnt, LearntState)
class LearntFeedforward(DesignedLoop):
    """``u = PI(e) + J dr/dt + sigma r + offset + sum w_i phi_i``, weights by gradient from the feedback torque.

    Give reaches for an adaptive Maxwell-slip compensation, centres for a radial-basis one, or both.
    """

    stribeck_velocity: float = argument(
        positive, "Pre-estimated ``Vs``, rad/s: the scale of the bells' velocities and of the expected friction."
    )
    reaches: Sequence[float] = argument(
        as_given, "Displacements after which the stop operators slip, rad, ascending.", default=(), kept=False
    )
    centres: Sequence[float] = argument(
        as_given,
        "Centres of the bells as multiples of ``Vs``, ascending, two at least; their width is the mean distance.",
        default=(),
        kept=False,
    )
    lag: float = argument(not_negative, "Lag of the bells, s.", default=0.0)
    rate: float = argument(positive, "Learning rate, 1/s.", default=1.0)
    stops: NDArray[np.float64] = derived("Displacement after which each stop operator slips, rad.")
    places: NDArray[np.float64] = derived("Centre of each bell, as ``asinh(w/Vs)``.")
    width: float = derived("Width of the bells, of the same unit.")
    scale: NDArray[np.float64] = derived("Unit in which each weight is learnt, of its expected size.")
    torque_scale: float = derived("Unit of torque, N m.")

    def derive(self) -> dict[str, Any]:
        """Return the features' parameters and the units of their weights."""
        reaches = _ascending("reaches", self.reaches, lambda reach: 0.0 < reach < math.inf, "finite, positive")
        centres = _ascending("centres", self.centres, math.isfinite, "finite")
        if len(centres) == 1:
            raise ValueError(f"centres = {self.centres} is not allowed: there must be two at least, or none")
        places = np.arcsinh(np.array(centres, dtype=float))
        torque = self.proportional * self.stribeck_velocity
        friction = (len(reaches) + len(centres)) * [torque]
        return {
            "stops": np.array(reaches, dtype=float),
            "places": places,
            "width": float(np.mean(np.diff(places))) if places.size else 1.0,
            "scale": np.array([self.inertia, VISCOUS_FRACTION * self.proportional, torque, *friction]),
            "torque_scale": torque,
        }


def _ascending(name: str, values: Sequence[float], holds: Callable[[float], bool], allowed: str) -> list[float]:
    """Return numbers of which a condition holds and which ascend strictly."""
    array = checked_array(name, values)
    found: list[float] = array.tolist() if array.ndim == 1 else [math.nan]
    if not all(map(holds, found)) or any(later <= earlier for earlier, later in pairwise(found)):
        raise ValueError(f"{name} = {values} is not allowed: they must be {allowed} and ascend strictly")
    return found
