"""Recursive estimators run over a whole record, one sample after the other."""

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from adaptive_ff.friction.model import ESTIMATED
from adaptive_ff.learning.batch import torque_form_rows
from adaptive_ff.learning.rls import RLSState, update_rls_in_place
from adaptive_ff.learning.torque_form import TorqueForm, initial_signals, regressor_names, settle_signals_in_place
from controllers import compiled

Array = NDArray[np.float64]

VAGUE = 1e6
"""Variance of what the torque form begins with, in squares of the units of its columns."""


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
    form: TorqueForm, gate: tuple[float, float], first: Array, time: Array, velocity: Array, torque: Array
) -> Array:
    """Run recursive least squares over the rows of the torque form that its gate lets through.

    Parameters
    ----------
    form : TorqueForm
        Filters and curve.
    gate : tuple of float
        Speed (rad/s) and hold (s) of the gate.
    first : ndarray, shape (5,)
        First estimate, as vague as ``VAGUE`` says.
    time, velocity, torque : ndarray, shape (n,)
        Time, s, and velocity, rad/s, at the samples, and torque over the period that ends there, N m.

    Returns
    -------
    ndarray, shape (n, 5)
        Estimate after each sample.
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
