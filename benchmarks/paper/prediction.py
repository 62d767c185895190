"""Prediction of velocity, one sample ahead and on its own, by the series (4) and by the model of Fig. 2."""

import math

import numpy as np

from adaptive_ff.batch import Array, series_rows
from adaptive_ff.model import TorqueModel
from adaptive_ff.series import SeriesCoefficients, series_regressors
from benchmarks.paper.identification_data import PERIOD, SOLVER_PERIOD, TRUE, joint_of
from controllers import compiled
from plant import JointParameters, JointState, step_joint

FIRST = 2
"""First sample that (4) can predict."""


def rms(values: Array) -> float:
    """Return the root mean square."""
    return float(np.sqrt(np.mean(values**2)))


def regression(velocity: Array, torque: Array) -> tuple[Array, Array]:
    """Return regressors and outputs of (4), shapes (n - 2, 6) and (n - 2,), with the true Vs and delta."""
    rows = np.zeros((velocity.size, len(SeriesCoefficients._fields)))
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
    run_series(np.ascontiguousarray(coefficients), torque, TRUE.stribeck_velocity, TRUE.stribeck_shape, course)
    return course


def model_one_step(model: TorqueModel, velocity: Array, torque: Array) -> Array:
    """Return the one-step prediction errors of a simulated model, rad/s.

    The model of Fig. 2 runs on the solver of the data; its velocity is set to the measured one at every sample, its
    friction torque is its own. With the true parameters the error is zero.
    """
    errors = np.zeros(velocity.size)
    run_model(joint_of(model), torque, velocity, round(PERIOD / SOLVER_PERIOD), SOLVER_PERIOD, errors)
    return errors


def _run_series(
    coefficients: Array, torque: Array, stribeck_velocity: float, stribeck_shape: float, velocity: Array
) -> None:
    row = np.empty(6)
    for k in range(2, velocity.size):
        series_regressors(
            row, (velocity[k - 1], velocity[k - 2]), (torque[k], torque[k - 1]), stribeck_velocity, stribeck_shape
        )
        total = 0.0
        for i in range(6):
            total += row[i] * coefficients[i]
        velocity[k] = total if math.isfinite(total) else math.inf


def _run_model(
    joint: JointParameters, torque: Array, velocity: Array, parts: int, solver_period: float, errors: Array
) -> None:
    state = JointState(velocity[0], 0.0)
    for k in range(1, velocity.size):
        for _ in range(parts):
            state = step_joint(joint, state, torque[k], solver_period)
        errors[k] = velocity[k] - state.velocity
        state = JointState(velocity[k], state.friction_torque)


run_series = compiled(_run_series)
run_model = compiled(_run_model)
