"""One sample of the supervised adaptive controller: the adaptive one, an observer beside it and trust in it.

    u = PI(e) + J dr/dt + gamma f_ref + offset + g d

The identification is that of :mod:`adaptive_ff.adaptive.step`. What its feedforward leaves is observed
(:mod:`adaptive_ff.adaptive.supervision.observer`) and fed back while it is louder than the noise; where the friction
fed forward leaves more error than it takes away, less of it is fed (:mod:`adaptive_ff.adaptive.supervision.trust`).
"""

import math

import numpy as np
from numba.extending import register_jitable
from numpy.typing import NDArray

from adaptive_ff.adaptive.adaptive_state import initial_adaptive_state
from adaptive_ff.adaptive.at_rest.held_friction import feedforward_at_rest, friction_shown, initial_held_friction
from adaptive_ff.adaptive.at_rest.outer_loop import initial_outer_loop, note_correction, unseen_error, unseen_velocity
from adaptive_ff.adaptive.at_rest.wound_integral import (
    Standing,
    advance_standing,
    having_left,
    initial_standing,
    wound_up,
)
from adaptive_ff.adaptive.command import fade, limited
from adaptive_ff.adaptive.faults.counts import spurious_torque
from adaptive_ff.adaptive.faults.drive_limit import is_impossible, without_never_given
from adaptive_ff.adaptive.faults.drive_limit_state import initial_drive_limit
from adaptive_ff.adaptive.faults.held_integral import HeldIntegral, hold_integral, initial_held_integral
from adaptive_ff.adaptive.faults.seen_velocity import initial_seen_velocity
from adaptive_ff.adaptive.fed_shares import Shares, fed_shares
from adaptive_ff.adaptive.learning.estimator import estimated_load
from adaptive_ff.adaptive.learning.estimator_state import begin_anew_in_place, load_count
from adaptive_ff.adaptive.learning.lag_tuning import note_friction
from adaptive_ff.adaptive.learning.period import Fed
from adaptive_ff.adaptive.learning.unexplained import breakaway, unexplained
from adaptive_ff.adaptive.sensing import Sensed, sense
from adaptive_ff.adaptive.step import end_period_in_place, learn_and_feed_in_place, write_adaptive
from adaptive_ff.adaptive.supervised_state import Bridge, SupervisedParameters, SupervisedState
from adaptive_ff.adaptive.supervision.balance import Balance, advance_balance, initial_balance
from adaptive_ff.adaptive.supervision.observer import misfit
from adaptive_ff.adaptive.supervision.observer_hand_over import hand_over_to_observer, observe_all, take_up
from adaptive_ff.adaptive.supervision.observer_state import ObserverState, initial_observer
from adaptive_ff.adaptive.supervision.one_way import left_over, note_one_way_in_place
from adaptive_ff.adaptive.supervision.trust import initial_trust, with_friction
from adaptive_ff.adaptive.watching import BRIDGED, plan_rests, unobserved_error, watch
from adaptive_ff.model.bounds import OFFSET
from adaptive_ff.model.feedforward import FeedforwardState, is_plan_at_rest
from controllers import (
    ESTIMATES,
    MONITORS,
    STEPS,
    Inputs,
    Output,
    feed_back,
    hand_over,
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
        initial_standing(),
    )


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
def weigh(block: SupervisedParameters, state: SupervisedState, sensed: Sensed, plan: float) -> Balance:
    """Return the balance of torques after the period that has ended, for the plan as it is measured (rad/s)."""
    if not math.isfinite(sensed.checked.velocity) or sensed.inputs.dt >= BRIDGED * block.period:
        return state.balance  # of a gap no torque is known
    friction = state.trust.frictions[0]
    needed = state.feedback.commands[0] - state.known_torques[0] - (state.model_torques[0] - friction)
    usual = state.estimator.levels.torque
    if abs(needed) > STRONG * usual or abs(state.feedback.integral) > THROWN * usual:
        return state.balance
    return advance_balance(state.balance, plan, needed, friction, sensed.inputs.dt)


@register_jitable
def stand(block: SupervisedParameters, state: SupervisedState, sensed: Sensed) -> Standing:
    """Return what the integral has wound up after the period that has ended."""
    feedback, measured = block.feedback, state.feedback.guard.lost == 0.0
    rests = is_plan_at_rest(state.feedforward, sensed.inputs, feedback.delay)
    held = state.feedback.integral + state.observer.gain * state.observer.disturbance
    fed = state.command.share * state.trust.trust * state.feedforward.friction
    correction = state.outer.correction - unseen_error(state.outer, state.standing.rests)
    asked = feedback.integral * sensed.inputs.dt * correction if measured else 0.0
    torque, friction = held + fed + feedback.proportional * correction, breakaway(state.estimator)
    return advance_standing(state.standing, held, asked, torque, friction, rests, sensed.inputs.dt)


@register_jitable
def setting_out(state: SupervisedState, standing: Standing) -> FeedforwardState:
    """Return the state of the feedforward to go on from: with what was wound up where the plan sets out."""
    past, wound, most = state.feedforward, wound_up(state.standing, standing), breakaway(state.estimator)
    if wound == 0.0:
        return past
    friction = min(max(past.friction + wound, -most), most)
    slip, adhesion = past.slip, past.adhesion
    if state.estimator.candidates.presliding > 0.0 and most > 0.0:
        bent = friction / most
        slip, adhesion = bent * (1.0 - abs(past.adhesion)), bent * abs(past.adhesion)
    return FeedforwardState(friction, past.reference, past.started, slip, adhesion, past.turned)


@register_jitable
def begins_to_observe(state: SupervisedState, share: float, rests: bool) -> bool:
    """Tell whether the feedforward begins to be faded in, to a share, or a plan that has rested sets out."""
    return (state.command.share == 0.0 and share > 0.0) or (state.standing.rests and not rests)


@register_jitable
def share_out(
    block: SupervisedParameters,
    state: SupervisedState,
    sensed: Sensed,
    observer: ObserverState,
    shares: Shares,
    change: float,
    faded: float,
    fed: float,
    wound: float,
    moves: bool,
    begins: bool,
) -> tuple[ObserverState, HeldIntegral, float]:
    """Return observer, what is held of the integral, and what leaves it (N m), so that the torque does not jump.

    ``change`` is that of the torque which is fed forward (N m), ``faded`` what is fed more of the loads while that is
    faded in, ``fed`` all that is, ``wound`` what has become friction of the feedforward; ``moves`` tells whether the
    joint is sure to, ``begins`` whether the observer begins to follow what the integral has held without it.
    """
    integral = unwound_integral(block.feedback, state.feedback, sensed.checked)
    spurious = spurious_torque(
        observer.disturbance, state.observer.disturbance, shares.fine, shares.kicked, breakaway(state.estimator)
    )
    given_up = 0.0
    if begins:
        observer, given_up = observe_all(observer, integral - wound)
    integral += given_up
    observer, taken = take_up(observer, integral, moves)
    observer, leaves = hand_over_to_observer(
        observer, change + faded, shares.gain, fed, integral - wound - taken, spurious
    )
    leaves -= given_up
    passed = (1.0 - shares.gain) * faded  # what the integral holds of a load is true, whatever the drive has given
    leaves = without_never_given(sensed.drive, leaves - passed, state.feedback.integral) + passed + taken + wound
    lost = sensed.guard.lost / block.period
    held, leaves = hold_integral(state.held, state.feedback.integral, leaves, lost, sensed.inputs.dt)
    return observer, held, leaves


@register_jitable
def step_supervised(
    block: SupervisedParameters, state: SupervisedState, inputs: Inputs
) -> tuple[Output, SupervisedState]:
    """Do one sample: observe, learn, feed forward what is trusted and what is observed; then feedback."""
    sensed = sense(block, state, inputs)
    inputs, checked, given, doubt, drive = sensed.inputs, sensed.checked, sensed.given, sensed.doubt, sensed.drive
    clear = doubt.left <= 0.0 and not drive.unproven
    command = fade(state.command, inputs.dt)
    unfit = misfit(state.observer.noise, block.feedback, unexplained(block.estimator, state.estimator))
    observer, trust, bridge, moved = watch(block, state, inputs, clear, unfit, sensed.seen.missing)
    # the plan as the measured velocity would show it; else the feedback brakes where the feedforward accelerates
    shown = inputs.reference + command.share * (observer.reference - inputs.reference)
    error = shown + inputs.correction - inputs.velocity
    balance = weigh(block, state, sensed, shown)
    period = end_period_in_place(block, state, inputs, unobserved_error(block, state, observer, error), clear)
    standing = stand(block, state, sensed)
    begun = setting_out(state, standing)
    set_out = begun.friction - state.feedforward.friction
    fed = learn_and_feed_in_place(block, state, begun, period, inputs)
    left = unexplained(block.estimator, state.estimator)  # again: the candidates have learnt, in place
    changing = left_over(state.observer.noise, state.estimator, left, unfit)
    note_one_way_in_place(block.estimator, state.estimator, fed.estimator, changing * inputs.dt)
    shares = fed_shares(block, state, sensed, observer, trust, balance, fed, unfit, command.share)
    torque = fed_torque(fed, shares.friction)
    change = command.share * (torque - (fed.old_torque - (1.0 - state.trust.trust) * fed.old_friction))
    faded = 0.0
    if command.share != state.command.share:
        faded = (command.share - state.command.share) * standing_load(block, fed)
    torque = given + command.share * (torque - given)  # what was given is not the controller's to fade
    moves, wound = period.sliding > TAKEN_UP * block.hold, command.share * state.trust.trust * set_out
    observer, held, leaves = share_out(
        block,
        state,
        sensed,
        observer,
        shares,
        change,
        faded,
        torque + inputs.feedforward,
        wound,
        moves,
        begins_to_observe(state, command.share, standing.rests),
    )
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
    fed_in_all = with_feedforward(compared, torque + shares.gain * observer.disturbance)
    output, feedback = feed_back(block.feedback, feedback, fed_in_all, sensed.guard)
    tuned, learnt = max(shares.friction, LEAST_TRUST), fed.estimator
    if state.enabled and (drive.anew or is_impossible(state.drive, drive, breakaway(state.estimator))):
        learnt = begin_anew_in_place(block.estimator, learnt)
    return Output(limited(output.torque, block.command.torque_limit), inputs.feedforward + torque), SupervisedState(
        feedback=feedback,
        feedforward=feedforward_at_rest(block, state, fed, inputs),
        measured=period.measured,
        model=period.model,
        estimator=learnt,
        sliding=period.sliding,
        lagged_torque=period.lagged_torque,
        model_torques=remember(state.model_torques, fed.torque),
        known_torques=remember(state.known_torques, inputs.feedforward),
        timing=note_friction(
            fed.timing,
            tuned * begun.friction,
            tuned * fed.feedforward.friction,
            fed.timing.lag,
            block.period,
        ),
        enabled=state.enabled,
        command=command,
        doubt=doubt,
        observer=observer,
        trust=with_friction(trust, shares.friction, fed.friction),
        held=held,
        outer=outer,
        held_friction=held_friction,
        drive=drive,
        seen=sensed.seen,
        balance=balance,
        bridge=bridge,
        moved=moved,
        standing=having_left(standing, set_out),
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
