"""Observer and trust after the period that has ended: their inputs from the state of the whole controller.

Beside the motion itself the observer needs to know whether the joint may stick, how steeply its friction falls, and
whether the drive gives all torque, or far more than has ever moved the joint.
"""

import math

from numba.extending import register_jitable

from adaptive_ff.adaptive.faults.drive_limit import is_believed
from adaptive_ff.adaptive.learning.candidate_state import slides
from adaptive_ff.adaptive.learning.change_detection import UNDECIDED
from adaptive_ff.adaptive.learning.estimator_state import may_guess
from adaptive_ff.adaptive.learning.fed_model import inertia_ratio
from adaptive_ff.adaptive.learning.unexplained import breakaway
from adaptive_ff.adaptive.supervised_state import Bridge, SupervisedParameters, SupervisedState
from adaptive_ff.adaptive.supervision.circumstances import Circumstances, strains
from adaptive_ff.adaptive.supervision.noise_level import likely_variance
from adaptive_ff.adaptive.supervision.observer import CLEAR, bridged_torque, observe
from adaptive_ff.adaptive.supervision.observer_gates import error_beyond_noise, observed_inertia
from adaptive_ff.adaptive.supervision.observer_state import ObserverState, start_observer
from adaptive_ff.adaptive.supervision.trust import TrustState, advance_trust
from adaptive_ff.estimation.shares import saturated
from adaptive_ff.friction.bounds import COULOMB, INERTIA, STICTION
from adaptive_ff.friction.turning import is_held
from controllers import Inputs, acting_torque, asked_torque, delayed

STEEP = 5.0
"""Fall of friction with the velocity, in proportional gains, from which on the predicted error begins to mislead; at
twice that, it is not used."""

RINGS = 2.0
"""Fall of friction, in proportional gains, beyond which a joint sticks and slips by itself, with or without a lag ...

With 1 a drive that lags by 50 ms keeps an observer with which the loop rings.
"""

KNOWN = 0.5
"""... and time that must have been learnt before, in memories of the estimator.

With a whole one, one of 400 drawn joints has a window of 1.5 times PI's error.
"""

FULL_TRUST = 0.95
"""Trust from which on errors after a change lower it only once the cause of the change is known."""

FOLLOWS, FAST = 0.5, 0.1
"""Error over the plan up to which a joint follows it, and least speed of a plan that counts, over its largest one."""

FADES = 60.0
"""Time constant with which the largest torque with which the joint has followed is forgotten, s."""

BRIDGED = 10.5
"""Longest time without a measurement that the observer bridges, in periods."""


@register_jitable
def plan_rests(state: SupervisedState, plan: float) -> bool:
    """Tell whether the plan has rested over the period that ends with it now (rad/s)."""
    return plan == 0.0 and state.feedforward.reference == 0.0


@register_jitable
def may_stick(state: SupervisedState, plan: float) -> bool:
    """Tell whether the plan has rested over the period, or moved so slowly that friction was held that hinders it."""
    if plan_rests(state, plan):
        return True
    if not slides(state.estimator.candidates):  # bent bristles turn friction at once
        return False
    past = state.feedforward
    return is_held(past.friction, past.reference, plan, past.turned)


@register_jitable
def identified_fall(state: SupervisedState) -> float:
    """Return how steeply the identified friction falls with the velocity, N m s/rad."""
    estimate = state.estimator.recursion.estimate
    return float((estimate[STICTION] - estimate[COULOMB]) / state.estimator.candidates.stribeck_velocity)


@register_jitable
def falls_by_itself(block: SupervisedParameters, state: SupervisedState) -> bool:
    """Tell whether the identified friction is known to fall so steeply that the joint sticks and slips by itself."""
    known = state.estimator.levels.learnt >= KNOWN * block.estimator.memory
    return known and identified_fall(state) > RINGS * block.feedback.proportional


@register_jitable
def holding_friction(state: SupervisedState) -> float:
    """Return the friction at breakaway, N m, or the integral if larger: it shows what holds a joint before learning."""
    return max(breakaway(state.estimator), abs(state.feedback.integral))


@register_jitable
def moved_torque(moved: float, torque: float, inputs: Inputs, peak: float, variance: float, duration: float) -> float:
    """Return the largest torque with which the joint has followed its plan, N m, after a period (s).

    A plan that is slow beside its largest speed (rad/s) or the noise (rad^2/s^2) does not count.
    """
    plan = abs(inputs.reference)
    if plan < FAST * peak or plan * plan < CLEAR * variance:
        return moved
    if abs(inputs.reference + inputs.correction - inputs.velocity) > FOLLOWS * plan:
        return moved
    return max(math.exp(-duration / FADES) * moved, abs(torque))


@register_jitable
def watch(
    block: SupervisedParameters, state: SupervisedState, inputs: Inputs, clear: bool, unfit: float, missing: bool
) -> tuple[ObserverState, TrustState, Bridge, float]:
    """Return observer, trust, bridge and the largest torque that has moved the joint (N m) after a period.

    Parameters
    ----------
    block, state, inputs : SupervisedParameters, SupervisedState, Inputs
        Parameters, state before the sample, and its inputs without what is doubted.
    clear : bool
        Whether the period may be learnt from.
    unfit : float
        Share to which the model does not fit (:func:`adaptive_ff.adaptive.supervision.observer_gates.misfit`).
    missing : bool
        Whether the velocity counts as not measured.
    """
    feedback, observer, levels = block.feedback, state.observer, state.estimator.levels
    valid = math.isfinite(inputs.velocity) and not missing
    started = state.feedback.samples > state.feedback.rejected
    gap, moved, lacking = state.seen.gap + inputs.dt, state.moved, state.bridge.lacking
    unforeseen = state.bridge.unforeseen + inputs.reference - state.doubt.foresight.coming
    if started and not state.doubt.doubted and gap < BRIDGED * block.period:
        torque = acting_torque(inputs, asked_torque(feedback, state.feedback), 0.0)
        lacking = bridged_torque(lacking, torque - delayed(observer.fed, feedback.delay), gap, inputs.dt)
        if valid:
            asked = torque - delayed(state.known_torques, feedback.delay)
            # before anything is known, and with adaptation off, a new load is not among what was learnt
            learnt = not may_guess(block.estimator, state.estimator)
            strained = learnt and strains(asked, max(levels.torque, moved))
            moved = moved_torque(moved, asked, inputs, state.trust.peak, likely_variance(observer.noise), gap)
            known = Circumstances(
                held=may_stick(state, inputs.reference),
                peak=state.trust.peak,
                strained=strained,
                falls=falls_by_itself(block, state),
                believed=is_believed(state.drive),
                saturates=state.drive.suspect or state.drive.established,
                friction=holding_friction(state),
                unforeseen=unforeseen,
                learnt=learnt,
            )
            observer = observe(
                block.observer,
                observer,
                feedback,
                lacking,
                inertia_ratio(block, inputs)
                * observed_inertia(block.observer, state.estimator.recursion.estimate[INERTIA], unfit),
                inputs.reference,
                inputs.correction,
                inputs.velocity,
                gap,
                known,
            )
    elif valid:  # the first measurement, or the first after a gap, over which no difference is one of a period
        observer = start_observer(observer, inputs.reference, inputs.velocity)
    # with an outer loop the error is what that asks for as well
    tells = unfit > 0.0 and levels.learnt >= block.estimator.memory and inputs.correction == 0.0
    fed = started and state.command.share == 1.0  # what is not fed tells nothing of it
    # a model that was trusted is not blamed for a change before its cause is known
    blames = state.estimator.alarm.cause != UNDECIDED or state.trust.trust < FULL_TRUST
    trust = advance_trust(
        state.trust,
        feedback,
        block.observer.inertia,
        block.velocity_lag,
        state.standing.left,
        observer.response.velocity,
        unfit * error_beyond_noise(block.observer, observer) if tells else 0.0,
        inputs.reference,
        valid and fed and clear and blames,
        state.standing.wound != 0.0,
        inputs.dt,
    )
    bridge = Bridge(0.0, 0.0) if valid else Bridge(lacking, unforeseen)
    return observer, trust, bridge, moved


@register_jitable
def unobserved_error(
    block: SupervisedParameters, state: SupervisedState, observer: ObserverState, error: float
) -> float:
    """Return the error (rad/s) that there would be without the observer, from the one that there is.

    The lag is tuned by the error, and what the observer takes away would be missing from it. So a share of the error as
    large as the observer's gain is replaced by the predicted one. The prediction leaves out how friction depends on the
    velocity, so it is not used where friction falls more steeply than the feedback can hold.
    """
    share = saturated(2.0 - identified_fall(state) / (STEEP * block.feedback.proportional))
    return error + share * state.observer.gain * (observer.response.velocity - error)
