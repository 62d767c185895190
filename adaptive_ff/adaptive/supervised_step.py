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
from adaptive_ff.adaptive.at_rest.outer_loop import (
    OuterLoop,
    initial_outer_loop,
    note_correction,
    unseen_error,
    unseen_velocity,
)
from adaptive_ff.adaptive.at_rest.wound_integral import (
    having_left,
    initial_standing,
)
from adaptive_ff.adaptive.command import fade, limited
from adaptive_ff.adaptive.faults.drive_limit import is_impossible
from adaptive_ff.adaptive.faults.drive_limit_state import initial_drive_limit
from adaptive_ff.adaptive.faults.held_integral import initial_held_integral
from adaptive_ff.adaptive.faults.seen_velocity import initial_seen_velocity
from adaptive_ff.adaptive.fed_shares import fed_shares
from adaptive_ff.adaptive.learning.estimator_state import begin_anew_in_place
from adaptive_ff.adaptive.learning.lag_tuning import note_friction
from adaptive_ff.adaptive.learning.unexplained import breakaway, unexplained
from adaptive_ff.adaptive.sensing import Sensed, sense
from adaptive_ff.adaptive.setting_out import setting_out, stand
from adaptive_ff.adaptive.share_out import passing_torque, share_out
from adaptive_ff.adaptive.step import end_period_in_place, learn_and_feed_in_place, write_adaptive
from adaptive_ff.adaptive.supervised_state import Bridge, SupervisedParameters, SupervisedState
from adaptive_ff.adaptive.supervision.balance import Balance, advance_balance, initial_balance
from adaptive_ff.adaptive.supervision.observer_gates import misfit
from adaptive_ff.adaptive.supervision.observer_state import initial_observer
from adaptive_ff.adaptive.supervision.one_way import left_over, note_one_way_in_place
from adaptive_ff.adaptive.supervision.trust import initial_trust, with_friction
from adaptive_ff.adaptive.watching import BRIDGED, plan_rests, unobserved_error, watch
from controllers import (
    ESTIMATES,
    MONITORS,
    STEPS,
    Inputs,
    Output,
    PIState,
    feed_back,
    hand_over,
    remember,
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
def close_loop(
    block: SupervisedParameters,
    state: SupervisedState,
    sensed: Sensed,
    outer: OuterLoop,
    shown: float,
    fed: float,
    leaves: float,
    rests: bool,
) -> tuple[Output, PIState]:
    """Return the output, and the state of the PI loop after its sample.

    Parameters
    ----------
    block, state, sensed : SupervisedParameters, SupervisedState, Sensed
        Parameters, state before the sample, and the sample.
    outer : OuterLoop
        What an outer loop can tell at rest, after the sample.
    shown : float
        Plan as the measured velocity would show it, rad/s.
    fed : float
        Torque of feedforward and observer, N m.
    leaves : float
        Torque that leaves the integral, N m.
    rests : bool
        Whether the plan has rested over the period.
    """
    inputs, checked = sensed.inputs, sensed.checked
    if math.isfinite(inputs.velocity):
        leaves += block.feedback.integral * inputs.dt * unseen_error(outer, rests)
    feedback = hand_over(block.feedback, state.feedback, leaves)
    unseen = unseen_velocity(state.outer, inputs.correction, inputs.velocity, rests)
    # a plan that leaps may be true: the feedback follows it, what is fed and learnt does not
    compared = with_reference(checked, (checked.reference if sensed.doubt.doubted else shown) + unseen)
    fed_in_all = with_feedforward(compared, fed)
    return feed_back(block.feedback, feedback, fed_in_all, sensed.guard)


@register_jitable
def step_supervised(
    block: SupervisedParameters, state: SupervisedState, inputs: Inputs
) -> tuple[Output, SupervisedState]:
    """Do one sample: observe, learn, feed forward what is trusted and what is observed; then feedback."""
    sensed = sense(block, state, inputs)
    inputs, doubt, drive = sensed.inputs, sensed.doubt, sensed.drive
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
    torque, passing = passing_torque(block, state, sensed, period, fed, shares, standing, command.share, set_out)
    observer, held, leaves = share_out(block, state, sensed, observer, shares, passing)
    rests = plan_rests(state, sensed.checked.reference)
    outer = note_correction(state.outer, inputs.correction, inputs.velocity, rests, inputs.dt)
    held_friction = state.held_friction
    if state.enabled and math.isfinite(inputs.velocity):
        held_friction = friction_shown(block, state, inputs, rests)
    output, feedback = close_loop(
        block, state, sensed, outer, shown, torque + shares.gain * observer.disturbance, leaves, rests
    )
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
