"""What passes between feedforward, observer and integral at a sample, so that the torque does not jump."""

from typing import NamedTuple

from numba.extending import register_jitable

from adaptive_ff.adaptive.at_rest.wound_integral import Standing
from adaptive_ff.adaptive.faults.counts import spurious_torque
from adaptive_ff.adaptive.faults.drive_limit import without_never_given
from adaptive_ff.adaptive.faults.held_integral import HeldIntegral, hold_integral
from adaptive_ff.adaptive.fed_shares import Shares
from adaptive_ff.adaptive.learning.estimator import estimated_load
from adaptive_ff.adaptive.learning.estimator_state import load_count
from adaptive_ff.adaptive.learning.period import Fed, Period
from adaptive_ff.adaptive.learning.unexplained import breakaway
from adaptive_ff.adaptive.sensing import Sensed
from adaptive_ff.adaptive.setting_out import begins_to_observe
from adaptive_ff.adaptive.supervised_state import SupervisedParameters, SupervisedState
from adaptive_ff.adaptive.supervision.observer_hand_over import hand_over_to_observer, observe_all, take_up
from adaptive_ff.adaptive.supervision.observer_state import ObserverState
from adaptive_ff.friction.bounds import OFFSET
from controllers import unwound_integral

TAKEN_UP = 0.25
"""Share of the time for which a joint must slide until learning begins, after which it surely moves."""


class Passing(NamedTuple):
    """What passes at a sample, and when.

    Attributes
    ----------
    change : float
        By how much estimates and shares have changed the torque that is fed forward, N m.
    faded : float
        What is fed more of the loads while that is faded in, N m.
    fed : float
        All that is fed forward over the coming period, known torque included, N m.
    wound : float
        What has become friction of the feedforward, N m.
    moves : bool
        Whether the joint is sure to move.
    begins : bool
        Whether the observer begins to follow what the integral has held without it.
    """

    change: float
    faded: float
    fed: float
    wound: float
    moves: bool
    begins: bool


@register_jitable
def fed_torque(fed: Fed, trust: float) -> float:
    """Return the torque that is fed forward when the friction is trusted to a share, N m."""
    return fed.torque - (1.0 - trust) * fed.friction


@register_jitable
def standing_load(block: SupervisedParameters, fed: Fed) -> float:
    """Return what is fed of loads that do not depend on the motion, N m: offset, gravity and further regressors."""
    load, estimate = estimated_load(block.estimator, fed.estimator, 0.0), fed.estimator.recursion.estimate
    if estimate.size - load_count(block.estimator) > OFFSET:
        load += estimate[OFFSET]
    return float(load)


@register_jitable
def passing_torque(
    block: SupervisedParameters,
    state: SupervisedState,
    sensed: Sensed,
    period: Period,
    fed: Fed,
    shares: Shares,
    standing: Standing,
    share: float,
    set_out: float,
) -> tuple[float, Passing]:
    """Return the torque that is fed forward beside the known one, N m, and what passes because of it.

    Parameters
    ----------
    block, state, sensed : SupervisedParameters, SupervisedState, Sensed
        Parameters, state before the sample, and the sample.
    period, fed, shares, standing : Period, Fed, Shares, Standing
        What has come of the sample so far.
    share : float
        Share of all that is fed while it is faded in or out.
    set_out : float
        Torque that was wound up at rest and becomes friction of the feedforward now, N m.
    """
    torque = fed_torque(fed, shares.friction)
    change = share * (torque - (fed.old_torque - (1.0 - state.trust.trust) * fed.old_friction))
    faded = 0.0
    if share != state.command.share:
        faded = (share - state.command.share) * standing_load(block, fed)
    torque = sensed.given + share * (torque - sensed.given)  # what was given is not the controller's to fade
    return torque, Passing(
        change=change,
        faded=faded,
        fed=torque + sensed.inputs.feedforward,
        wound=share * state.trust.trust * set_out,
        moves=period.sliding > TAKEN_UP * block.hold,
        begins=begins_to_observe(state, share, standing.rests),
    )


@register_jitable
def share_out(
    block: SupervisedParameters,
    state: SupervisedState,
    sensed: Sensed,
    observer: ObserverState,
    shares: Shares,
    passing: Passing,
) -> tuple[ObserverState, HeldIntegral, float]:
    """Return observer, what is held of the integral, and what leaves it (N m), so that the torque does not jump."""
    integral = unwound_integral(block.feedback, state.feedback, sensed.checked)
    spurious = spurious_torque(
        observer.disturbance, state.observer.disturbance, shares.fine, shares.kicked, breakaway(state.estimator)
    )
    given_up = 0.0
    if passing.begins:
        observer, given_up = observe_all(observer, integral - passing.wound)
    integral += given_up
    observer, taken = take_up(observer, integral, passing.moves)
    observer, leaves = hand_over_to_observer(
        observer,
        passing.change + passing.faded,
        shares.gain,
        passing.fed,
        integral - passing.wound - taken,
        spurious,
    )
    leaves -= given_up
    # what the integral holds of a load is true, whatever the drive has given
    faded = (1.0 - shares.gain) * passing.faded
    leaves = without_never_given(sensed.drive, leaves - faded, state.feedback.integral) + faded
    leaves += taken + passing.wound
    lost = sensed.guard.lost / block.period
    held, leaves = hold_integral(state.held, state.feedback.integral, leaves, lost, sensed.inputs.dt)
    return observer, held, leaves
