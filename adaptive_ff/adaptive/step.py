"""One sample of the adaptive controller: parameters, state and kernels.

At every sample the filters of the torque-form regression advance over the period that has ended; while the joint
slides, the estimator corrects its physical parameters; the model that they make is fed forward for the period
that begins, with a friction lag that the tracking error tunes; the PI loop does the rest.
"""

import math
from typing import NamedTuple

import numpy as np
from numba.extending import register_jitable
from numpy.typing import NDArray

from adaptive_ff.adaptive.command import (
    CommandParameters,
    CommandState,
    fade,
    inertia_torque,
    initial_command_state,
    limited,
    machine_inputs,
)
from adaptive_ff.adaptive.estimator import (
    SPEED_FACTOR,
    EstimatorParameters,
    EstimatorState,
    estimated_load,
    follow_loads_in_place,
    guess_friction_in_place,
    initial_estimator_state,
    learn_in_place,
    load_count,
    may_guess,
)
from adaptive_ff.adaptive.lag_tuning import (
    FIRST,
    YOUNG,
    TimingState,
    advance_response,
    best_lag,
    drop_stale_evidence,
    initial_timing_state,
    lag_torque,
    learn_timing,
    note_friction,
    with_evidence,
)
from adaptive_ff.model.bounds import FRICTION_LAG, INERTIA, torque_model, write_model
from adaptive_ff.model.feedforward import (
    FeedforwardState,
    ahead,
    exchange_model,
    initial_feedforward_state,
    step_feedforward,
)
from adaptive_ff.model.friction import TorqueModel
from adaptive_ff.regression.sliding_gate import sliding_time
from adaptive_ff.regression.torque_form import (
    Signals,
    advance_signals_in_place,
    initial_signals,
    settle_signals_in_place,
)
from controllers import (
    ESTIMATES,
    STEPS,
    Inputs,
    Output,
    PIParameters,
    PIState,
    acting_torque,
    asked_torque,
    delay_line,
    delayed,
    hand_over,
    initial_pi_state,
    present_inertia,
    remember,
    step_pi,
    with_feedforward,
)


GUESS_HOLD = 0.5
"""Time for which the joint must have been sliding for a guess of its friction, in holds of the gate."""


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
    velocity_lag : float
        Time by which the measured velocity lags behind the joint's, s.
    period : float
        Nominal period, s.
    tunes_lag : bool
        Whether the lag of the feedforward is tuned by the tracking error.
    command : CommandParameters
        What stands between the controller and the machine.
    """

    feedback: PIParameters
    estimator: EstimatorParameters
    slowest: float
    hold: float
    velocity_lag: float
    period: float
    tunes_lag: bool
    command: CommandParameters


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
    lagged_torque : float
        Torque behind a low-pass with the lag of the measured velocity, N m.
    model_torques, known_torques : tuple of float
        Torque of the model, and torque known from elsewhere, N m, the newest first, as far back as the drive may still
        apply them.
    timing : TimingState
        State of the tuning of the feedforward's lag.
    enabled : bool
        Whether the estimates adapt.
    command : CommandState
        How much of the feedforward is fed.
    """

    feedback: PIState
    feedforward: FeedforwardState
    measured: Signals
    model: Signals
    estimator: EstimatorState
    sliding: float
    lagged_torque: float
    model_torques: tuple[float, ...]
    known_torques: tuple[float, ...]
    timing: TimingState
    enabled: bool
    command: CommandState


def initial_adaptive_state(block: AdaptiveParameters) -> AdaptiveState:
    """Return the state of a controller that knows nothing but the assumed inertia."""
    parameters = block.estimator.first.size - load_count(block.estimator)
    return AdaptiveState(
        initial_pi_state(block.feedback),
        initial_feedforward_state(),
        initial_signals(parameters),
        initial_signals(parameters),
        initial_estimator_state(block.estimator),
        -block.hold,  # the filters start from a guess: hold twice as long
        0.0,
        delay_line(block.feedback.delay),
        delay_line(block.feedback.delay),
        initial_timing_state(block.feedback, float(block.estimator.first[FRICTION_LAG])),
        True,
        initial_command_state(),
    )


@register_jitable(forceinline=True)
def fed_model(block: AdaptiveParameters, estimator: EstimatorState, lag: float) -> TorqueModel:
    """Return the model that is fed forward: the identified one with a lag (s) of its own."""
    form, loads = block.estimator.form, load_count(block.estimator)
    return torque_model(estimator.recursion.estimate, lag, form.stribeck_velocity, form.stribeck_shape, loads)


@register_jitable(forceinline=True)
def inertia_ratio(block: AdaptiveParameters, inputs: Inputs) -> float:
    """Return the inertia that is given for the present configuration over the one that is estimated at first.

    What is given counts as the assumed inertia of the configuration; what is estimated is by how much it is wrong.
    """
    assumed = float(block.estimator.first[INERTIA])
    return present_inertia(inputs, assumed) / assumed


@register_jitable(forceinline=True)
def step_model(
    block: AdaptiveParameters,
    model: TorqueModel,
    estimator: EstimatorState,
    state: FeedforwardState,
    inputs: Inputs,
) -> tuple[float, FeedforwardState]:
    """Return the torque (N m) that a model and the estimated loads need over the coming period, and the new state.

    Loads are those at the measured position, moved on along the plan to the middle of the period.
    """
    delay, inertia = block.feedback.delay, math.nan
    if math.isfinite(inputs.inertia):
        inertia = model.inertia * inertia_ratio(block, inputs)
    torque, new = step_feedforward(model, state, inputs.reference, inputs.next_reference, block.period, delay, inertia)
    turn = (delay + 0.5) * block.period * inputs.reference
    return torque + estimated_load(block.estimator, estimator, turn), new


@register_jitable(forceinline=True)
def identified_model(block: AdaptiveParameters, state: AdaptiveState) -> TorqueModel:
    """Return the model as it is identified now."""
    return fed_model(block, state.estimator, state.estimator.recursion.estimate[FRICTION_LAG])


@register_jitable(forceinline=True)
def tune_lag(block: AdaptiveParameters, state: AdaptiveState, inputs: Inputs) -> TimingState:
    """Return the state of the lag's tuning after the period that has ended."""
    timing, estimator, levels = state.timing, block.estimator, state.estimator.levels
    timing = advance_response(timing, block.feedback, estimator.first[INERTIA], block.velocity_lag, inputs.dt)
    error = inputs.reference + inputs.correction - inputs.velocity  # what the feedback sees
    possible = abs(error) < SPEED_FACTOR * levels.speed  # else a fault of the measurement
    if state.enabled and possible and levels.learnt > FIRST * estimator.memory:
        return learn_timing(timing, error, levels.learnt, estimator.memory, inputs.dt)
    return timing


@register_jitable(forceinline=True)
def learn_bumpless_in_place(
    block: AdaptiveParameters,
    state: AdaptiveState,
    measured: Signals,
    model: Signals,
    timing: TimingState,
    inputs: Inputs,
    learns: bool,
) -> tuple[float, FeedforwardState, PIState, EstimatorState, TimingState]:
    """Learn, or guess before there is anything to learn, and hand over to the feedforward what that adds to it.

    The integral holds what the feedforward did not give so far. Without the hand-over both would give it for a while.

    Returns
    -------
    torque : float
        Torque that is fed forward, N m.
    feedforward, feedback, estimator, timing : NamedTuple
        The new states; the estimator shares the arrays of the old one, which are changed in place.
    """
    reference, following, delay = inputs.reference, inputs.next_reference, block.feedback.delay
    start, _ = ahead(state.feedforward, reference, following, delay)
    # the model copies numbers out of the estimate, so it stays the old one when the estimate changes in place
    old = fed_model(block, state.estimator, timing.lag)
    before, _ = step_model(block, old, state.estimator, state.feedforward, inputs)
    ratio = inertia_ratio(block, inputs)
    if learns:
        estimator = learn_in_place(block.estimator, state.estimator, measured, model, inputs.dt, ratio)
    else:
        estimator = guess_friction_in_place(block.estimator, state.estimator, measured, model, ratio)
    identified, largest = estimator.recursion.estimate[FRICTION_LAG], block.estimator.ranges[FRICTION_LAG, 1]
    young = estimator.levels.learnt < YOUNG * block.estimator.memory
    timing = drop_stale_evidence(timing, identified, block.period, young)
    timing = with_evidence(timing, timing.evidence, best_lag(timing, identified, largest, block.period))
    new = fed_model(block, estimator, timing.lag)
    feedforward = exchange_model(state.feedforward, old, new, start)
    after, feedforward = step_model(block, new, estimator, feedforward, inputs)
    return (
        after,
        feedforward,
        hand_over(block.feedback, state.feedback, state.command.share * (after - before)),
        estimator,
        timing,
    )


@register_jitable(forceinline=True)
def step_adaptive(block: AdaptiveParameters, state: AdaptiveState, inputs: Inputs) -> tuple[Output, AdaptiveState]:
    """Do one sample: learn from the period that ends, feed forward for the one that begins, then feedback.

    With a computation delay the period that the feedforward is for begins later, and the torques that belong to the one
    that ends were computed earlier.
    """
    valid, delay = math.isfinite(inputs.velocity), block.feedback.delay
    moved = 0.0
    if block.command.includes_inertia:
        moved = inertia_torque(block.estimator.first[INERTIA], state.feedforward, inputs, block.period, delay)
    inputs = machine_inputs(block.command, block.feedback, state.feedback, inputs, moved)
    command = fade(state.command, inputs.dt)
    velocity = inputs.velocity if valid else state.feedback.velocity
    form = block.estimator.form
    measured, model = state.measured, state.model
    if state.feedback.samples == 0:
        measured = settle_signals_in_place(form, measured, velocity)
        model = settle_signals_in_place(form, model, inputs.reference)
    acting = acting_torque(inputs, asked_torque(block.feedback, state.feedback), delayed(state.known_torques, delay))
    lagged_torque = state.lagged_torque
    if block.velocity_lag > 0.0:  # what the velocity shows now is what the torque did a while ago
        acting, lagged_torque = lag_torque(block.velocity_lag, lagged_torque, acting, inputs.dt)
    measured = advance_signals_in_place(form, measured, acting, velocity, inputs.dt)
    follow_loads_in_place(block.estimator, state.estimator, inputs.position, inputs.dt, state.feedback.samples == 0)
    model = advance_signals_in_place(form, model, delayed(state.model_torques, delay), inputs.reference, inputs.dt)
    sliding = sliding_time(state.sliding, velocity, inputs.reference, valid, block.slowest, inputs.dt)
    feedback, estimator, timing = state.feedback, state.estimator, state.timing
    if block.tunes_lag and command.share == 1.0:
        timing = tune_lag(block, state, inputs)
    learns = sliding > block.hold
    # a joint that a brake clamps does not move, and what it takes is not friction
    guesses = sliding > GUESS_HOLD * block.hold and may_guess(block.estimator, estimator)
    if state.enabled and (learns or (valid and guesses)):
        torque, feedforward, feedback, estimator, timing = learn_bumpless_in_place(
            block, state, measured, model, timing, inputs, learns
        )
    else:
        model_now = fed_model(block, estimator, timing.lag)
        torque, feedforward = step_model(block, model_now, estimator, state.feedforward, inputs)
    # what was given for the inertia is not the controller's to fade
    fed = moved + command.share * (torque - moved)
    output, feedback = step_pi(block.feedback, feedback, with_feedforward(inputs, fed))
    return Output(limited(output.torque, block.command.torque_limit), output.feedforward), AdaptiveState(
        feedback,
        feedforward,
        measured,
        model,
        estimator,
        sliding,
        lagged_torque,
        remember(state.model_torques, torque),
        remember(state.known_torques, inputs.feedforward),
        note_friction(timing, state.feedforward.friction, feedforward.friction, timing.lag, block.period),
        state.enabled,
        command,
    )


@register_jitable(forceinline=True)
def write_adaptive(block: AdaptiveParameters, state: AdaptiveState, row: NDArray[np.float64]) -> None:
    """Write the physical estimates into a row."""
    loads = load_count(block.estimator)
    write_model(identified_model(block, state), row, loads)
    for i in range(row.size - loads, row.size):
        row[i] = state.estimator.recursion.estimate[i]


STEPS[AdaptiveParameters] = step_adaptive
ESTIMATES[AdaptiveParameters] = write_adaptive
