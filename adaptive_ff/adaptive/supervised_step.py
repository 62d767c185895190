"""One sample of the supervised adaptive controller: the adaptive one, an observer beside it and trust in it.

    u = PI(e) + J dr/dt + gamma f_ref + offset + g d

The identification is that of :mod:`adaptive_ff.adaptive.step`. What its feedforward leaves is observed
(:mod:`adaptive_ff.adaptive.observer`) and fed back while it is louder than the noise; where the friction fed forward
leaves more error than it takes away, less of it is fed (:mod:`adaptive_ff.adaptive.trust`).
"""

import math
from typing import NamedTuple

import numpy as np
from numba.extending import register_jitable
from numpy.typing import NDArray

from adaptive_ff.adaptive.adaptive_state import initial_adaptive_state
from adaptive_ff.adaptive.balance import Balance, advance_balance, balanced_share, initial_balance
from adaptive_ff.adaptive.candidate_state import slides
from adaptive_ff.adaptive.change_detection import UNDECIDED, shows_cause
from adaptive_ff.adaptive.command import CommandParameters, CommandState, fade, limited, machine_inputs
from adaptive_ff.adaptive.counts import fine_share, first_counts, kicked_share, spurious_torque
from adaptive_ff.adaptive.doubt import Doubt, advance_doubt, believed_plan, undoubted_inputs
from adaptive_ff.adaptive.drive_limit import (
    DriveLimit,
    answered_share,
    believed_share,
    initial_drive_limit,
    is_believed,
    is_impossible,
    watch_drive,
    without_never_given,
)
from adaptive_ff.adaptive.estimator_state import EstimatorParameters, EstimatorState, begin_anew_in_place, load_count
from adaptive_ff.adaptive.held_friction import HeldFriction, feedforward_at_rest, friction_shown, initial_held_friction
from adaptive_ff.adaptive.held_integral import HeldIntegral, hold_integral, initial_held_integral
from adaptive_ff.adaptive.lag_tuning import TimingState, note_friction
from adaptive_ff.adaptive.noise_level import noise_known
from adaptive_ff.adaptive.observer import (
    bridged_torque,
    error_beyond_noise,
    hand_over_to_observer,
    misfit,
    observe,
    observed_inertia,
    observer_gain,
    saturated,
    strains,
    take_up,
)
from adaptive_ff.adaptive.observer_state import (
    ObserverParameters,
    ObserverState,
    initial_observer,
    start_observer,
)
from adaptive_ff.adaptive.one_way import loosen_offset_in_place
from adaptive_ff.adaptive.outer_loop import (
    OuterLoop,
    initial_outer_loop,
    note_correction,
    unseen_error,
    unseen_velocity,
)
from adaptive_ff.adaptive.period import Fed
from adaptive_ff.adaptive.seen_velocity import (
    SeenVelocity,
    advance_seen_velocity,
    initial_seen_velocity,
    seen_inputs,
)
from adaptive_ff.adaptive.step import (
    end_period_in_place,
    given_inertia_torque,
    learn_and_feed_in_place,
    write_adaptive,
)
from adaptive_ff.adaptive.trust import TrustState, advance_trust, caution, initial_trust, soft_bound, with_friction
from adaptive_ff.adaptive.unexplained import breakaway, missing_share, unexplained
from adaptive_ff.model.bounds import COULOMB, INERTIA, OFFSET, STICTION
from adaptive_ff.model.feedforward import FeedforwardState
from adaptive_ff.model.turning import is_held
from adaptive_ff.regression.torque_form import Signals
from controllers import (
    ESTIMATES,
    MONITORS,
    STEPS,
    Inputs,
    Output,
    PIParameters,
    PIState,
    acting_torque,
    asked_torque,
    delayed,
    feed_back,
    hand_over,
    plausible_inputs,
    remember,
    unwound_integral,
    with_feedforward,
    with_reference,
)

LEAST_TRUST = 0.02
"""Trust at which the lag is tuned at least: a slope of zero would end the tuning for good."""


STEEP = 5.0
"""Fall of friction with the velocity, in gains of the feedback, from which the predicted error begins to mislead; at
twice that, it is not used."""

RINGS = 2.0
"""Fall, in gains of the feedback, from which on a joint sticks and slips by itself, whatever the drive's lag ...

With 1 a drive that lags by 50 ms keeps an observer that it cannot have.
"""

KNOWN = 0.5
"""... once so many memories of the estimator have been learnt.

With a whole one, one of 400 drawn joints has a window of 1.5 times PI's.
"""

FULL_TRUST = 0.95
"""Trust from which on a model is blamed for the errors of a change only when the cause of the change is known."""


BRIDGED = 10.5
"""Longest time without a measurement that the observer bridges, in periods."""

STRONG = 100.0
"""Torque over the largest one so far that answers to no motion of the joint: it tells nothing of its friction."""

TAKEN_UP = 0.25
"""Share of the time for which a joint must slide until learning begins, after which it surely moves."""


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
    lacking : float
        Mean torque beyond what was fed forward while no velocity is believed, N m.
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
    lacking: float


def initial_supervised_state(block: SupervisedParameters) -> SupervisedState:
    """Return the state of a controller that knows nothing but the assumed inertia."""
    return SupervisedState(
        *initial_adaptive_state(block),
        initial_observer(block.feedback),
        initial_trust(block.feedback),
        initial_held_integral(),
        initial_outer_loop(),
        initial_held_friction(),
        initial_drive_limit(model_given=block.estimator.given),
        initial_seen_velocity(),
        initial_balance(),
        0.0,
    )


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
    """Return the friction at breakaway, N m: before it is learnt the integral tells how much holds a joint."""
    return max(breakaway(state.estimator), abs(state.feedback.integral))


@register_jitable
def watch(
    block: SupervisedParameters, state: SupervisedState, inputs: Inputs, clear: bool, unfit: float, missing: bool
) -> tuple[ObserverState, TrustState, float]:
    """Return observer, trust and what is lacking after the period that has ended, with a model unfit to a share.

    ``clear`` tells whether it may be learnt from, ``missing`` whether the velocity is taken for not measured.
    """
    feedback, observer, levels = block.feedback, state.observer, state.estimator.levels
    valid = math.isfinite(inputs.velocity) and not missing
    started = state.feedback.samples > state.feedback.rejected
    gap, lacking = state.seen.gap + inputs.dt, state.lacking
    if started and not state.doubt.doubted and gap < BRIDGED * block.period:
        torque = acting_torque(inputs, asked_torque(feedback, state.feedback), 0.0)
        lacking = bridged_torque(lacking, torque - delayed(observer.fed, feedback.delay), gap, inputs.dt)
        if valid:
            # with adaptation off a new load is not among what moved the joint
            tried = state.enabled and levels.learnt >= block.estimator.memory
            strained = tried and strains(torque - delayed(state.known_torques, feedback.delay), levels.torque)
            observer = observe(
                block.observer,
                observer,
                feedback,
                lacking,
                observed_inertia(block.observer, state.estimator.recursion.estimate[INERTIA], unfit),
                inputs.reference,
                inputs.correction,
                inputs.velocity,
                may_stick(state, inputs.reference),
                gap,
                state.trust.peak,
                strained,
                falls_by_itself(block, state),
                is_believed(state.drive),
                holding_friction(state),
            )
    elif valid:  # the first measurement, or the first after a gap, over which no difference is one of a period
        observer = start_observer(observer, inputs.reference, inputs.velocity)
    # with an outer loop the error is what that asks for as well
    tells = unfit > 0.0 and levels.learnt >= block.estimator.memory and inputs.correction == 0.0
    fed = started and state.command.share == 1.0  # what is not fed tells nothing of it
    # a model that was trusted is not blamed for a change before its cause is known
    known = state.estimator.alarm.cause != UNDECIDED or state.trust.trust < FULL_TRUST
    trust = advance_trust(
        state.trust,
        feedback,
        block.observer.inertia,
        block.velocity_lag,
        observer.response.velocity,
        unfit * error_beyond_noise(block.observer, observer) if tells else 0.0,
        inputs.reference,
        valid and fed and clear and known,
        inputs.dt,
    )
    return observer, trust, 0.0 if valid else lacking


@register_jitable
def unobserved_error(
    block: SupervisedParameters, state: SupervisedState, observer: ObserverState, error: float
) -> float:
    """Return the error (rad/s) that there would be without the observer, from the one that there is.

    What the observer takes away would else be missing where the lag is tuned by the error: a share of the error as
    large as its gain is replaced by the predicted one. That leaves out how friction depends on the velocity, and
    is no guide where friction falls more steeply than the feedback holds it.
    """
    share = saturated(2.0 - identified_fall(state) / (STEEP * block.feedback.proportional))
    return error + share * state.observer.gain * (observer.response.velocity - error)


@register_jitable
def left_over(state: SupervisedState, squared: float, unfit: float) -> float:
    """Return the share to which what a model leaves, squared (N^2 m^2), unfit to a share, is a load, or friction."""
    if not noise_known(state.observer.noise):
        return 0.0
    return min(unfit, missing_share(state.estimator, squared))


@register_jitable
def note_one_way_in_place(
    estimator: EstimatorParameters, old: EstimatorState, new: EstimatorState, duration: float
) -> None:
    """Forget the offset over a time (s) where something has been learnt on motion one way."""
    if new.recursion.estimate.size - load_count(estimator) > OFFSET:
        learnt = new.levels.learnt > max(old.levels.learnt, estimator.memory)
        if learnt and new.friction_map.share == 0.0:
            loosen_offset_in_place(new.recursion.information, duration, new.scratch.model_gradient)


@register_jitable
def fed_torque(fed: Fed, trust: float) -> float:
    """Return the torque that is fed forward when the friction is trusted to a share, N m."""
    return fed.torque - (1.0 - trust) * fed.friction


@register_jitable
def least_bound(block: SupervisedParameters, state: SupervisedState, trust: TrustState, drive: DriveLimit) -> float:
    """Return the bound on trust and on the observer's gain: of slow motion, a soft loop, and a drive."""
    time, friction = state.feedback.samples * block.period, breakaway(state.estimator)
    bound = caution(trust, block.slowest, state.estimator.levels.learnt, block.estimator.memory, time)
    bound = min(bound, soft_bound(trust, block.feedback.proportional, friction, time))
    return min(bound, believed_share(drive, friction))


@register_jitable
def weigh(state: SupervisedState, plan: float, duration: float) -> Balance:
    """Return the balance of torques after a period (s), for the plan as it is measured (rad/s)."""
    friction = state.trust.frictions[0]
    needed = state.feedback.commands[0] - state.known_torques[0] - (state.model_torques[0] - friction)
    if abs(needed) > STRONG * state.estimator.levels.torque:
        return state.balance
    return advance_balance(state.balance, plan, needed, friction, duration)


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
def step_supervised(
    block: SupervisedParameters, state: SupervisedState, inputs: Inputs
) -> tuple[Output, SupervisedState]:
    """Do one sample: observe, learn, feed forward what is trusted and what is observed; then feedback."""
    inputs, guard = plausible_inputs(block.feedback, state.feedback, inputs)
    given = given_inertia_torque(block, state, inputs)
    inputs = machine_inputs(block.command, block.feedback, state.feedback, inputs, given)
    doubt, checked = advance_doubt(block, state, inputs, guard), inputs
    drive, inputs = watch_drive(block, state, inputs)
    inputs = undoubted_inputs(doubt, believed_plan(block, state, doubt, inputs))
    seen = advance_seen_velocity(block, state, inputs)
    inputs = seen_inputs(seen, inputs)
    clear = doubt.left <= 0.0 and not drive.unproven
    command = fade(state.command, inputs.dt)
    unfit = misfit(state.observer.noise, block.feedback, unexplained(block.estimator, state.estimator))
    observer, trust, lacking = watch(block, state, inputs, clear, unfit, seen.missing)
    # the plan as the measured velocity would show it; else the feedback brakes where the feedforward accelerates
    shown = inputs.reference + command.share * (observer.reference - inputs.reference)
    error = shown + inputs.correction - inputs.velocity
    balance = weigh(state, shown, inputs.dt) if math.isfinite(checked.velocity) else state.balance
    period = end_period_in_place(block, state, inputs, unobserved_error(block, state, observer, error), clear)
    fed = learn_and_feed_in_place(block, state, period, inputs)
    left = unexplained(block.estimator, state.estimator)  # again: the candidates have learnt, in place
    forgets = left_over(state, left, unfit)
    note_one_way_in_place(block.estimator, state.estimator, fed.estimator, forgets * inputs.dt)
    estimator = state.estimator  # of before: what the gates compare belongs to the period that has ended
    bound = least_bound(block, state, trust, drive)
    share = min(trust.trust, min(bound, answered_share(drive, fed.friction)))
    kicked = kicked_by_counts(block, state, observer, trust.peak, seen)
    share = min(share, balanced_share(balance, breakaway(estimator), kicked))
    inertia = fed.estimator.recursion.estimate[INERTIA]
    gain = observer_gain(block.observer, observer, block.feedback, inertia, unfit)
    if slides(fed.estimator.candidates) and shows_cause(fed.estimator.alarm, inputs.reference):
        gain = 1.0  # something is missed now, whichever the cause is
    fine = sensed_share(block, state, trust.peak, seen)
    gain *= fine * (1.0 - kicked)
    gain = command.share * observer.effect.share * min(gain, bound) * answered_share(drive, observer.disturbance)
    torque = fed_torque(fed, share)
    change = command.share * (torque - (fed.old_torque - (1.0 - state.trust.trust) * fed.old_friction))
    torque = given + command.share * (torque - given)  # what was given is not the controller's to fade
    moves = period.sliding > TAKEN_UP * block.hold
    integral = unwound_integral(block.feedback, state.feedback, checked)
    spurious = spurious_torque(observer.disturbance, state.observer.disturbance, fine, kicked, breakaway(estimator))
    observer, taken = take_up(observer, integral, moves)
    fed_forward, integral = torque + inputs.feedforward, integral - taken
    observer, leaves = hand_over_to_observer(observer, change, gain, fed_forward, integral, spurious)
    leaves = without_never_given(drive, leaves, state.feedback.integral) + taken
    lost = guard.lost / block.period
    held, leaves = hold_integral(state.held, state.feedback.integral, leaves, lost, inputs.dt)
    rests = plan_rests(state, checked.reference)
    outer = note_correction(state.outer, inputs.correction, inputs.velocity, rests, inputs.dt)
    held_friction = state.held_friction
    if math.isfinite(inputs.velocity):
        if state.enabled:
            held_friction = friction_shown(block, state, inputs, rests)
        leaves += block.feedback.integral * inputs.dt * unseen_error(outer, rests)
    feedback = hand_over(block.feedback, state.feedback, leaves)
    unseen = unseen_velocity(state.outer, inputs.correction, inputs.velocity, rests)
    # a plan that leaps may be true: the feedback follows it, what is fed and learnt does not
    compared = with_reference(checked, (checked.reference if doubt.leapt else shown) + unseen)
    fed_in_all = with_feedforward(compared, torque + gain * observer.disturbance)
    output, feedback = feed_back(block.feedback, feedback, fed_in_all, guard)
    tuned, learnt = max(share, LEAST_TRUST), fed.estimator
    if state.enabled and (drive.anew or is_impossible(state.drive, drive, breakaway(estimator))):
        learnt = begin_anew_in_place(block.estimator, learnt)
    return Output(limited(output.torque, block.command.torque_limit), inputs.feedforward + torque), SupervisedState(
        feedback,
        feedforward_at_rest(block, state, fed, inputs),
        period.measured,
        period.model,
        learnt,
        period.sliding,
        period.lagged_torque,
        remember(state.model_torques, fed.torque),
        remember(state.known_torques, inputs.feedforward),
        note_friction(
            fed.timing,
            tuned * state.feedforward.friction,
            tuned * fed.feedforward.friction,
            fed.timing.lag,
            block.period,
        ),
        state.enabled,
        command,
        doubt,
        observer,
        with_friction(trust, share, fed.friction),
        held,
        outer,
        held_friction,
        drive,
        seen,
        balance,
        lacking,
    )


@register_jitable
def write_supervised(block: SupervisedParameters, state: SupervisedState, row: NDArray[np.float64]) -> None:
    """Write the physical estimates into a row."""
    write_adaptive(block, state, row)


@register_jitable
def write_supervision(block: SupervisedParameters, state: SupervisedState, row: NDArray[np.float64]) -> None:
    """Write trust, observer gain and observed torque that is fed back (N m) into a row."""
    row[0] = state.trust.trust
    row[1] = state.observer.gain
    row[2] = state.observer.gain * state.observer.disturbance


STEPS[SupervisedParameters] = step_supervised
ESTIMATES[SupervisedParameters] = write_supervised
MONITORS[SupervisedParameters] = write_supervision
