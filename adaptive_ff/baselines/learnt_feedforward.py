"""PI loop with a feedforward that is linear in its weights, which the feedback torque corrects online.

Two baselines, by their features along the reference; each has inertia, viscous friction and a constant beside them.

- Maxwell slip: stop operators of the planned position with fixed reaches, the elements of a Maxwell-slip model whose
  strengths are learnt. After the idea of A. Amthor, S. Zschaek, C. Ament, "High precision position control using an
  adaptive friction compensation approach" (2010), and of the Maxwell-slip regressors of D. Rizos, S. Fassois (2009);
  neither text could be compared, and no number of theirs is claimed.
- Radial basis: bells over the planned velocity, the common small network for friction that has no formula, learnt
  by the same rule. Each bell is lagged, since friction follows the velocity late.

The rule is that of :mod:`adaptive_ff.baselines.feedback_learning`; the feedback torque of a sample answers the features
of the period before.
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
from adaptive_ff.friction.feedforward import FeedforwardState, coming_plan
from controllers.arrays import MutableArray, NDArray
from controllers.declaration import argument, as_given, begin, controller, derived, not_negative, positive
from controllers.loops import DesignedLoop
from controllers.pi import PIParameters, PIState, feed_back, plausible_inputs
from controllers.registry import Inputs, Output, present_inertia, with_feedforward

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
        left, fraction = (
            parameters.feedback.proportional * error + last.integral,
            handed_over(parameters.rate, inputs.dt),
        )
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
        _check_ascending("reaches", self.reaches, 0.0)
        _check_ascending("centres", self.centres, -math.inf)
        if len(self.centres) == 1:
            raise ValueError(f"centres = {self.centres} is not allowed: there must be two at least, or none")
        places = np.arcsinh(np.array(self.centres, dtype=float))
        torque = self.proportional * self.stribeck_velocity
        friction = (len(self.reaches) + len(self.centres)) * [torque]
        return {
            "stops": np.array(self.reaches, dtype=float),
            "places": places,
            "width": float(np.mean(np.diff(places))) if places.size else 1.0,
            "scale": np.array([self.inertia, VISCOUS_FRACTION * self.proportional, torque, *friction]),
            "torque_scale": torque,
        }


def _check_ascending(name: str, values: Sequence[float], above: float) -> None:
    if not all(above < value < math.inf for value in values) or any(b <= a for a, b in pairwise(values)):
        bound = "finite" if math.isinf(above) else "finite and positive"
        raise ValueError(f"{name} = {list(values)} is not allowed: they must be {bound} and ascend strictly")
