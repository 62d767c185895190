"""The adaptive controller: PI loop with feedforward from a model that is identified while it works.

At every sample the filters of the torque-form regression advance over the period that has ended; while the joint
slides, the estimator corrects its five physical parameters; the model that they make is fed forward for the period
that begins; the PI loop does the rest.
"""

import math
from typing import NamedTuple

import numpy as np
from numba.extending import register_jitable
from numpy.typing import NDArray

from adaptive_ff.estimator import EstimatorParameters, EstimatorState, initial_estimator_state, learn, make_workspace
from adaptive_ff.feedforward import (
    FeedforwardState,
    exchange_model,
    initial_feedforward_state,
    step_feedforward,
)
from adaptive_ff.gate import sliding_time
from adaptive_ff.identifying import IdentifyingController, check_positive
from adaptive_ff.model import TorqueModel
from adaptive_ff.physical import LARGEST_LAG, torque_model, write_model
from adaptive_ff.torque_form import Signals, TorqueForm, advance_signals, initial_signals, settle_signals
from controllers import (
    ESTIMATES,
    STEPS,
    Inputs,
    Output,
    PIParameters,
    PIState,
    check_gains,
    hand_over,
    initial_pi_state,
    step_pi,
    with_feedforward,
)

GATE_SHARE = 0.2
"""Speed of the gate, as a share of the Stribeck velocity."""

GATE_HOLD = 3.0
"""Hold of the gate, in time constants of the filters."""

VISCOUS_SHARE = 0.2
"""Unit of the viscous coefficient, as a share of the proportional gain."""


class AdaptiveParameters(NamedTuple):
    """Parameters of the adaptive controller.

    Attributes
    ----------
    feedback : PIParameters
        The PI loop.
    estimator : EstimatorParameters
        The estimator.
    slowest : float
        Speed of the gate, rad/s.
    hold : float
        Hold of the gate, s.
    period : float
        Nominal period, s.
    """

    feedback: PIParameters
    estimator: EstimatorParameters
    slowest: float
    hold: float
    period: float


class AdaptiveState(NamedTuple):
    """State of the adaptive controller.

    Attributes
    ----------
    feedback : PIState
        State of the PI loop.
    feedforward : FeedforwardState
        State of the feedforward.
    measured : Signals
        Filters over the measurements.
    model : Signals
        Filters over the reference and the torque of the model.
    estimator : EstimatorState
        State of the estimator.
    sliding : float
        For how long the joint has been sliding, s.
    model_torque : float
        Torque of the model in the last period, N m.
    known_torque : float
        Torque known from elsewhere in the last period, N m.
    enabled : bool
        Whether the estimates adapt.
    """

    feedback: PIState
    feedforward: FeedforwardState
    measured: Signals
    model: Signals
    estimator: EstimatorState
    sliding: float
    model_torque: float
    known_torque: float
    enabled: bool


def initial_adaptive_state(block: AdaptiveParameters) -> AdaptiveState:
    """Return the state of a controller that knows nothing but the assumed inertia."""
    return AdaptiveState(
        initial_pi_state(block.feedback),
        initial_feedforward_state(),
        initial_signals(),
        initial_signals(),
        initial_estimator_state(block.estimator),
        -block.hold,  # the filters start from a guess: hold twice as long
        0.0,
        0.0,
        True,
    )


@register_jitable(forceinline=True)
def identified_model(block: AdaptiveParameters, state: AdaptiveState) -> TorqueModel:
    """Return the model as it is identified now."""
    form = block.estimator.form
    return torque_model(state.estimator.estimate, form.stribeck_velocity, form.stribeck_shape)


@register_jitable(forceinline=True)
def learn_bumpless(
    block: AdaptiveParameters, state: AdaptiveState, measured: Signals, model: Signals, inputs: Inputs
) -> tuple[float, FeedforwardState, PIState]:
    """Learn, and hand over from the integral to the feedforward what the new estimate adds to the latter.

    The integral holds what the feedforward did not give so far. Without the hand-over both would give it for a while.
    """
    reference, following = inputs.reference, inputs.next_reference
    old = identified_model(block, state)
    before, _ = step_feedforward(old, state.feedforward, reference, following, block.period)
    learn(block.estimator, state.estimator, measured, model, inputs.dt)
    new = identified_model(block, state)
    feedforward = exchange_model(state.feedforward, old, new, reference)
    after, feedforward = step_feedforward(new, feedforward, reference, following, block.period)
    return after, feedforward, hand_over(block.feedback, state.feedback, after - before)


@register_jitable(forceinline=True)
def step_adaptive(block: AdaptiveParameters, state: AdaptiveState, inputs: Inputs) -> tuple[Output, AdaptiveState]:
    """Do one sample: learn from the period that ends, feed forward for the one that begins, then feedback."""
    valid = math.isfinite(inputs.velocity)
    velocity = inputs.velocity if valid else state.feedback.velocity
    realised = inputs.realised_torque if math.isfinite(inputs.realised_torque) else state.feedback.command
    form = block.estimator.form
    measured, model = state.measured, state.model
    if state.feedback.samples == 0:
        measured = settle_signals(form, measured, velocity)
        model = settle_signals(form, model, inputs.reference)
    measured = advance_signals(form, measured, realised - state.known_torque, velocity, inputs.dt)
    model = advance_signals(form, model, state.model_torque, inputs.reference, inputs.dt)
    sliding = sliding_time(state.sliding, velocity, inputs.reference, valid, block.slowest, inputs.dt)
    feedback = state.feedback
    if state.enabled and sliding > block.hold:
        torque, feedforward, feedback = learn_bumpless(block, state, measured, model, inputs)
    else:
        torque, feedforward = step_feedforward(
            identified_model(block, state), state.feedforward, inputs.reference, inputs.next_reference, block.period
        )
    output, feedback = step_pi(block.feedback, feedback, with_feedforward(inputs, torque))
    return output, AdaptiveState(
        feedback,
        feedforward,
        measured,
        model,
        state.estimator,
        sliding,
        torque,
        inputs.feedforward,
        state.enabled,
    )


@register_jitable(forceinline=True)
def write_adaptive(block: AdaptiveParameters, state: AdaptiveState, row: NDArray[np.float64]) -> None:
    """Write the physical estimates into a row."""
    write_model(identified_model(block, state), row)


STEPS[AdaptiveParameters] = step_adaptive
ESTIMATES[AdaptiveParameters] = write_adaptive


class AdaptiveController(IdentifyingController):
    """PI loop with feedforward from a model identified online.

    The first estimate is a frictionless joint of the assumed inertia, with a friction lag equal to the time constant
    ``J/Kp`` of the feedback; lags that are much shorter hardly matter to the loop.

    Parameters
    ----------
    proportional, integral : float
        Gains of the PI loop, N m s/rad and N m/rad.
    period : float
        Nominal sampling period, s.
    inertia : float
        Inertia that the feedback was designed for, kg m^2; it may be wrong.
    stribeck_velocity : float
        Stribeck velocity, rad/s, pre-estimated; it may be wrong.
    stribeck_shape : float, optional
        Stribeck shape factor, pre-estimated.
    memory : float, optional
        Memory of the estimator, s of sliding motion: an equation counts ``exp(-age/memory)``.
    filter_pole : float, optional
        Pole of the regression's filters, rad/s; by default the crossover of the feedback, ``Kp/J``.

    Raises
    ------
    ValueError
        A value is out of range.

    Examples
    --------
    >>> from adaptive_ff import AdaptiveController
    >>> from controllers import PI
    >>> design = PI.design(inertia=20.0, period=0.01, bandwidth=10.0)
    >>> controller = AdaptiveController(
    ...     design.proportional, design.integral, period=0.01, inertia=20.0, stribeck_velocity=0.05
    ... )
    >>> torque = controller.step(0.1, 0.0, next_reference=0.101)
    >>> controller.estimates["coulomb"]
    0.0
    """

    def __init__(
        self,
        proportional: float,
        integral: float,
        period: float,
        *,
        inertia: float,
        stribeck_velocity: float,
        stribeck_shape: float = 1.0,
        memory: float = 5.0,
        filter_pole: float | None = None,
    ) -> None:
        feedback = check_gains(proportional, integral)
        check_positive(
            proportional=proportional,
            inertia=inertia,
            stribeck_velocity=stribeck_velocity,
            stribeck_shape=stribeck_shape,
            memory=memory,
        )
        pole = proportional / inertia if filter_pole is None else filter_pole
        check_positive(filter_pole=pole)
        torque_scale = proportional * stribeck_velocity
        response = inertia / proportional
        scale = [inertia, torque_scale, torque_scale, VISCOUS_SHARE * proportional, response]
        estimator = EstimatorParameters(
            TorqueForm(float(pole), float(stribeck_velocity), float(stribeck_shape)),
            np.array([inertia, 0.0, 0.0, 0.0, response]),
            np.array(scale),
            float(torque_scale),
            LARGEST_LAG * response,
            float(memory),
            make_workspace(),
        )
        parameters = AdaptiveParameters(
            feedback, estimator, GATE_SHARE * float(stribeck_velocity), GATE_HOLD / float(pole), float(period)
        )
        super().__init__(parameters, period, initial_adaptive_state)
