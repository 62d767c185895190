"""Parameters and state of the adaptive controller; see :mod:`adaptive_ff.adaptive.step`."""

from typing import NamedTuple

from adaptive_ff.adaptive.command import CommandParameters, CommandState, initial_command_state
from adaptive_ff.adaptive.faults.doubt import Doubt, initial_doubt
from adaptive_ff.adaptive.learning.estimator_state import (
    EstimatorParameters,
    EstimatorState,
    initial_estimator_state,
    load_count,
)
from adaptive_ff.adaptive.learning.fed_model import Block
from adaptive_ff.adaptive.learning.lag_tuning import TimingState, initial_timing_state
from adaptive_ff.friction.bounds import FRICTION_LAG
from adaptive_ff.friction.feedforward import FeedforwardState, initial_feedforward_state
from adaptive_ff.learning.torque_form import Signals, initial_signals
from controllers import PIParameters, PIState, delay_line, initial_pi_state


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
    doubt : Doubt
        Doubt about what is measured.
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
    doubt: Doubt


def initial_adaptive_state(block: Block) -> AdaptiveState:
    """Return the state of a controller that knows nothing but the assumed inertia."""
    parameters = block.estimator.first.size - load_count(block.estimator)
    return AdaptiveState(
        feedback=initial_pi_state(block.feedback),
        feedforward=initial_feedforward_state(),
        measured=initial_signals(parameters),
        model=initial_signals(parameters),
        estimator=initial_estimator_state(block.estimator),
        sliding=-block.hold,  # the filters start from a guess: hold twice as long
        lagged_torque=0.0,
        model_torques=delay_line(block.feedback.delay),
        known_torques=delay_line(block.feedback.delay),
        timing=initial_timing_state(
            block.feedback,
            float(block.estimator.first[FRICTION_LAG]),
            float(block.estimator.deviation[FRICTION_LAG]),
        ),
        enabled=True,
        command=initial_command_state(),
        doubt=initial_doubt(),
    )
