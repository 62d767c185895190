"""Columns of the friction hypothesis along a recorded or planned motion."""

import numpy as np

from adaptive_ff.friction.columns import (
    Array,
    Curve,
    FrictionState,
    Hypothesis,
    column_count,
    initial_friction_state,
    write_columns,
)
from controllers import compiled


@compiled
def write_along(
    hypothesis: Hypothesis,
    state: FrictionState,
    curve: Curve,
    velocity: Array,
    periods: Array,
    position: Array,
    load: Array,
    regressors: Array,
    columns: Array,
) -> FrictionState:
    """Write the columns of each period of a motion into a row; return the memory after it."""
    for k in range(periods.size):
        state = write_columns(
            hypothesis,
            state,
            curve,
            velocity[k],
            velocity[k + 1],
            periods[k],
            position[k],
            load[k],
            regressors[k],
            columns[k],
        )
    return state


def columns_along(
    hypothesis: Hypothesis,
    curve: Curve,
    velocity: Array,
    period: float | Array,
    position: Array | None = None,
    load: Array | None = None,
) -> Array:
    """Return the mean unit torques between the samples of a motion.

    Parameters
    ----------
    hypothesis, curve : Hypothesis, Curve
        Terms, and what they depend on nonlinearly.
    velocity : ndarray, shape (n + 1,)
        Velocity at the samples, rad/s, linear in between.
    period : float or ndarray, shape (n,)
        Time between the samples, s.
    position : ndarray, shape (n,), optional
        Position in the middle of each period, rad.
    load : ndarray, shape (n,), optional
        Known torque, N m.

    Returns
    -------
    ndarray, shape (n, columns)
        Unit torques, in the order of :mod:`adaptive_ff.friction.columns`.
    """
    count = velocity.size - 1
    columns = np.zeros((count, column_count(hypothesis)))
    write_along(
        hypothesis,
        initial_friction_state(hypothesis),
        curve,
        np.ascontiguousarray(velocity, dtype=float),
        np.full(count, period, dtype=float),
        np.full(count, np.nan) if position is None else np.ascontiguousarray(position, dtype=float),
        np.zeros(count) if load is None else np.ascontiguousarray(load, dtype=float),
        np.zeros((count, hypothesis.regressors)),
        columns,
    )
    return columns
