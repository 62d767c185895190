"""Prediction of velocity, one sample ahead and on its own, by the series (4) and by the model of Fig. 2."""

import math

import numpy as np

from adaptive_ff.friction.model import ESTIMATED, TorqueModel
from adaptive_ff.learning.batch import series_rows
from adaptive_ff.learning.batch_least_squares import Array
from adaptive_ff.learning.series import SeriesCoefficients, series_regressors
from benchmarks.paper.identification_data import PERIOD, SOLVER_PERIOD, TRUE, Data, joint_of, run_held
from controllers import compiled
from plant import JointParameters, JointState, Stribeck, step_joint

FIRST = 2
"""First sample that (4) can predict."""

FIELDS = len(SeriesCoefficients._fields)
"""Coefficients of (4)."""


def rms(values: Array) -> float:
    """Return the root mean square."""
    return float(np.sqrt(np.mean(values**2)))


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
    course = velocity.copy()
    shape = TRUE.stribeck_velocity, TRUE.stribeck_shape
    run_series(np.ascontiguousarray(coefficients), np.ascontiguousarray(torque), *shape, np.zeros(FIELDS), course)
    return course


def model_one_step(model: TorqueModel, velocity: Array, torque: Array) -> Array:
    """Return the one-step prediction errors of a simulated model, rad/s.

    The model of Fig. 2 runs on the solver of the data; its velocity is set to the measured one at every sample, its
    friction torque is its own. With the true parameters the error is zero.
    """
    identified = np.array([getattr(model, name) for name in ESTIMATED])
    return models_one_step(np.tile(identified, (velocity.size, 1)), velocity, torque)


def models_one_step(models: Array, velocity: Array, torque: Array) -> Array:
    """Return the same for a model that changes: at each sample the one of the sample before predicts.

    Parameters
    ----------
    models : ndarray, shape (n, 5)
        Inertia, Coulomb friction, stiction, viscous coefficient, friction lag after each sample.
    velocity, torque : ndarray, shape (n,)
        Velocity at the samples, rad/s, and torque over the period that ends there, N m.
    """
    errors = np.zeros(velocity.size)
    series = (np.ascontiguousarray(each) for each in (models, torque, velocity))
    run_models(joint_of(TRUE), *series, round(PERIOD / SOLVER_PERIOD), SOLVER_PERIOD, errors)
    return errors


def model_free_run(model: TorqueModel, data: Data) -> Array:
    """Return the velocity (rad/s) of a simulated model under the torque of a record, at its samples."""
    parts = round(PERIOD / SOLVER_PERIOD)
    torque = data.commanded[:-1]
    velocity = np.zeros(torque.size * parts + 1)
    run_held(joint_of(model), JointState(0.0, 0.0, 0.0), torque, parts, SOLVER_PERIOD, velocity)
    return velocity[::parts]


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


def _run_models(
    first: JointParameters,
    models: Array,
    torque: Array,
    velocity: Array,
    parts: int,
    solver_period: float,
    errors: Array,
) -> None:
    state = JointState(velocity[0], 0.0, 0.0)
    stribeck_velocity, stribeck_shape = first.friction.stribeck_velocity, first.friction.stribeck_shape
    for k in range(1, velocity.size):
        inertia, coulomb, viscous, lag = models[k - 1, 0], models[k - 1, 1], models[k - 1, 3], models[k - 1, 4]
        friction = Stribeck(coulomb, max(coulomb, models[k - 1, 2]), viscous, stribeck_velocity, stribeck_shape)
        for _ in range(parts):
            joint = JointParameters(inertia, friction, friction, 0.0, lag)
            state = step_joint(joint, state, torque[k], solver_period)
        errors[k] = velocity[k] - state.velocity
        state = JointState(velocity[k], state.friction_torque, 0.0)


run_series = compiled(_run_series)
run_models = compiled(_run_models)
