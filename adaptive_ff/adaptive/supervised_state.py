"""Parameters and state of the supervised controller; see :mod:`adaptive_ff.adaptive.supervised_step`."""

from typing import NamedTuple

from adaptive_ff.adaptive.at_rest.held_friction import HeldFriction
from adaptive_ff.adaptive.at_rest.outer_loop import OuterLoop
from adaptive_ff.adaptive.at_rest.wound_integral import Standing
from adaptive_ff.adaptive.command import CommandParameters, CommandState
from adaptive_ff.adaptive.faults.doubt import Doubt
from adaptive_ff.adaptive.faults.drive_limit_state import DriveLimit
from adaptive_ff.adaptive.faults.held_integral import HeldIntegral
from adaptive_ff.adaptive.faults.seen_velocity import SeenVelocity
from adaptive_ff.adaptive.learning.estimator_state import EstimatorParameters, EstimatorState
from adaptive_ff.adaptive.learning.lag_tuning import TimingState
from adaptive_ff.adaptive.supervision.balance import Balance
from adaptive_ff.adaptive.supervision.observer_state import ObserverParameters, ObserverState
from adaptive_ff.adaptive.supervision.trust import TrustState
from adaptive_ff.friction.feedforward import FeedforwardState
from adaptive_ff.learning.torque_form import Signals
from controllers import PIParameters, PIState


class SupervisedParameters(NamedTuple):
    """Parameters of the supervised controller: those of the one without supervision, and the observer's.

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
    observer : ObserverParameters
        The observer.
    """

    feedback: PIParameters
    estimator: EstimatorParameters
    slowest: float
    hold: float
    velocity_lag: float
    period: float
    tunes_lag: bool
    command: CommandParameters
    observer: ObserverParameters


class Bridge(NamedTuple):
    """What there was since a velocity was believed; nothing where the last one is.

    Attributes
    ----------
    lacking : float
        Mean torque beyond what was fed forward, N m.
    unforeseen : float
        Change of the plan that was not foreseen, rad/s.
    """

    lacking: float
    unforeseen: float


class SupervisedState(NamedTuple):
    """State of the supervised controller: that of the one without supervision, the observer's and the trust.

    Attributes
    ----------
    feedback : PIState
        State of the PI loop.
    feedforward : FeedforwardState
        State of the feedforward.
    measured, model : Signals
        Filters over the measurements, and over the reference and the torque of the model; arrays changed in place.
    estimator : EstimatorState
        State of the estimator; arrays changed in place.
    sliding : float
        For how long the joint has been sliding, s.
    lagged_torque : float
        Torque behind a low-pass with the lag of the measured velocity, N m.
    model_torques, known_torques : tuple of float
        Torque of the model at full trust, and torque known from elsewhere, N m, the newest first.
    timing : TimingState
        State of the tuning of the feedforward's lag.
    enabled : bool
        Whether the estimates adapt.
    command : CommandState
        How much of the feedforward is fed, and of the observer.
    doubt : Doubt
        Doubt about what is measured.
    observer : ObserverState
        State of the observer.
    trust : TrustState
        State of the trust.
    held : HeldIntegral
        What of the integral is held while the measurement is lost.
    outer : OuterLoop
        What an outer loop can tell at rest.
    held_friction : HeldFriction
        What the joint has shown of the friction that it holds at rest.
    drive : DriveLimit
        What its motion has shown of the drive.
    seen : SeenVelocity
        What is remembered of measured velocities.
    balance : Balance
        Friction that the torque along the plan tells of, and that of the model.
    bridge : Bridge
        What there was since a velocity was believed.
    moved : float
        Largest torque beyond what is known with which the joint has followed its plan of late, N m.
    standing : Standing
        What the integral has wound up while the plan rests.
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
    observer: ObserverState
    trust: TrustState
    held: HeldIntegral
    outer: OuterLoop
    held_friction: HeldFriction
    drive: DriveLimit
    seen: SeenVelocity
    balance: Balance
    bridge: Bridge
    moved: float
    standing: Standing
