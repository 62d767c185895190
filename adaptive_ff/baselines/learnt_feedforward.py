"""PI loop with a feedforward that is linear in its weights, which the feedback torque corrects online.

Two rivals, by their features along the plan; each has inertia, viscous friction and a constant beside them.

- Maxwell slip: stop operators of the planned position with fixed reaches, the elements of a Maxwell-slip model whose
  strengths are learnt. After the idea of A. Amthor, S. Zschaek, C. Ament, "High precision position control using an
  adaptive friction compensation approach" (2010), and of the Maxwell-slip regressors of D. Rizos, S. Fassois (2009);
  neither text could be compared, and no number of theirs is claimed.
- Radial basis: bells over the planned velocity, the common small network for friction that has no formula, learnt
  by the same rule. Each bell is lagged, since friction follows the velocity late.

Rule: normalised gradient on the feedback torque (M. Kawato's feedback-error learning, as in
:mod:`adaptive_ff.baselines.feedback_error`). The feedback torque of a sample answers the features of the period before.

    dw_i/dt = rate scale_i^2 phi_i u_fb / sum (scale_j phi_j)^2
"""

import math
from collections.abc import Sequence
from itertools import pairwise
from typing import NamedTuple

import numpy as np
from numba.extending import register_jitable
from numpy.typing import NDArray

from adaptive_ff.baselines.refusal import was_refused
from adaptive_ff.friction.feedforward import FeedforwardState, coming_plan
from controllers import (
    ESTIMATES,
    STEPS,
    Controller,
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
    without_estimates,
)
from controllers.arrays import MutableArray

INERTIA, VISCOUS, OFFSET, FIRST = 0, 1, 2, 3
"""Places of the features; friction begins at the last."""

STANDSTILL_SHARE = 0.02
"""Reference speed below which nothing is learnt, as a share of the Stribeck velocity."""

LASTING = 3.0
"""Refusal that lasts longer is no mere lag of the drive, in time constants of the integral's anti-windup ..."""

UNWOUND = 3.0
"""... and for so long after it nothing is learnt either."""

VISCOUS_SHARE = 0.1
"""Unit of the viscous coefficient, as a share of the proportional gain."""


class LearntParameters(NamedTuple):
    """Parameters of the controller.

    Attributes
    ----------
    feedback : PIParameters
        The PI loop.
    inertia : float
        Inertia that the feedback was designed for, kg m^2.
    period : float
        Nominal period, s.
    reaches : ndarray, shape (m,)
        Displacement after which each stop operator slips, rad.
    centres : ndarray, shape (n,)
        Centre of each bell, as ``asinh(w/Vs)``.
    width : float
        Width of the bells, of the same unit.
    velocity_scale : float
        ``Vs``, rad/s.
    lag : float
        Lag of the bells, s.
    scale : ndarray, shape (3 + m + n,)
        Unit in which each weight is learnt, of its expected size.
    torque_scale : float
        Unit of torque, N m.
    rate : float
        Learning rate, 1/s.
    """

    feedback: PIParameters
    inertia: float
    period: float
    reaches: NDArray[np.float64]
    centres: NDArray[np.float64]
    width: float
    velocity_scale: float
    lag: float
    scale: NDArray[np.float64]
    torque_scale: float
    rate: float


class LearntState(NamedTuple):
    """State of the controller; its arrays are changed in place.

    Attributes
    ----------
    feedback : PIState
        State of the PI loop.
    weights : ndarray, shape (3 + m + n,)
        Weights of the features.
    features : ndarray, shape (3 + m + n,)
        Features of the last period; those of friction are operators that remember.
    reference : float
        Last reference, rad/s.
    enabled : bool
        Whether the weights adapt.
    refused : float
        For how long the drive has given less than it was asked for, less the time since then, s.
    """

    feedback: PIState
    weights: MutableArray
    features: MutableArray
    reference: float
    enabled: bool
    refused: float


def initial_learnt_state(block: LearntParameters) -> LearntState:
    """Return the state of a controller that knows nothing but the assumed inertia."""
    weights = np.zeros(block.scale.size)
    weights[INERTIA] = block.inertia
    return LearntState(initial_pi_state(block.feedback), weights, np.zeros(block.scale.size), 0.0, True, 0.0)


@register_jitable
def advance_features_in_place(block: LearntParameters, state: LearntState, inputs: Inputs) -> None:
    """Advance the features to the period in which the coming torque acts."""
    past = FeedforwardState(0.0, state.reference, state.feedback.samples > 0, 0.0, 0.0)
    start, end = coming_plan(past, inputs, block.feedback.delay)
    velocity = 0.5 * (start + end)
    state.features[INERTIA] = (end - start) / block.period
    state.features[VISCOUS] = velocity
    state.features[OFFSET] = 1.0
    count = block.reaches.size
    for i in range(count):
        stretched = state.features[FIRST + i] + velocity * block.period / block.reaches[i]
        state.features[FIRST + i] = min(max(stretched, -1.0), 1.0)
    place = math.asinh(velocity / block.velocity_scale)
    keep = math.exp(-block.period / block.lag) if block.lag > 0.0 else 0.0
    for i in range(block.centres.size):
        distance = (place - block.centres[i]) / block.width
        bell = math.exp(-0.5 * distance * distance)
        before = state.features[FIRST + count + i]
        state.features[FIRST + count + i] = bell + keep * (before - bell)


@register_jitable
def learn_in_place(block: LearntParameters, state: LearntState, feedback_torque: float, duration: float) -> None:
    """Move the weights along the features of the last period, times the feedback torque (N m) that they left over."""
    size = 0.0
    for i in range(block.scale.size):
        scaled = block.scale[i] * state.features[i]
        size += scaled * scaled  # not zero, because of the constant
    share = -math.expm1(-block.rate * duration)
    for i in range(block.scale.size):
        state.weights[i] += share * block.scale[i] * block.scale[i] * state.features[i] * feedback_torque / size
    state.weights[INERTIA] = min(max(state.weights[INERTIA], 0.5 * block.inertia), 2.0 * block.inertia)


@register_jitable
def unwinding_time(feedback: PIParameters) -> float:
    """Return the time constant with which back-calculation takes refused torque out of the integral, s."""
    return feedback.proportional / feedback.integral if feedback.integral > 0.0 else 0.0


@register_jitable
def advance_refused(block: LearntParameters, state: LearntState, refused: bool, duration: float) -> float:
    """Return the time for which torque was refused, less the time since then, s.

    A joint that a weak drive holds back at every reversal would teach the weights a friction that passes from limit
    to limit as the feedback does: after refusal that lasted, nothing is learnt until it is unwound.
    """
    if refused:
        return min(state.refused + duration, (LASTING + UNWOUND) * unwinding_time(block.feedback))
    return max(state.refused - duration, 0.0)


@register_jitable
def step_learnt(block: LearntParameters, state: LearntState, inputs: Inputs) -> tuple[Output, LearntState]:
    """Do one sample: learn from what the last features left over, feed the coming ones forward, then feedback."""
    inputs, guard = plausible_inputs(block.feedback, state.feedback, inputs)
    last = state.feedback
    refused = was_refused(block.feedback, last, inputs.realised_torque, block.torque_scale)
    time_refused = advance_refused(block, state, refused, inputs.dt)
    unwound = not refused and time_refused <= LASTING * unwinding_time(block.feedback)
    slowest = STANDSTILL_SHARE * block.velocity_scale
    moving = abs(inputs.reference) >= slowest and abs(state.reference) >= slowest
    if state.enabled and last.samples > 0 and moving and unwound and math.isfinite(inputs.velocity):
        error = inputs.reference + inputs.correction - inputs.velocity
        learn_in_place(block, state, block.feedback.proportional * error + last.integral, inputs.dt)
    advance_features_in_place(block, state, inputs)
    torque = present_inertia(inputs, state.weights[INERTIA]) * state.features[INERTIA]
    for i in range(VISCOUS, block.scale.size):
        torque += state.weights[i] * state.features[i]
    output, feedback = feed_back(block.feedback, last, with_feedforward(inputs, torque), guard)
    return output, state._replace(feedback=feedback, reference=inputs.reference, refused=time_refused)


STEPS[LearntParameters] = step_learnt
ESTIMATES[LearntParameters] = without_estimates


class LearntFeedforward(Controller):
    """``u = PI(e) + J dr/dt + sigma r + offset + sum w_i phi_i``, weights by gradient from the feedback torque.

    Give reaches for an adaptive Maxwell-slip compensation, centres for a radial-basis one, or both.

    Parameters
    ----------
    proportional, integral : float
        Gains of the PI loop, N m s/rad and N m/rad.
    period : float
        Nominal sampling period, s.
    inertia : float
        Inertia that the feedback was designed for, kg m^2; the first weight.
    stribeck_velocity : float
        Pre-estimated ``Vs``, rad/s: the scale of the bells' velocities and of what is expected of friction.
    reaches : sequence of float, optional
        Displacements after which the stop operators slip, rad, ascending.
    centres : sequence of float, optional
        Centres of the bells as multiples of ``Vs``, ascending, two at least; their width is the mean distance.
    lag : float, optional
        Lag of the bells, s.
    rate : float, optional
        Learning rate, 1/s.
    delay : float, optional
        Computation delay of the drive, sampling periods.

    Raises
    ------
    ValueError
        A value is out of range.
    """

    def __init__(
        self,
        proportional: float,
        integral: float,
        period: float,
        *,
        inertia: float,
        stribeck_velocity: float,
        reaches: Sequence[float] = (),
        centres: Sequence[float] = (),
        lag: float = 0.0,
        rate: float = 1.0,
        delay: float = 0.0,
    ) -> None:
        feedback = check_gains(proportional, integral, period, delay)
        check_positive(proportional=proportional, inertia=inertia, stribeck_velocity=stribeck_velocity, rate=rate)
        if not 0.0 <= lag < math.inf:
            raise ValueError(f"lag = {lag} is not allowed: it must be finite and not negative")
        _check_ascending("reaches", reaches, 0.0)
        _check_ascending("centres", centres, -math.inf)
        if len(centres) == 1:
            raise ValueError(f"centres = {centres} is not allowed: there must be two at least, or none")
        places = np.arcsinh(np.array(centres, dtype=float))
        width = float(np.mean(np.diff(places))) if places.size else 1.0
        torque_scale = proportional * stribeck_velocity
        scale = [inertia, VISCOUS_SHARE * proportional, torque_scale, *(len(reaches) + len(centres)) * [torque_scale]]
        parameters = LearntParameters(
            feedback=feedback,
            inertia=float(inertia),
            period=float(period),
            reaches=np.array(reaches, dtype=float),
            centres=places,
            width=width,
            velocity_scale=float(stribeck_velocity),
            lag=float(lag),
            scale=np.array(scale, dtype=float),
            torque_scale=float(torque_scale),
            rate=float(rate),
        )
        super().__init__(parameters, period, initial_learnt_state)


def _check_ascending(name: str, values: Sequence[float], above: float) -> None:
    if not all(above < value < math.inf for value in values) or any(b <= a for a, b in pairwise(values)):
        bound = "finite" if math.isinf(above) else "finite and positive"
        raise ValueError(f"{name} = {list(values)} is not allowed: they must be {bound} and ascend strictly")
