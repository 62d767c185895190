"""Identification of the joint and prediction of its velocity, one sample ahead and on its own, by (4) and by Fig. 2."""

import math
from typing import NamedTuple

import numpy as np

from adaptive_ff.friction.model import ESTIMATED, TorqueModel
from adaptive_ff.learning.batch import (
    Identification,
    identify_series,
    identify_torque_form,
    series_rows,
    slides_one_way,
    torque_form_rows,
)
from adaptive_ff.learning.batch_least_squares import Array
from adaptive_ff.learning.rls import RLSState, update_rls_in_place
from adaptive_ff.learning.series import SeriesCoefficients, series_regressors
from adaptive_ff.learning.torque_form import TorqueForm, initial_signals, regressor_names, settle_signals_in_place
from benchmarks.paper.data import CURVE, PERIOD, SOLVER_PERIOD, TRUE, Data, Steps, as_row, predict
from controllers import compiled

FIRST = 2  # first sample that (4) can predict
FIELDS = len(SeriesCoefficients._fields)  # coefficients of (4)
FILTER_POLE = 60.0  # rad/s
SLOWEST = 0.01  # rad/s, speed of the gate
HOLD = 3.0 / FILTER_POLE  # s, hold of the gate


def regression(velocity: Array, torque: Array) -> tuple[Array, Array]:
    """Return regressors and outputs of (4), shapes (n - 2, 6) and (n - 2,), with the true Vs and delta."""
    rows = np.zeros((velocity.size, FIELDS))
    velocity, torque = np.ascontiguousarray(velocity), np.ascontiguousarray(torque)
    series_rows(velocity, torque, TRUE.stribeck_velocity, TRUE.stribeck_shape, rows)
    return rows[FIRST:], velocity[FIRST:]


def series_one_step(coefficients: Array, velocity: Array, torque: Array) -> Array:
    """Return the one-step prediction errors of (4), rad/s; zero for the first two samples."""
    rows, outputs = regression(velocity, torque)
    errors = np.zeros(velocity.size)
    errors[FIRST:] = outputs - rows @ coefficients
    return errors


def series_free_run(coefficients: Array, velocity: Array, torque: Array) -> Array:
    """Return the velocity (rad/s) that (4) produces from its own outputs, started with the first two samples."""
    motion = velocity.copy()
    shape = TRUE.stribeck_velocity, TRUE.stribeck_shape
    run_series(np.ascontiguousarray(coefficients), np.ascontiguousarray(torque), *shape, np.zeros(FIELDS), motion)
    return motion


def models_one_step(models: Array, velocity: Array, torque: Array) -> Array:
    """Return the one-step prediction errors of simulated models, rad/s; of the true one they are zero."""
    return velocity - predict(models, even_steps(velocity.size), torque, velocity, one_step=True)


def model_one_step(model: TorqueModel, velocity: Array, torque: Array) -> Array:
    """Return the same for one model."""
    return models_one_step(as_row(model), velocity, torque)


def model_free_run(model: TorqueModel, data: Data) -> Array:
    """Return the velocity (rad/s) of a simulated model under the torque of a record, at its samples."""
    return predict(as_row(model), even_steps(data.time.size), data.acting, data.velocity, one_step=False)


def even_steps(count: int) -> Steps:
    """Return the solver steps of samples every 10 ms."""
    return np.arange(count, dtype=np.int64) * round(PERIOD / SOLVER_PERIOD)


def model_of(physical: Array) -> TorqueModel:
    """Return the model with five physical parameters."""
    return TorqueModel(*(float(value) for value in physical), TRUE.stribeck_velocity, TRUE.stribeck_shape)


def filtered(data: Data) -> Identification:
    """Identify by the torque form with its gate."""
    return identify_torque_form(
        data.time,
        data.velocity,
        data.acting,
        **CURVE,
        filter_pole=FILTER_POLE,
        slowest=SLOWEST,
        hold=HOLD,
    )


def series(velocity: Array, torque: Array, *, sliding: bool, period: float = PERIOD) -> Identification:
    """Identify by (4), from all samples or from those that slide one way."""
    return identify_series(
        velocity,
        torque,
        period,
        **CURVE,
        use=slides_one_way(velocity, SLOWEST) if sliding else None,
    )


def _run_series(
    coefficients: Array, torque: Array, stribeck_velocity: float, stribeck_shape: float, row: Array, velocity: Array
) -> None:
    for k in range(2, velocity.size):
        series_regressors(
            row, (velocity[k - 1], velocity[k - 2]), (torque[k], torque[k - 1]), stribeck_velocity, stribeck_shape
        )
        total = 0.0
        for i in range(row.size):
            total += row[i] * coefficients[i]
        velocity[k] = total if math.isfinite(total) else math.inf


run_series = compiled(_run_series)
VAGUE = 1e6  # variance of what the torque form begins with, in squares of the units of its columns


class Recursion(NamedTuple):
    """What recursive least squares leaves behind.

    ``estimates`` (m, n): estimate after each row; ``errors`` (m,): prediction error before each update, ``e(k)``.
    """

    estimates: Array
    errors: Array


class Online(NamedTuple):
    """What the recursive estimators did, sample by sample.

    ``series_errors`` and ``form_errors`` are one-step prediction errors of RLS and of the torque form, ``series_free``
    and ``form_free`` errors of the free run of their last estimates, rad/s; ``series`` and ``form``, shape (n, 5), are
    the physical parameters, not a number where coefficients stand for none.
    """

    series_errors: Array
    series_free: Array
    series: Array
    form_errors: Array
    form_free: Array
    form: Array


def run_rls(regressors: Array, outputs: Array, forgetting_factor: float, covariance: float) -> Recursion:
    """Run (10)-(13) from zero with ``R0`` a multiple of the identity.

    ``regressors`` (m, n): regressors ``X(k)``; ``outputs`` (m,): outputs ``w(k)``; ``forgetting_factor``: ``lambda``;
    ``covariance``: diagonal of ``R0``.
    """
    size = regressors.shape[1]
    recursion = Recursion(np.zeros(regressors.shape), np.zeros(outputs.size))
    state = RLSState(np.zeros(size), covariance * np.eye(size), np.zeros(size))
    rls_loop(state, regressors, outputs, forgetting_factor, *recursion)
    return recursion


def run_torque_form(
    form: TorqueForm, gate: tuple[float, float], first: Array, time: Array, velocity: Array, torque: Array
) -> Array:
    """Run recursive least squares over the rows of the torque form that its gate lets through.

    ``form``: filters and curve; ``gate``: speed (rad/s) and hold (s) of the gate; ``first`` (5,): first estimate, as
    vague as ``VAGUE`` says; ``time``, ``velocity``, ``torque`` (n,): time, s, and velocity, rad/s, at the samples, and
    torque over the period that ends there, N m; returned (n, 5): estimate after each sample.
    """
    count, columns = velocity.size, regressor_names(ESTIMATED)
    rows, outputs, used = np.zeros((count, len(columns))), np.zeros(count), np.zeros(count, dtype=np.bool_)
    signals = settle_signals_in_place(form, initial_signals(len(ESTIMATED)), float(velocity[0]))
    series = map(np.ascontiguousarray, (time, velocity, torque))
    torque_form_rows(form, signals, *series, gate, rows, outputs, used)
    begun = np.zeros(len(columns))
    places = [columns.index(name) for name in ESTIMATED]
    begun[places] = first
    found = np.zeros((int(np.count_nonzero(used)), len(columns)))
    state = RLSState(begun.copy(), VAGUE * np.eye(begun.size), np.zeros(begun.size))
    rls_loop(state, rows[used], outputs[used], 1.0, found, np.zeros(len(found)))
    after = np.vstack([begun, found])[np.cumsum(used)]
    return np.ascontiguousarray(after[:, places])


def _rls_loop(
    state: RLSState, regressors: Array, outputs: Array, forgetting_factor: float, estimates: Array, errors: Array
) -> None:
    for k in range(outputs.size):
        errors[k] = update_rls_in_place(state, regressors[k], outputs[k], forgetting_factor)
        row = estimates[k]
        row[:] = state.estimate


rls_loop = compiled(_rls_loop)
