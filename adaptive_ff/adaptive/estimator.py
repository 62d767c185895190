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
friction lag enters linearly, a column each.
"""

import math
from typing import NamedTuple

import numpy as np
from numba.extending import register_jitable
from numpy.typing import NDArray

from adaptive_ff.adaptive.change_detection import JUMP, JUMP_WINDOW, LEAST_ERROR, forget_friction, note_surprise
from adaptive_ff.estimation.instruments import gradients_agree
from adaptive_ff.estimation.resetting import move_parameter, update_resetting
from adaptive_ff.model.bounds import (
    COULOMB,
    FRICTION_LAG,
    INERTIA,
    OFFSET,
    STICTION,
    confine,
    limit_friction,
    possible_ranges,
)
from adaptive_ff.regression.torque_form import TORQUE, VELOCITY, Signals, TorqueForm, write_regressors

FLOOR = 0.2
"""Floor of the information, times the mean squared prediction error in units of the torque scale squared."""

SMALLEST_FLOOR = 1e-9
"""Floor of the information where there is no prediction error."""

LARGEST_FLOOR = 1e-3
"""Floor of the information where the prediction is far off, as after a change of friction."""

PRIOR = 6e-4
"""Information at the start, in the same units."""

LAG_PRIOR = 20.0
"""The same of the friction lag, times that of the others: it is believed until reversals show it."""

GUESS = 0.9
"""Share of the largest friction torque seen that Coulomb friction and stiction are guessed to be."""

PEAK_FACTOR = 2.0
"""Friction, and an error of its prediction, is believed to be at most this many times the largest torque seen."""

SPEED_FACTOR = 3.0
"""A joint this many times faster than its reference ever was is a fault of the measurement; nothing is learnt then."""


class Workspace(NamedTuple):
    """Arrays that a sample's computation is done in, so that no step allocates memory.

    They hold nothing in between, but for the ranges of what does not depend on the data.
    """

    row: NDArray[np.float64]
    gradient: NDArray[np.float64]
    instrument: NDArray[np.float64]
    factor: NDArray[np.float64]
    ranges: NDArray[np.float64]


def make_workspace(inertia: float, largest_lag: float, size: int) -> Workspace:
    """Return the arrays for one estimator of so many parameters; see ``possible_ranges``."""
    return Workspace(
        np.zeros(size + 1),
        np.zeros(size),
        np.zeros(size),
        np.zeros((size, size)),
        possible_ranges(inertia, largest_lag, size),
    )


class EstimatorParameters(NamedTuple):
    """Parameters of the estimator.

    Attributes
    ----------
    form : TorqueForm
        The regression.
    first : ndarray, shape (n,)
        First estimate: inertia, Coulomb friction, stiction, viscous coefficient, friction lag, and the offset and what
        differs by direction where they are estimated.
    scale : ndarray, shape (n,)
        Unit in which each parameter is estimated, of its expected size.
    torque_scale : float
        Unit of torque, N m.
    memory : float
        Memory, s of sliding motion.
    work : Workspace
        Scratch, of its own for each estimator.
    """

    form: TorqueForm
    first: NDArray[np.float64]
    scale: NDArray[np.float64]
    torque_scale: float
    memory: float
    work: Workspace


class EstimatorState(NamedTuple):
    """State of the estimator; its arrays are changed in place.

    Attributes
    ----------
    estimate : ndarray, shape (n,)
        The parameters, in the order of the first estimate.
    information : ndarray, shape (n, n)
        Information matrix of the scaled parameters.
    agreement : ndarray, shape (n, 2)
        Fading means of ``z^2`` and ``z x`` of each scaled gradient.
    levels : ndarray, shape (4,)
        Mean squared scaled prediction error; largest filtered torque (N m) and reference speed (rad/s) so far; for how
        long there has been something to learn from, s.
    surprise : ndarray, shape (2,)
        Means over a short window of prediction error times predicted friction and of the latter squared, scaled.
    """

    estimate: NDArray[np.float64]
    information: NDArray[np.float64]
    agreement: NDArray[np.float64]
    levels: NDArray[np.float64]
    surprise: NDArray[np.float64]


def initial_estimator_state(estimator: EstimatorParameters) -> EstimatorState:
    """Return the state of an estimator that has seen nothing."""
    size = estimator.first.size
    information = PRIOR * np.eye(size)
    information[FRICTION_LAG, FRICTION_LAG] *= LAG_PRIOR
    return EstimatorState(estimator.first.copy(), information, np.zeros((size, 2)), np.zeros(4), np.zeros(2))


@register_jitable(forceinline=True)
def has_learnt(state: EstimatorState) -> bool:
    """Tell whether the estimator has learnt from any sample."""
    return state.levels[3] > 0.0  # type: ignore[no-any-return]


@register_jitable(forceinline=True)
def add_friction(torque: float, estimate: NDArray[np.float64], row: NDArray[np.float64]) -> float:
    """Add to a torque (N m) the filtered friction, without the offset, that an estimate predicts from regressors."""
    for i in range(COULOMB, FRICTION_LAG):
        torque += estimate[i] * row[i + 1]
    for i in range(OFFSET + 1, estimate.size):
        torque += estimate[i] * row[i + 1]
    return torque


@register_jitable(forceinline=True)
def predict_torque(estimate: NDArray[np.float64], row: NDArray[np.float64]) -> float:
    """Return the filtered torque (N m) that an estimate predicts from a row of regressors."""
    lag = estimate[FRICTION_LAG]
    prediction = add_friction(estimate[INERTIA] * (row[1] + lag * row[0]) + lag * row[5], estimate, row)
    if estimate.size > OFFSET:
        prediction += estimate[OFFSET] * row[OFFSET + 1]
    return prediction


@register_jitable(forceinline=True)
def write_gradient(
    estimator: EstimatorParameters,
    estimate: NDArray[np.float64],
    row: NDArray[np.float64],
    gradient: NDArray[np.float64],
) -> None:
    """Write the scaled gradient of the predicted torque by the parameters."""
    for i in range(gradient.size):
        gradient[i] = row[i + 1]
    gradient[INERTIA] += estimate[FRICTION_LAG] * row[0]
    gradient[FRICTION_LAG] += estimate[INERTIA] * row[0]
    for i in range(gradient.size):
        gradient[i] *= estimator.scale[i] / estimator.torque_scale


@register_jitable(forceinline=True)
def guess_friction(estimator: EstimatorParameters, state: EstimatorState, measured: Signals, model: Signals) -> None:
    """Guess Coulomb friction and stiction from the largest friction torque so far, before there is anything to learn.

    Whether the joint sticks or slides, the torque that does not accelerate it is friction; at rest it is less than the
    stiction. So the guess is on the safe side, and better than none at the first reversals.
    """
    estimate, levels = state.estimate, state.levels
    levels[2] = max(levels[2], abs(model.filters[VELOCITY, 0]))
    if not abs(measured.filters[VELOCITY, 0]) < SPEED_FACTOR * levels[2]:
        return
    torque = measured.filters[TORQUE, 0]
    levels[1] = max(levels[1], abs(torque))
    friction = torque - estimate[INERTIA] * measured.filters[VELOCITY, 1]
    guess = min(GUESS * math.copysign(friction, friction * model.velocity), PEAK_FACTOR * levels[1])
    if guess > estimate[COULOMB]:
        estimate[COULOMB] = guess
        estimate[STICTION] = guess


@register_jitable(forceinline=True)
def learn(
    estimator: EstimatorParameters, state: EstimatorState, measured: Signals, model: Signals, duration: float
) -> None:
    """Take one sample of sliding motion into account.

    Parameters
    ----------
    estimator : EstimatorParameters
        The estimator.
    state : EstimatorState
        Its state; changed in place.
    measured : Signals
        Filters over the measurements.
    model : Signals
        Filters over the reference and the torque of the model.
    duration : float
        Time since the last sample, s.
    """
    estimate = state.estimate
    row, gradient, instrument = estimator.work.row, estimator.work.gradient, estimator.work.instrument
    factor, ranges = estimator.work.factor, estimator.work.ranges
    write_regressors(estimator.form, model, row)
    write_gradient(estimator, estimate, row, instrument)
    torque = write_regressors(estimator.form, measured, row)
    write_gradient(estimator, estimate, row, gradient)
    levels = state.levels
    levels[2] = max(levels[2], abs(model.filters[VELOCITY, 0]))
    if not abs(measured.filters[VELOCITY, 0]) < SPEED_FACTOR * levels[2]:
        return
    levels[1] = max(levels[1], abs(torque))
    levels[3] += duration
    peak = PEAK_FACTOR * levels[1]
    largest = peak / estimator.torque_scale
    keep = math.exp(-duration / estimator.memory)
    floor = min(FLOOR * levels[0] + SMALLEST_FLOOR, LARGEST_FLOOR)  # of the errors before this one
    if not gradients_agree(state.agreement, instrument, gradient, keep, floor):
        for i in range(gradient.size):
            instrument[i] = gradient[i]
    error = (torque - predict_torque(estimate, row)) / estimator.torque_scale
    error = min(max(error, -largest), largest)
    friction = add_friction(0.0, estimate, row) / estimator.torque_scale
    window = JUMP_WINDOW / estimator.form.pole
    explained = note_surprise(state.surprise, friction, error, duration, window)
    squared, usual = error * error, JUMP * (levels[0] + LEAST_ERROR)
    if levels[3] > estimator.memory and explained > usual:
        squared = min(squared, usual)  # what a change of friction explains does not make errors usual
        known, share = state.surprise[1], window / estimator.memory
        forget_friction(state.information, estimate, estimator.scale, known, estimator.torque_scale, share, factor)
    levels[0] = keep * levels[0] + (1.0 - keep) * squared
    update_resetting(state.information, floor, keep, instrument, error, gradient, factor)
    limit_friction(ranges, peak, levels[2])
    correct(estimator.scale, estimate, gradient, factor, ranges, instrument)


@register_jitable(forceinline=True)
def correct(
    scale: NDArray[np.float64],
    estimate: NDArray[np.float64],
    correction: NDArray[np.float64],
    factor: NDArray[np.float64],
    ranges: NDArray[np.float64],
    work: NDArray[np.float64],
) -> None:
    """Add a scaled correction to the estimate and keep it possible.

    A parameter that would leave its range is moved back with the others adjusted; what still lies outside after
    that is cut off.
    """
    for i in range(estimate.size):
        value = estimate[i] + correction[i] * scale[i]
        possible = min(max(value, ranges[i, 0]), ranges[i, 1])
        if possible != value:
            move_parameter(factor, i, (possible - value) / scale[i], correction, work)
    for i in range(estimate.size):
        estimate[i] += correction[i] * scale[i]
    confine(estimate, ranges)
