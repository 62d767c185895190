"""Recursive least squares of a log's torque along its measured motion, one sample after the other."""

import math
from typing import NamedTuple

import numpy as np

from adaptive_ff.friction.along import columns_along
from adaptive_ff.friction.columns import Curve, Hypothesis
from adaptive_ff.identify.motion import Array, Rows
from adaptive_ff.learning.rls import RLSState, initial_rls_state, update_rls_in_place
from controllers import compiled
from controllers.arrays import NDArray

COLUMNS = ("inertia", "viscous", "coulomb", "stiction", "slow_coulomb", "soft_coulomb")
"""Names of the first columns; the last two are Coulomb friction that turns over a path."""

PATHS = (0.003, 0.02)
"""Their paths, over the way in a second at the usual speed."""

NOT_NEGATIVE = ("inertia", "viscous")
"""Parameters that are fed as zero where they come out negative."""

FIRST_LAG = 0.01
"""Friction lag about which its column is linear, s."""


class Learner(NamedTuple):
    """What is learnt, and what is known before.

    Attributes
    ----------
    names : tuple of str
        Parameters.
    hypothesis, curve : Hypothesis, Curve
        Columns of the friction hypothesis.
    gravity, offset, directions : bool
        Whether there are such terms.
    deviation : ndarray
        Standard deviation of each parameter beforehand.
    first : ndarray
        Its first value.
    """

    names: tuple[str, ...]
    hypothesis: Hypothesis
    curve: Curve
    offset: bool
    first: Array
    deviation: Array


def make_learner(
    *,
    fast: float,
    torque: float,
    accelerated: float,
    inertia: float | None,
    stribeck_velocity: float,
    directions: bool,
    gravity: bool,
    offset: bool,
    ripples: tuple[float, ...],
) -> Learner:
    """Return a learner; usual speed (rad/s), torque (N m) and acceleration (rad/s^2) scale what is not known."""
    waves = np.array([*([1.0] if gravity else []), *(2.0 * np.pi / period for period in ripples)])
    hypothesis = Hypothesis(1.0, fast * np.array(PATHS), directions, waves, np.empty(0), 0, 0.0, 1.0, False, 0, 1.0)
    curve = Curve(FIRST_LAG, stribeck_velocity, 1.0, 1.0, 0.0)
    names = list(COLUMNS) + (["stiction_asymmetry", "viscous_asymmetry"] if directions else [])
    names += ["gravity_sin", "gravity_cos"] if gravity else []
    names += [f"ripple_{part}_{number}" for number in range(1, len(ripples) + 1) for part in ("sin", "cos")]
    names += ["lag_slope", "velocity_slope", *(["offset"] if offset else [])]
    deviation = np.full(len(names), torque)
    first = np.zeros(len(names))
    deviation[0], deviation[1] = torque / max(accelerated, 1e-300), torque / fast
    if inertia is not None:
        first[0], deviation[0] = inertia, 0.3 * inertia
    if directions:
        deviation[names.index("viscous_asymmetry")] = 0.3 * torque / fast
        deviation[names.index("stiction_asymmetry")] = 0.3 * torque
    deviation[names.index("velocity_slope")] = 0.0
    return Learner(tuple(names), hypothesis, curve, offset, first, deviation)


def columns_of(learner: Learner, rows: Rows, still: float) -> Array:
    """Return the unit torques along the motion of a segment; below a speed the joint holds its friction."""
    velocity = np.where(np.abs(rows.velocity) < still, 0.0, rows.velocity)
    middle = 0.5 * (velocity[1:] + velocity[:-1])
    edges = np.concatenate([velocity[:1], middle, velocity[-1:]])
    columns = columns_along(learner.hypothesis, learner.curve, edges, rows.period, rows.position)
    return np.column_stack([columns, np.ones(velocity.size)]) if learner.offset else columns


def initial_state(learner: Learner) -> RLSState:
    """Return the state before anything is measured, in units of the deviations."""
    return initial_rls_state(np.zeros(len(learner.names)), np.eye(len(learner.names)))


def _learn(
    state: RLSState,
    columns: Array,
    torque: Array,
    sliding: NDArray[np.bool_],
    forgetting: float,
    most: float,
    history: Array,
) -> float:
    """Take every sliding sample into account; write the estimates before each; return the mean square error."""
    level = 1e-12
    for k in range(torque.size):
        total = 0.0
        for i in range(state.estimate.size):
            history[k, i] = state.estimate[i]
            total += state.covariance[i, i]
        if sliding[k]:
            error = update_rls_in_place(state, columns[k], torque[k], forgetting if total < most else 1.0)
            level += 0.001 * (error * error - level)
    return level


learn_in_place = compiled(_learn)


def learn(
    learner: Learner,
    state: RLSState,
    columns: Array,
    torque: Array,
    sliding: NDArray[np.bool_],
    period: float,
    memory: float,
) -> Array:
    """Learn along a segment, in place; return the estimates before each sample, shape (n, parameters).

    Columns and torque are behind the response. The memory is in s of sliding motion.
    """
    history = np.empty((torque.size, len(learner.names)))
    scaled = np.ascontiguousarray(columns * learner.deviation)
    rest = torque - columns @ learner.first
    forgetting = math.exp(-period / memory)
    learn_in_place(state, scaled, rest, sliding, forgetting, float(len(learner.names)), history)
    return learner.first + history * learner.deviation
