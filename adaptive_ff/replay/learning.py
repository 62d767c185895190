"""The controller's filter of the coefficients, over a log: torque and columns along the measured motion."""

import math
from typing import NamedTuple

import numpy as np

from adaptive_ff.friction.columns import Curve, Hypothesis, columns_along
from adaptive_ff.friction.model import GRAVITY, WITH_OFFSET, ripple_names
from adaptive_ff.identify.motion import Array, Rows
from adaptive_ff.learning.kalman import LOOP, Estimate, Modes, Prior, constrain_in_place, update_in_place
from controllers import compiled
from controllers.arrays import MutableArray, NDArray, packed, row_of

DRY, TURNING = ("coulomb", "stiction"), ("slow_coulomb", "soft_coulomb")
"""Dry friction, and more of it that turns over a path after a reversal."""

COLUMNS = ("inertia", "viscous", *DRY, *TURNING)
"""Names of the first columns."""

PATHS = (0.003, 0.02)
"""Their paths, over the way in a second at the usual speed."""

NOT_NEGATIVE = ("inertia", "viscous")
"""Parameters that are bounded."""

CLIP = 3.0
"""Standard deviations beyond which an innovation counts less, as in the controller."""

FIRST_LAG = 0.01
"""Friction lag about which its column is linear, s."""


class Learner(NamedTuple):
    """What is learnt, and what is known before: first values and their standard deviations, and the usual torque, N m.

    The columns are those of the friction hypothesis, and perhaps an offset before its last two.
    """

    names: tuple[str, ...]
    hypothesis: Hypothesis
    curve: Curve
    first: Array
    deviation: Array
    torque: float


def make_learner(
    *,
    fast: float,
    torque: float,
    accelerated: float,
    inertia: float | None,
    stribeck_velocity: float,
    parameters: tuple[str, ...],
    ripples: tuple[float, ...],
) -> Learner:
    """Return a learner of a set of parameters, and of ripples of some periods, rad.

    Usual speed (rad/s), torque (N m) and acceleration (rad/s^2) scale what is not known.
    """
    further = [name for name in parameters if name not in WITH_OFFSET]
    waves = np.array([*([1.0] if GRAVITY[0] in further else []), *(2.0 * np.pi / period for period in ripples)])
    directions = "viscous_asymmetry" in further
    hypothesis = Hypothesis(1.0, fast * np.array(PATHS), directions, waves, np.empty(0), 0, 0.0, 1.0, False, 0, 1.0)
    curve = Curve(FIRST_LAG, stribeck_velocity, 1.0, 1.0, 1.0, 0.0)
    offset = ["offset"] if "offset" in parameters else []
    names = (*COLUMNS, *further, *ripple_names(len(ripples)), *offset, "lag_slope", "velocity_slope")
    unlike = {"inertia": torque / max(accelerated, 1e-300), "viscous": torque / fast, "velocity_slope": 0.0}
    unlike |= {"stiction_asymmetry": 0.3 * torque, "viscous_asymmetry": 0.3 * torque / fast}
    first, deviation = np.zeros(len(names)), np.array([unlike.get(name, torque) for name in names])
    if inertia is not None:
        first[0], deviation[0] = inertia, 0.3 * inertia
    return Learner(names, hypothesis, curve, first, deviation, torque)


def columns_of(learner: Learner, rows: Rows) -> Array:
    """Return the unit torques along the motion of a segment; at standstill the joint holds its friction."""
    velocity = rows.between(rows.slow)
    columns = columns_along(learner.hypothesis, learner.curve, velocity, rows.period, rows.position)
    return np.insert(columns, columns.shape[1] - 2, 1.0, axis=1) if "offset" in learner.names else columns


def initial_state(learner: Learner) -> Estimate:
    """Return the state before anything is measured; coefficients in units of their deviations, torque of the usual."""
    size = len(learner.names)
    known = learner.deviation > 0.0
    mean = np.zeros(LOOP + size)
    mean[LOOP:][known] = learner.first[known] / learner.deviation[known]
    return Estimate(mean, packed(np.diag(np.append(np.zeros(LOOP), known))))


@compiled
def learn_in_place(
    estimate: Estimate,
    prior: Prior,
    columns: Array,
    torque: Array,
    sliding: NDArray[np.bool_],
    forgetting: float,
    history: MutableArray,
    work: MutableArray,
    multipliers: MutableArray,
) -> None:
    """Take every sliding sample into account; write the estimates before each.

    A log has no loop of ours, so its two states stay at zero. With process noise ``(1/lambda - 1) P`` the filter is
    recursive least squares; it stops where the covariance is that of the prior. The noise is what is left.
    """
    size = columns.shape[1]
    level, most = 1.0, float(size)
    for k in range(torque.size):
        total = 0.0
        for i in range(size):
            history[k, i] = estimate.mean[LOOP + i]
            total += estimate.covariance[row_of(LOOP + i) + LOOP + i]
        if sliding[k]:
            grown = 1.0 / forgetting if total < most else 1.0
            for i in range(estimate.covariance.size):
                estimate.covariance[i] *= grown
            error = torque[k]
            for i in range(size):
                error -= columns[k, i] * estimate.mean[LOOP + i]
            update_in_place(estimate, columns[k], torque[k], level, Modes(0.0, 0.0, 0.5), CLIP, 0.0, 0.0, work)
            constrain_in_place(estimate, prior, multipliers)
            level = max(forgetting * level + (1.0 - forgetting) * error * error, 1e-6)


def learn(
    learner: Learner,
    estimate: Estimate,
    columns: Array,
    torque: Array,
    sliding: NDArray[np.bool_],
    period: float,
    memory: float,
) -> Array:
    """Learn along a segment, in place; return the estimates before each sample, shape (n, parameters).

    Columns and torque are behind the response. The memory is in s of sliding motion.
    """
    size = len(learner.names)
    history = np.empty((torque.size, size))
    lowest = np.array([0.0 if name in NOT_NEGATIVE else -np.inf for name in learner.names])
    unscaled, unbounded = np.zeros(size, dtype=np.bool_), np.full(size, np.inf)
    prior = Prior(np.zeros(size), np.zeros(size * (size + 1) // 2), unscaled, lowest, unbounded)
    learn_in_place(
        estimate,
        prior,
        np.ascontiguousarray(columns * learner.deviation / learner.torque),
        np.ascontiguousarray(torque / learner.torque),
        sliding,
        math.exp(-period / memory),
        history,
        np.zeros(LOOP + size),
        np.zeros(size),
    )
    return history * learner.deviation
