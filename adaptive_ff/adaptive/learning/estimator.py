"""Online estimation of the physical parameters from the torque-form regression.

While the joint slides, the error of the regression corrects the parameters,

    u_f ~ J (w'_f + tau w''_f) + Fc g_f + Fs h_f + sigma w_f - tau u'_f

The form is linear in ``J tau`` beside the parameters themselves; here the parameters alone are estimated, with the
gradient of the form at the present estimate (Gauss-Newton). That removes the one direction in which closed-loop data
hardly determine the columns: ``tau`` times the rate of friction.

Two sets of the same filters run: over the measurements, and over the reference and the torque of the model. The
gradient of the second is free of noise and serves as instrument, so noise in the first does not bias the estimate. An
instrument must resemble what it stands for: where the two gradients disagree on the average (poor tracking, a
model that is still wrong, saturation) the measured gradient takes its place, which is plain least squares, biased
by noise but safe.

An estimate has five parameters, six with the offset, eight where friction differs by direction; what follows the
friction lag enters linearly, a column each. The last parameters may be sizes of known loads, such as gravity (see
``regression.known_loads``); their regressors are known without noise and are their own instruments.
"""

import math

from numba.extending import register_jitable

from adaptive_ff.adaptive.learning.candidate_state import forgetful
from adaptive_ff.adaptive.learning.change_detection import (
    FRICTION,
    JUMP,
    JUMP_WINDOW,
    LEAST_ERROR,
    LOAD,
    LONGEST_WAIT,
    NOTHING,
    UNDECIDED,
    Surprise,
    attribute_change,
    explained_by_friction,
    is_decided,
    note_surprise,
)
from adaptive_ff.adaptive.learning.correction import correct_in_place
from adaptive_ff.adaptive.learning.estimator_state import (
    EstimatorParameters,
    EstimatorState,
    Levels,
    damping_in_use,
    load_count,
    lose_evidence_in_place,
    with_candidates,
    with_levels,
    with_map,
)
from adaptive_ff.adaptive.learning.forgetting import (
    error_to_learn,
    explain_in_place,
    follow_friction_in_place,
    forget_in_place,
    leave_to_loads_in_place,
    scale_estimate_in_place,
)
from adaptive_ff.adaptive.learning.friction_map import follow_map_in_place, learn_map_in_place, taken_over
from adaptive_ff.adaptive.learning.prediction import (
    add_friction,
    predict_torque,
    scale_friction_in_place,
    scale_inertia_in_place,
    write_gradient,
)
from adaptive_ff.estimation.instruments import choose_instrument_in_place
from adaptive_ff.estimation.resetting import (
    prediction_variance_in_place,
    total_of,
    update_resetting_in_place,
)
from adaptive_ff.friction.bounds import (
    FRICTION_LAG,
    INERTIA,
    OFFSET,
    write_ranges,
)
from adaptive_ff.learning.torque_form import DAMPING, FILTER_TORQUE, FILTER_VELOCITY, Signals, write_regressors
from adaptive_ff.regression.known_loads import advance_loads_in_place, load_torque, write_loads
from controllers.arrays import MutableArray

FLOOR = 0.2
"""Floor of the information, times the mean squared prediction error in units of the torque scale squared."""

SMALLEST_FLOOR = 1e-9
"""Floor of the information where there is no prediction error."""

LARGEST_FLOOR = 1e-3
"""Floor of the information where the prediction is far off, as after a change of friction."""

PEAK_MEMORIES = 10.0
"""Time constant with which peaks fade, and time learnt from which they do, in memories."""

PEAK_FACTOR = 2.0
"""Friction, and an error of its prediction, is assumed to be at most this many times the largest torque seen."""

SPEED_FACTOR = 3.0
"""A joint this many times faster than its reference ever was is a fault of the measurement; nothing is learnt then."""


@register_jitable
def follow_loads_in_place(
    estimator: EstimatorParameters, state: EstimatorState, position: float, duration: float, first: bool
) -> None:
    """Advance the filters of known loads by one sample; see ``advance_loads_in_place``."""
    angle = position / estimator.gear_ratio
    advance_loads_in_place(state.loads, estimator.waves, state.regressors, estimator.form.pole, angle, duration, first)


@register_jitable
def estimated_load(estimator: EstimatorParameters, state: EstimatorState, turn: float) -> float:
    """Return the torque (N m) that carries the known loads, waves as they are after a change of position (rad)."""
    return load_torque(state.recursion.estimate, state.loads, estimator.waves, turn / estimator.gear_ratio)


@register_jitable
def follow_friction_map(
    estimator: EstimatorParameters, state: EstimatorState, position: float, known: float, duration: float, first: bool
) -> EstimatorState:
    """Return the state after one sample of position (rad) and of the torque known from elsewhere (N m)."""
    if state.friction_map.coefficients.size == 0:
        return state
    load = known + estimated_load(estimator, state, 0.0)
    angle = position / estimator.gear_ratio
    return with_map(state, follow_map_in_place(state.friction_map, estimator.form.pole, angle, load, duration, first))


@register_jitable
def learn_friction_map(
    estimator: EstimatorParameters, state: EstimatorState, measured: Signals, duration: float
) -> EstimatorState:
    """Return the state with the map corrected at a sample from which the estimator has just learnt."""
    if state.friction_map.coefficients.size == 0:
        return state
    estimate, row = state.recursion.estimate, state.scratch.row
    torque = measured.filters[FILTER_TORQUE, 0] - damping_in_use(state) * measured.bent[DAMPING, 0]
    error, friction = torque - predict_torque(estimate, row), add_friction(0.0, estimate, row)
    parameters, old = estimator.friction_map, state.friction_map
    new = learn_map_in_place(parameters, old, friction, error, duration, estimator.memory)
    scale_estimate_in_place(estimate, taken_over(parameters, old, new), load_count(estimator))
    return with_map(state, new)


@register_jitable
def faded(levels: Levels, keep: float, memory: float) -> Levels:
    """Return the levels with peaks that fade, once there is so much behind them that the present can speak for itself.

    One false value must not widen for ever what is thought possible; in the first memories peaks are all there is.

    Parameters
    ----------
    levels : Levels
        The levels.
    keep : float
        What a memory keeps over a period.
    memory : float
        The memory, s.
    """
    if levels.learnt <= PEAK_MEMORIES * memory:
        return levels
    fading = 1.0 - (1.0 - keep) / PEAK_MEMORIES
    return levels._replace(torque=fading * levels.torque, speed=fading * levels.speed)


@register_jitable
def recover_in_place(estimator: EstimatorParameters, state: EstimatorState) -> bool:
    """Begin anew with the estimate as it is, where the gain is not finite; tell whether that was so.

    The information matrix is positive definite by construction, but rounding, or a state from elsewhere, can spoil it;
    without this all estimates would be lost.
    """
    recursion = state.recursion
    if math.isfinite(total_of(recursion.gain)):
        return False
    for i in range(recursion.gain.size):
        recursion.gain[i] = 0.0
    lose_evidence_in_place(estimator, state)
    return True


@register_jitable
def is_change(
    estimator: EstimatorParameters, state: EstimatorState, surprise: Surprise, usual: float, window: float
) -> bool:
    """Return whether errors are larger than usual, and than what the prediction is in doubt by.

    A motion that was never seen is predicted by what is assumed: the first one the other way shows for the first time
    how offset and Coulomb friction share the torque. What it teaches is not a change. Of ``x' M^-1 x``, with what ``x``
    holds of friction and loads, the short window makes as many variances of the error as it is long in memories; one is
    what its own samples would tell.

    Parameters
    ----------
    estimator : EstimatorParameters
        The estimator.
    state : EstimatorState
        Its state, with the gradient of this sample.
    surprise : Surprise
        Means over the short window.
    usual : float
        What a factor on friction explains of the usual errors at most.
    window : float
        Length of the short window, s.
    """
    explained = explained_by_friction(surprise)
    if not explained > usual:
        return False
    if state.alarm.cause != NOTHING:
        return True
    gradient, asked = state.scratch.measured_gradient, state.recursion.instrument  # which the update writes anew
    for i in range(gradient.size):
        asked[i] = gradient[i]
    asked[INERTIA] = 0.0
    asked[FRICTION_LAG] = 0.0
    doubt = prediction_variance_in_place(state.recursion) * window / estimator.memory
    return explained > usual * (1.0 + doubt)


@register_jitable
def write_equation(
    estimator: EstimatorParameters,
    state: EstimatorState,
    signals: Signals,
    ratio: float,
    factor: float,
    gradient: MutableArray,
) -> float:
    """Write the row of the regression that signals make, and its gradient; return the torque that it explains, N m.

    Parameters
    ----------
    estimator, state, ratio, factor : EstimatorParameters, EstimatorState, float, float
        As of :func:`learn_in_place`; the row is that of the scratch.
    signals : Signals
        Filters over the measurements, or over the reference and the torque of the model.
    gradient : ndarray, shape (n,)
        Written: gradient of the predicted torque.
    """
    row = state.scratch.row
    torque = write_regressors(estimator.form, signals, row)
    write_loads(state.loads, row)
    scale_inertia_in_place(row, ratio)
    scale_friction_in_place(row, factor, load_count(estimator))
    write_gradient(estimator, state.recursion.estimate, row, gradient)
    return torque


@register_jitable
def learn_in_place(
    estimator: EstimatorParameters,
    state: EstimatorState,
    measured: Signals,
    model: Signals,
    duration: float,
    ratio: float = 1.0,
    factor: float = 1.0,
) -> EstimatorState:
    """Take one sample of sliding motion into account.

    Parameters
    ----------
    estimator : EstimatorParameters
        The estimator.
    state : EstimatorState
        Its state.
    measured : Signals
        Filters over the measurements.
    model : Signals
        Filters over the reference and the torque of the model.
    duration : float
        Time since the last sample, s.
    ratio : float, optional
        Inertia in the present configuration over that of the first estimate; what is estimated is the latter.
    factor : float, optional
        Friction at the present position and load over that which is estimated.

    Returns
    -------
    EstimatorState
        The new state; it shares the arrays of the old one, which are changed in place.
    """
    recursion, scratch, levels = state.recursion, state.scratch, state.levels
    estimate, row, gradient = recursion.estimate, scratch.row, scratch.measured_gradient
    write_equation(estimator, state, model, ratio, factor, scratch.model_gradient)
    torque = write_equation(estimator, state, measured, ratio, factor, gradient)
    keep = math.exp(-duration / estimator.memory)
    levels = faded(levels, keep, estimator.memory)
    speed = max(levels.speed, abs(model.filters[FILTER_VELOCITY, 0]))
    if not abs(measured.filters[FILTER_VELOCITY, 0]) < SPEED_FACTOR * speed:
        return with_levels(state, levels._replace(speed=speed), state.surprise, state.alarm)
    largest_torque, learnt = max(levels.torque, abs(torque)), levels.learnt + duration
    peak = PEAK_FACTOR * largest_torque
    largest = peak / estimator.torque_scale
    floor = min(FLOOR * levels.squared_error + SMALLEST_FLOOR, LARGEST_FLOOR)  # of the errors before this one
    torque -= damping_in_use(state) * measured.bent[DAMPING, 0]
    error = (torque - predict_torque(estimate, row)) / estimator.torque_scale
    error = min(max(error, -largest), largest)
    friction = add_friction(0.0, estimate, row) / estimator.torque_scale
    window = JUMP_WINDOW / estimator.form.pole
    surprise = note_surprise(state.surprise, friction, error, duration, window)
    squared, usual, followed = error * error, JUMP * (levels.squared_error + LEAST_ERROR), False
    noticed = learnt > estimator.memory and is_change(estimator, state, surprise, usual, window)
    alarm = state.alarm
    if estimate.size - load_count(estimator) > OFFSET:
        longest = LONGEST_WAIT * estimator.memory
        alarm = attribute_change(alarm, noticed, surprise, friction, window, longest, duration)
        followed = noticed and is_decided(alarm)
        if followed and alarm.cause == FRICTION:
            follow_friction_in_place(estimate, alarm.product, surprise.friction_squared, load_count(estimator))
            error = (torque - predict_torque(estimate, row)) / estimator.torque_scale
            squared = error * error
        may_notice = learnt > estimator.memory
        error = error_to_learn(alarm, followed, surprise, error, usual / JUMP if may_notice else math.inf)
        if alarm.cause == UNDECIDED:  # the observer carries it; the levels must not get used to it
            levels = Levels(levels.squared_error, largest_torque, speed, learnt, levels.stuck)
            return with_levels(state, levels, surprise, alarm)
    fading = 1.0 if alarm.cause == LOAD else keep  # the transients of a load say nothing of the usual motion
    choose_instrument_in_place(state.agreement, scratch.model_gradient, gradient, fading, floor, recursion.instrument)
    if noticed:
        # what a change explains must not count as usual, or the next change would not be noticed
        squared = min(squared, usual)
        forget_in_place(estimator, recursion, surprise.friction_squared, alarm, window / estimator.memory)
        state = with_candidates(state, forgetful(state.candidates))
    squared_error = keep * levels.squared_error + (1.0 - keep) * squared
    levels = Levels(squared_error, largest_torque, speed, learnt, levels.stuck)
    update_resetting_in_place(recursion, floor, keep, error)
    if recover_in_place(estimator, state):
        return with_levels(state, levels, surprise, alarm)
    if alarm.cause == LOAD:
        leave_to_loads_in_place(recursion.gain, load_count(estimator))
        if followed:
            explain_in_place(recursion.gain, gradient, surprise.error)
            surprise = Surprise(0.0, surprise.friction_squared, 0.0)
    write_ranges(estimator.ranges, peak, speed, scratch.ranges, load_count(estimator))
    correct_in_place(estimator.scale, estimate, recursion.gain, recursion.factor, scratch.ranges, gradient)
    return with_levels(state, levels, surprise, alarm)
