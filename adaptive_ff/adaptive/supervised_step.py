"""One sample of the supervised adaptive controller: the adaptive one, an observer beside it and trust in it.

    u = PI(e) + J dr/dt + gamma f_ref + offset + g d

The identification is that of :mod:`adaptive_ff.adaptive.step`. What its feedforward leaves is observed
(:mod:`adaptive_ff.adaptive.observer`) and fed back while it is louder than the noise; where the friction fed forward
leaves more error than it takes away, less of it is fed (:mod:`adaptive_ff.adaptive.trust`).
"""

import math

import numpy as np
from numba.extending import register_jitable
from numpy.typing import NDArray

from adaptive_ff.adaptive.adaptive_state import initial_adaptive_state
from adaptive_ff.adaptive.balance import Balance, advance_balance, balanced_share, initial_balance
from adaptive_ff.adaptive.candidate_state import slides
from adaptive_ff.adaptive.change_detection import shows_cause
from adaptive_ff.adaptive.command import fade, limited, machine_inputs
from adaptive_ff.adaptive.counts import fine_share, first_counts, kicked_share, spurious_torque
from adaptive_ff.adaptive.doubt import advance_doubt, believed_plan, undoubted_inputs
from adaptive_ff.adaptive.drive_limit import (
    DriveLimit,
    answered_share,
    believed_share,
    initial_drive_limit,
    is_impossible,
    watch_drive,
    without_never_given,
)
from adaptive_ff.adaptive.estimator_state import EstimatorParameters, EstimatorState, begin_anew_in_place, load_count
from adaptive_ff.adaptive.held_friction import feedforward_at_rest, friction_shown, initial_held_friction
from adaptive_ff.adaptive.held_integral import hold_integral, initial_held_integral
from adaptive_ff.adaptive.lag_tuning import note_friction
from adaptive_ff.adaptive.noise_level import noise_known
from adaptive_ff.adaptive.observer import hand_over_to_observer, helping_share, misfit, observer_gain, take_up
from adaptive_ff.adaptive.observer_state import ObserverState, initial_observer
from adaptive_ff.adaptive.one_way import loosen_offset_in_place
from adaptive_ff.adaptive.outer_loop import initial_outer_loop, note_correction, unseen_error, unseen_velocity
from adaptive_ff.adaptive.period import Fed
from adaptive_ff.adaptive.seen_velocity import SeenVelocity, advance_seen_velocity, initial_seen_velocity, seen_inputs
from adaptive_ff.adaptive.step import (
    end_period_in_place,
    given_inertia_torque,
    learn_and_feed_in_place,
    write_adaptive,
)
from adaptive_ff.adaptive.supervised_state import Bridge, SupervisedParameters, SupervisedState
from adaptive_ff.adaptive.trust import TrustState, caution, initial_trust, soft_bound, with_friction
from adaptive_ff.adaptive.unexplained import breakaway, missing_share, unexplained
from adaptive_ff.adaptive.watching import BRIDGED, holding_friction, plan_rests, unobserved_error, watch
from adaptive_ff.model.bounds import INERTIA, OFFSET
from controllers import (
    ESTIMATES,
    MONITORS,
    STEPS,
    Inputs,
    Output,
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


STRONG = 100.0
"""Torque over the largest one so far that answers to no motion of the joint: it tells nothing of its friction."""

THROWN = 10.0
"""Integral over that torque, from which on the feedback brings a joint back that something has thrown off its plan.

What that takes over a second may be more than the friction of the whole memory of the balance.
"""

TAKEN_UP = 0.25
"""Share of the time for which a joint must slide until learning begins, after which it surely moves."""


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
        Bridge(0.0, 0.0),
        0.0,
    )


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
    usual = state.estimator.levels.torque
    if abs(needed) > STRONG * usual or abs(state.feedback.integral) > THROWN * usual:
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
    observer, trust, bridge, moved = watch(block, state, inputs, clear, unfit, seen.missing)
    # the plan as the measured velocity would show it; else the feedback brakes where the feedforward accelerates
    shown = inputs.reference + command.share * (observer.reference - inputs.reference)
    error = shown + inputs.correction - inputs.velocity
    weighs = math.isfinite(checked.velocity) and inputs.dt < BRIDGED * block.period  # of a gap no torque is known
    balance = weigh(state, shown, inputs.dt) if weighs else state.balance
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
    gain *= helping_share(observer, holding_friction(state))
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
    compared = with_reference(checked, (checked.reference if doubt.doubted else shown) + unseen)
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
        bridge,
        moved,
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
