"""Recursive estimators run over a whole record, one sample after the other."""

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from adaptive_ff.adaptive.learning.estimator import learn_in_place
from adaptive_ff.adaptive.learning.estimator_state import EstimatorParameters, EstimatorState, initial_estimator_state
from adaptive_ff.learning.rls import RLSState, update_rls_in_place
from adaptive_ff.learning.sliding_gate import sliding_time
from adaptive_ff.learning.torque_form import Signals, advance_signals_in_place, initial_signals
from controllers import compiled

Array = NDArray[np.float64]


class Recursion(NamedTuple):
    """What recursive least squares leaves behind.

    Attributes
    ----------
    estimates : ndarray, shape (m, n)
        Estimate after each row.
    errors : ndarray, shape (m,)
        Prediction error before each update, ``e(k)``.
    """

    estimates: Array
    errors: Array


def run_rls(regressors: Array, outputs: Array, forgetting_factor: float, covariance: float) -> Recursion:
    """Run (10)-(13) from zero with ``R0`` a multiple of the identity.

    Parameters
    ----------
    regressors : ndarray, shape (m, n)
        Regressors ``X(k)``.
    outputs : ndarray, shape (m,)
        Outputs ``w(k)``.
    forgetting_factor : float
        ``lambda``.
    covariance : float
        Diagonal of ``R0``.
    """
    size = regressors.shape[1]
    recursion = Recursion(np.zeros(regressors.shape), np.zeros(outputs.size))
    state = RLSState(np.zeros(size), covariance * np.eye(size), np.zeros(size))
    rls_loop(state, regressors, outputs, forgetting_factor, *recursion)
    return recursion


def run_torque_form(
    estimator: EstimatorParameters, gate: tuple[float, float], velocity: Array, torque: Array, period: float
) -> Array:
    """Run the online torque-form estimator with its gate, open loop.

    There is no reference here, so the measured gradient is its own instrument: gated least squares with resetting.

    Parameters
    ----------
    estimator : EstimatorParameters
        The estimator.
    gate : tuple of float
        Speed (rad/s) and hold (s) of the gate.
    velocity, torque : ndarray, shape (n,)
        Velocity at the samples, rad/s, and torque over the period that ends there, N m.
    period : float
        Sampling period, s.

    Returns
    -------
    ndarray, shape (n, 5)
        Estimate after each sample.
    """
    state = initial_estimator_state(estimator)
    estimates = np.tile(estimator.first, (velocity.size, 1))
    signals = initial_signals()._replace(velocity=float(velocity[0]))
    series = np.ascontiguousarray(velocity), np.ascontiguousarray(torque)
    torque_form_loop(estimator, state, signals, gate, *series, period, estimates)
    return estimates


def _rls_loop(
    state: RLSState, regressors: Array, outputs: Array, forgetting_factor: float, estimates: Array, errors: Array
) -> None:
    for k in range(outputs.size):
        errors[k] = update_rls_in_place(state, regressors[k], outputs[k], forgetting_factor)
        row = estimates[k]
        row[:] = state.estimate


def _torque_form_loop(
    estimator: EstimatorParameters,
    state: EstimatorState,
    signals: Signals,
    gate: tuple[float, float],
    velocity: Array,
    torque: Array,
    period: float,
    estimates: Array,
) -> None:
    sliding = -gate[1]
    for k in range(1, velocity.size):
        signals = advance_signals_in_place(estimator.form, signals, torque[k], velocity[k], period)
        sliding = sliding_time(sliding, velocity[k], velocity[k], True, gate[0], period)
        if sliding > gate[1]:
            state = learn_in_place(estimator, state, signals, signals, period)
        row = estimates[k]
        row[:] = state.recursion.estimate


rls_loop = compiled(_rls_loop)
torque_form_loop = compiled(_torque_form_loop)
