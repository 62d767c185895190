"""What a period brought, and what is fed forward over the next: what the stages of a sample hand on."""

from typing import NamedTuple

from adaptive_ff.adaptive.learning.estimator_state import EstimatorState
from adaptive_ff.adaptive.learning.lag_tuning import TimingState
from adaptive_ff.friction.feedforward import FeedforwardState
from adaptive_ff.learning.torque_form import Signals


class Period(NamedTuple):
    """What the period that has ended brought, before anything is learnt from it.

    Attributes
    ----------
    measured, model : Signals
        Filters at its end; their arrays are those of the state.
    lagged_torque : float
        Torque behind a low-pass with the lag of the measured velocity, N m.
    sliding : float
        For how long the joint has been sliding, s.
    timing : TimingState
        State of the tuning of the feedforward's lag.
    clear : bool
        Whether there is no doubt, so that it may be learnt from.
    """

    measured: Signals
    model: Signals
    lagged_torque: float
    sliding: float
    timing: TimingState
    clear: bool


class Fed(NamedTuple):
    """What is fed forward over the coming period, and what it would be with the estimates of before.

    Attributes
    ----------
    old_torque, old_friction : float
        Torque that the old estimates feed, and the friction in it, N m.
    torque, friction : float
        Torque that the new estimates feed, and the friction in it, N m.
    feedforward : FeedforwardState
        New state of the feedforward.
    estimator : EstimatorState
        New state of the estimator; it shares the arrays of the old one, which are changed in place.
    timing : TimingState
        State of the tuning, with the lag that is fed.
    """

    old_torque: float
    old_friction: float
    torque: float
    friction: float
    feedforward: FeedforwardState
    estimator: EstimatorState
    timing: TimingState
