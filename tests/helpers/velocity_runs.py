"""Velocity estimators run over a series of measurements."""

import numpy as np

import controllers

PERIOD = 0.001
RESOLUTION = 2.0 * np.pi / 20_000

ON_POSITIONS = {
    "difference": controllers.difference_velocity(PERIOD),
    "low-pass": controllers.low_pass_velocity(40.0, PERIOD),
    "Kalman": controllers.kalman_velocity(
        *controllers.kalman_velocity_gains(RESOLUTION / np.sqrt(12.0), 200.0, PERIOD), PERIOD
    ),
}
ESTIMATORS = {"direct": controllers.direct_velocity(PERIOD), **ON_POSITIONS}


def run_plain(block, state, measured, dt, velocities):
    for k in range(measured.size):
        velocities[k], state = controllers.estimate_velocity(block, state, measured[k], dt[k])
    return state


run_compiled = controllers.compiled(run_plain)


def estimate(block, measured, *, dt=PERIOD, velocity=0.0, run=run_plain):
    """Velocity at each sample, and the state at the end; ``dt`` is the time before each sample."""
    measured = np.asarray(measured, dtype=float)
    found = np.zeros(measured.size)
    first = measured[np.isfinite(measured)][0]
    state = controllers.initial_velocity_state(block, first, velocity)
    state = run(block, state, measured, np.broadcast_to(dt, measured.size).copy(), found)
    return found, state
