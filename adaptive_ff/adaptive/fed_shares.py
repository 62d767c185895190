"""Shares of friction and of observed torque that are fed: the least of what trust, balance, drive and sensor allow."""

from typing import NamedTuple

from numba.extending import register_jitable

from adaptive_ff.adaptive.faults.counts import fine_share, first_counts, kicked_share
from adaptive_ff.adaptive.faults.drive_limit import answered_share, believed_share
from adaptive_ff.adaptive.faults.drive_limit_state import DriveLimit
from adaptive_ff.adaptive.faults.seen_velocity import SeenVelocity
from adaptive_ff.adaptive.learning.candidate_state import slides
from adaptive_ff.adaptive.learning.change_detection import shows_cause
from adaptive_ff.adaptive.learning.period import Fed
from adaptive_ff.adaptive.learning.unexplained import breakaway
from adaptive_ff.adaptive.sensing import Sensed
from adaptive_ff.adaptive.supervised_state import SupervisedParameters, SupervisedState
from adaptive_ff.adaptive.supervision.balance import Balance, balanced_share
from adaptive_ff.adaptive.supervision.observer_gates import helping_share, observer_gain
from adaptive_ff.adaptive.supervision.observer_state import ObserverState
from adaptive_ff.adaptive.supervision.trust import TrustState, caution, soft_bound
from adaptive_ff.adaptive.watching import holding_friction
from adaptive_ff.friction.bounds import INERTIA


class Shares(NamedTuple):
    """Shares of what is fed, and of what they come from.

    Attributes
    ----------
    friction : float
        Share of the friction of the model.
    gain : float
        Gain of the observer.
    fine : float
        Share of what is observed that the sensor is fine enough for.
    kicked : float
        Share to which what the feedback makes of the sensor is more than the friction.
    """

    friction: float
    gain: float
    fine: float
    kicked: float


@register_jitable
def least_bound(block: SupervisedParameters, state: SupervisedState, trust: TrustState, drive: DriveLimit) -> float:
    """Return the bound on trust and on the observer's gain: of slow motion, a soft loop, and a drive."""
    time, friction = state.feedback.samples * block.period, breakaway(state.estimator)
    bound = caution(trust, block.slowest, state.estimator.levels.learnt, block.estimator.memory, time)
    bound = min(bound, soft_bound(trust, block.feedback.proportional, friction, time))
    return min(bound, believed_share(drive, friction))


@register_jitable
def kicked_by_counts(
    block: SupervisedParameters, state: SupervisedState, observer: ObserverState, peak: float, seen: SeenVelocity
) -> float:
    """Return the share to which what the feedback makes of the sensor is more than the friction."""
    friction, samples, gain = holding_friction(state), state.feedback.samples, block.feedback.proportional
    return kicked_share(seen, samples, observer.noise, gain, friction, peak, block.period)


@register_jitable
def sensed_share(block: SupervisedParameters, state: SupervisedState, peak: float, seen: SeenVelocity) -> float:
    """Return the share of what is observed that the sensor is fine enough for, which its first counts are not."""
    kick = block.feedback.proportional * seen.finest
    if first_counts(seen, state.feedback.samples, kick, holding_friction(state)):
        return 0.0
    return fine_share(seen, state.feedback.samples, peak)


@register_jitable
def fed_shares(
    block: SupervisedParameters,
    state: SupervisedState,
    sensed: Sensed,
    observer: ObserverState,
    trust: TrustState,
    balance: Balance,
    fed: Fed,
    unfit: float,
    share: float,
) -> Shares:
    """Return the shares that are fed over the coming period.

    Parameters
    ----------
    block, state : SupervisedParameters, SupervisedState
        Parameters, and state of before: what the gates compare belongs to the period that has ended.
    sensed, observer, trust, balance, fed : Sensed, ObserverState, TrustState, Balance, Fed
        What has come of the sample so far.
    unfit : float
        Share to which the model is unfit.
    share : float
        Share of all that is fed while it is faded in or out.
    """
    drive, friction = sensed.drive, breakaway(state.estimator)
    bound = least_bound(block, state, trust, drive)
    kicked = kicked_by_counts(block, state, observer, trust.peak, sensed.seen)
    trusted = min(trust.trust, min(bound, answered_share(drive, fed.friction)))
    trusted = min(trusted, balanced_share(balance, friction, kicked))
    inertia = fed.estimator.recursion.estimate[INERTIA]
    gain = observer_gain(block.observer, observer, block.feedback, inertia, unfit)
    if slides(fed.estimator.candidates) and shows_cause(fed.estimator.alarm, sensed.inputs.reference):
        gain = 1.0  # something is missed now, whichever the cause is
    fine = sensed_share(block, state, trust.peak, sensed.seen)
    gain *= fine * (1.0 - kicked)
    gain *= helping_share(observer, holding_friction(state))
    gain = share * observer.effect.share * min(gain, bound) * answered_share(drive, observer.disturbance)
    return Shares(trusted, gain, fine, kicked)
