"""Regressors of a whole record, sample after sample, by the kernels of the online estimators."""

import numpy as np
from numpy.typing import NDArray

from adaptive_ff.learning.series import series_regressors
from adaptive_ff.learning.sliding_gate import sliding_time
from adaptive_ff.learning.torque_form import Signals, TorqueForm, advance_signals_in_place, write_regressors
from controllers import compiled

Array = NDArray[np.float64]
Mask = NDArray[np.bool_]


def _series_rows(velocity: Array, torque: Array, stribeck_velocity: float, stribeck_shape: float, rows: Array) -> None:
    """Write the regressors of (4) of each sample, from the third on, into the rows."""
    for k in range(2, velocity.size):
        series_regressors(
            rows[k], (velocity[k - 1], velocity[k - 2]), (torque[k], torque[k - 1]), stribeck_velocity, stribeck_shape
        )


def _torque_form_rows(
    form: TorqueForm,
    signals: Signals,
    time: Array,
    velocity: Array,
    torque: Array,
    gate: tuple[float, float],
    rows: Array,
    outputs: Array,
    used: Mask,
) -> None:
    """Write regressors, outputs and whether the gate is open; the gate is its speed (rad/s) and hold (s).

    There is no reference to slide along. A reversal so fast that both samples around it are above the speed of the gate
    does not close it: the joint cannot have stuck for long, and the filters split it where it happens.
    """
    sliding = -gate[1]
    for k in range(1, time.size):
        duration = time[k] - time[k - 1]
        signals = advance_signals_in_place(form, signals, torque[k], velocity[k], duration)
        sliding = sliding_time(sliding, velocity[k], velocity[k], True, gate[0], duration)
        outputs[k] = write_regressors(form, signals, rows[k])
        used[k] = sliding > gate[1]


series_rows = compiled(_series_rows)
torque_form_rows = compiled(_torque_form_rows)
