"""One sample of the adaptive controller: parameters, state and kernels.

At every sample the filters of the torque-form regression advance over the period that has ended; while the joint
slides, the estimator corrects its physical parameters; the model that they make is fed forward for the period
that begins, with a friction lag that the tracking error tunes; the PI loop does the rest.
"""

import math

import numpy as np
from numba.extending import register_jitable
from numpy.typing import NDArray

from adaptive_ff.adaptive.adaptive_state import AdaptiveParameters, AdaptiveState
from adaptive_ff.adaptive.command import (
    fade,
    inertia_torque,
    limited,
    machine_inputs,
)
from adaptive_ff.adaptive.faults.doubt import advance_doubt, believed_plan, undoubted_inputs
from adaptive_ff.adaptive.learning.candidates import (
    compare_candidates_in_place,
    follow_candidates_in_place,
    settle_candidates_in_place,
)
from adaptive_ff.adaptive.learning.change_detection import LOAD, UNDECIDED
from adaptive_ff.adaptive.learning.estimator import (
    SPEED_FACTOR,
    estimated_load,
    follow_friction_map,
    follow_loads_in_place,
    learn_friction_map,
    learn_in_place,
)
from adaptive_ff.adaptive.learning.estimator_state import (
    EstimatorState,
    carries_loads,
    form_in_use,
    lag_is_hidden,
    load_count,
    may_guess,
    with_candidates,
)
from adaptive_ff.adaptive.learning.fed_model import (
    Block,
    bent_shares,
    gate_speed,
    identified_model,
    inertia_ratio,
    present_model,
)
from adaptive_ff.adaptive.learning.friction_guess import guess_friction_in_place
from adaptive_ff.adaptive.learning.friction_map import filtered_factor
from adaptive_ff.adaptive.learning.lag_tuning import (
    FIRST,
    YOUNG,
    TimingState,
    advance_response,
    best_lag,
    drop_stale_evidence,
    empty_evidence,
    lag_torque,
    lateness,
    learn_timing,
    note_friction,
    with_evidence,
)
from adaptive_ff.adaptive.learning.period import Fed, Period
from adaptive_ff.adaptive.learning.unexplained import missing_share, unexplained
from adaptive_ff.friction.bounds import (
    FRICTION_LAG,
    INERTIA,
    write_model,
)
from adaptive_ff.friction.feedforward import FeedforwardState, coming_plan, exchange_model, feedforward_parts
from adaptive_ff.friction.model import TorqueModel
from adaptive_ff.friction.turning import turning_of
from adaptive_ff.learning.sliding_gate import sliding_time
from adaptive_ff.learning.torque_form import (
    advance_signals_in_place,
    settle_signals_in_place,
)
from controllers import (
    ESTIMATES,
    STEPS,
    Inputs,
    Output,
    acting_torque,
    asked_torque,
    delayed,
    feed_back,
    hand_over,
    plausible_inputs,
    remember,
    with_feedforward,
)

LOADS_FIRST = 1.0
"""Time learnt before candidates are compared where loads are estimated, in memories: what is left of a load that is
not known yet looks like another curve."""

GUESS_HOLD = 0.5
"""Time of sliding before friction is guessed where there are further regressors, in holds of the gate.

With gravity alone, and a weight of 1.1 times the stiction from the start, the first 5 s are as good without waiting
(3.80 for 3.71 mrad/s), and with a smaller weight or none much better (2.2 for 3.1).
"""


@register_jitable
def step_model(
    block: Block,
    model: TorqueModel,
    estimator: EstimatorState,
    state: FeedforwardState,
    inputs: Inputs,
) -> tuple[float, float, FeedforwardState]:
    """Return the torque (N m) that a model and the estimated loads need, the friction in it, and the new state.

    Loads are those at the position that the velocity shows, moved on along the plan to the middle of the period.
    """
    delay, inertia = block.feedback.delay, math.nan
    if math.isfinite(inputs.inertia):
        inertia = model.inertia * inertia_ratio(block, inputs)
    # where much less inertia is identified than is assumed, something else is taken for it: friction is not held longer
    least = max(model.inertia, float(block.estimator.first[INERTIA]))
    unfit = missing_share(estimator, unexplained(block.estimator, estimator))
    turning = turning_of(model, least, block.feedback.proportional, block.period, unfit)
    torque, friction, new = feedforward_parts(
        model, state, inputs, block.period, delay, inertia, turning.speed, turning.path
    )
    turn = ((delay + 0.5) * block.period + block.velocity_lag) * inputs.reference
    return torque + estimated_load(block.estimator, estimator, turn), friction, new


@register_jitable
def tune_lag(block: Block, state: Block, inputs: Inputs, error: float) -> TimingState:
    """Return the state of the lag's tuning after the period that has ended and left a tracking error (rad/s)."""
    timing, estimator, levels = state.timing, block.estimator, state.estimator.levels
    timing = advance_response(timing, block.feedback, estimator.first[INERTIA], block.velocity_lag, inputs.dt)
    possible = abs(error) < SPEED_FACTOR * levels.speed  # else a fault of the measurement
    if state.enabled and possible and levels.learnt > FIRST * estimator.memory:
        return learn_timing(timing, error, levels.learnt, estimator.memory, inputs.dt)
    return timing


@register_jitable
def end_period_in_place(block: Block, state: Block, inputs: Inputs, error: float, clear: bool) -> Period:
    """Advance the filters, in place, and what else follows the signals over the period that has ended.

    ``error`` is the tracking error by which the lag is tuned, rad/s; ``clear`` tells that it may be learnt from.
    """
    valid, delay = math.isfinite(inputs.velocity), block.feedback.delay
    velocity = inputs.velocity if valid else state.measured.velocity
    form, candidates = form_in_use(block.estimator, state.estimator), state.estimator.candidates
    measured, model = state.measured, state.model
    if state.feedback.samples == 0:
        measured = settle_signals_in_place(form, measured, velocity)
        model = settle_signals_in_place(form, model, inputs.reference)
        settle_candidates_in_place(block.estimator, candidates, inputs.reference)
    acting = acting_torque(inputs, asked_torque(block.feedback, state.feedback), delayed(state.known_torques, delay))
    lagged_torque = state.lagged_torque
    if block.velocity_lag > 0.0:  # what the velocity shows now is what the torque did a while ago
        acting, lagged_torque = lag_torque(block.velocity_lag, lagged_torque, acting, inputs.dt)
    measured = advance_signals_in_place(form, measured, acting, velocity, inputs.dt)
    shown = inputs.position - block.velocity_lag * inputs.reference  # where what the velocity shows has happened
    follow_loads_in_place(block.estimator, state.estimator, shown, inputs.dt, state.feedback.samples == 0)
    follow_candidates_in_place(block.estimator, candidates, model.velocity, inputs.reference, inputs.dt, state.enabled)
    model = advance_signals_in_place(form, model, delayed(state.model_torques, delay), inputs.reference, inputs.dt)
    slowest, steady = gate_speed(block, state.estimator), valid and clear
    sliding = sliding_time(state.sliding, velocity, inputs.reference, steady, slowest, inputs.dt)
    timing = state.timing
    if block.tunes_lag and state.command.share == 1.0 and clear:
        timing = tune_lag(block, state, inputs, error)
    return Period(measured, model, lagged_torque, sliding, timing, clear)


@register_jitable
def choose_candidate_in_place(
    block: Block, estimator: EstimatorState, period: Period, duration: float, ratio: float, factor: float
) -> EstimatorState:
    """Compare the candidates for what friction is assumed to be, at a sample that the estimator has learnt from."""
    if estimator.candidates.errors.size > 0:
        if estimator.loads.shape[0] > 0:
            young = estimator.levels.learnt < LOADS_FIRST * block.estimator.memory
            if young and carries_loads(block.estimator, estimator):
                return estimator
        candidates = compare_candidates_in_place(
            block.estimator, estimator, period.measured, period.model, duration, ratio, factor
        )
        return with_candidates(estimator, candidates)
    return estimator


@register_jitable
def learn_curve_in_place(
    block: Block,
    state: Block,
    estimator: EstimatorState,
    period: Period,
    duration: float,
    ratio: float,
    factor: float,
) -> EstimatorState:
    """Learn what the regression is not linear in, map and candidates, where the estimator has just learnt."""
    cause = estimator.alarm.cause
    # the transients of a load say nothing of the curve
    if estimator.levels.learnt > state.estimator.levels.learnt and cause != UNDECIDED and cause != LOAD:
        mapped = learn_friction_map(block.estimator, estimator, period.measured, duration)
        return choose_candidate_in_place(block, mapped, period, duration, ratio, factor)
    return estimator


@register_jitable
def learn_and_feed_in_place(block: Block, state: Block, begun: FeedforwardState, period: Period, inputs: Inputs) -> Fed:
    """Learn, or guess before there is anything to learn, and feed forward for the period that begins.

    ``begun`` is the state of the feedforward to go on from.

    With a computation delay the period that the feedforward is for begins later, and the torques that belong to the one
    that ends were computed earlier.
    """
    reference, delay = inputs.reference, block.feedback.delay
    first, timing = state.feedback.samples == 0, period.timing
    followed = follow_friction_map(
        block.estimator, state.estimator, inputs.position, inputs.feedforward, inputs.dt, first
    )
    # the model copies numbers out of the estimate, so it stays the old one when the estimate changes in place
    old = present_model(block, followed, timing.lag, reference)
    before, old_friction, feedforward = step_model(block, old, followed, begun, inputs)
    learns, ratio = period.sliding > block.hold, inertia_ratio(block, inputs)
    # at rest a load looks like friction: where other joints hang on this one, only motion tells of friction
    moves = block.estimator.regressors == 0 or period.sliding > GUESS_HOLD * block.hold
    guesses = moves and may_guess(block.estimator, followed)
    if not (state.enabled and period.clear and (learns or (math.isfinite(inputs.velocity) and guesses))):
        return Fed(before, old_friction, before, old_friction, feedforward, followed, timing)
    start, _ = coming_plan(begun, inputs, delay)
    slip, adhesion = begun.slip, begun.adhesion
    if learns:
        factor = filtered_factor(block.estimator.friction_map, followed.friction_map)
        learnt = learn_in_place(block.estimator, followed, period.measured, period.model, inputs.dt, ratio, factor)
        estimator = learn_curve_in_place(block, state, learnt, period, inputs.dt, ratio, factor)
        if estimator.candidates.chosen != state.estimator.candidates.chosen:  # errors so far are of another model
            since = estimator.recursion.estimate[FRICTION_LAG]
            timing = with_evidence(timing, empty_evidence(since), since, timing.seen)
            slip, adhesion = bent_shares(estimator.candidates)
    else:
        estimator = guess_friction_in_place(followed, period.measured, period.model, inputs.dt, ratio)
    identified, largest = estimator.recursion.estimate[FRICTION_LAG], block.estimator.ranges[FRICTION_LAG, 1]
    young = estimator.levels.learnt < YOUNG * block.estimator.memory
    timing = drop_stale_evidence(timing, identified, block.period, young)
    hidden = lag_is_hidden(block.estimator, estimator, block.period)
    lag = best_lag(timing, identified, largest, block.period, hidden=hidden)
    if block.tunes_lag:
        lag = min(lag + lateness(timing, identified), largest)
    timing = with_evidence(timing, timing.evidence, lag, timing.seen)
    new = present_model(block, estimator, timing.lag, reference)
    moved = exchange_model(begun, old, new, start, slip, adhesion)
    torque, friction, feedforward = step_model(block, new, estimator, moved, inputs)
    return Fed(before, old_friction, torque, friction, feedforward, estimator, timing)


@register_jitable
def given_inertia_torque(block: Block, state: Block, inputs: Inputs) -> float:
    """Return the torque (N m) of the inertia along the plan that is part of the torque known from elsewhere."""
    if not block.command.includes_inertia:
        return 0.0
    first, delay = block.estimator.first[INERTIA], block.feedback.delay
    return inertia_torque(first, state.feedforward, inputs, block.period, delay)


@register_jitable
def step_adaptive(block: AdaptiveParameters, state: AdaptiveState, inputs: Inputs) -> tuple[Output, AdaptiveState]:
    """Do one sample: learn from the period that ends, feed forward for the one that begins, then feedback.

    The integral holds what the feedforward did not give so far. Without the hand-over both would give it for a while.
    """
    inputs, guard = plausible_inputs(block.feedback, state.feedback, inputs)
    given = given_inertia_torque(block, state, inputs)
    inputs = machine_inputs(block.command, block.feedback, state.feedback, inputs, given)
    doubt, checked = advance_doubt(block, state, inputs, guard), inputs
    inputs = undoubted_inputs(doubt, believed_plan(block, state, doubt, inputs))
    command = fade(state.command, inputs.dt)
    error = inputs.reference + inputs.correction - inputs.velocity
    period = end_period_in_place(block, state, inputs, error, doubt.left <= 0.0)
    fed = learn_and_feed_in_place(block, state, state.feedforward, period, inputs)
    feedback = hand_over(block.feedback, state.feedback, command.share * (fed.torque - fed.old_torque))
    torque = given + command.share * (fed.torque - given)  # what was given is not the controller's to fade
    output, feedback = feed_back(block.feedback, feedback, with_feedforward(checked, torque), guard)
    return Output(limited(output.torque, block.command.torque_limit), output.feedforward), AdaptiveState(
        feedback=feedback,
        feedforward=fed.feedforward,
        measured=period.measured,
        model=period.model,
        estimator=fed.estimator,
        sliding=period.sliding,
        lagged_torque=period.lagged_torque,
        model_torques=remember(state.model_torques, fed.torque),
        known_torques=remember(state.known_torques, inputs.feedforward),
        timing=note_friction(
            fed.timing, state.feedforward.friction, fed.feedforward.friction, fed.timing.lag, block.period
        ),
        enabled=state.enabled,
        command=command,
        doubt=doubt,
    )


@register_jitable
def write_adaptive(block: Block, state: Block, row: NDArray[np.float64]) -> None:
    """Write the physical estimates into a row."""
    loads = load_count(block.estimator)
    bends = row.size - block.estimator.first.size  # Stribeck velocity and presliding distance, where they are tried
    write_model(identified_model(block, state), row, loads + bends)
    for i in range(row.size - loads - bends, row.size - bends):
        row[i] = state.estimator.recursion.estimate[i]
    if bends > 0:
        row[row.size - bends] = state.estimator.candidates.stribeck_velocity
    if bends > 1:
        row[row.size - 1] = state.estimator.candidates.presliding


STEPS[AdaptiveParameters] = step_adaptive
ESTIMATES[AdaptiveParameters] = write_adaptive
