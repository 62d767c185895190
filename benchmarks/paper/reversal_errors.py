"""One-step errors of (4) at motion reversal, what else they could be, and reversals worth a look."""

from typing import NamedTuple

import numpy as np

from adaptive_ff.learning.batch import Mask
from adaptive_ff.learning.batch_least_squares import Array
from benchmarks.paper.data import PERIOD, TRUE, Data, rms
from benchmarks.paper.identification import FIRST, filtered, model_one_step, regression, series_one_step

CLEAR = 6  # samples
SHORTEST_REST, LONGEST_REST = 4, 8  # samples
KINDS = ("reversal", "next", "rest", "sliding")
"""Kinds of samples ``k``: the velocity has changed sign since ``k - 1``; it had between ``k - 2`` and ``k - 1``; the
joint rests at one of the three samples of (4); everything else."""


class Reversals(NamedTuple):
    """One-step errors in a record.

    ``speed``: median rate of change of the velocity over a reversal, rad/s^2; ``counts``: share of each kind in the
    samples; ``shares``: share of each kind in the squared one-step error of (4); ``sizes``: rms one-step error of (4)
    on each kind of samples, rad/s; ``current_sign``: rms one-step error at reversals of (4) with ``g`` and ``h`` of
    ``w(k)``, rad/s; ``form``: rms one-step error at reversals of the model that the torque form finds in the record,
    simulated, rad/s.
    """

    speed: float
    counts: dict[str, float]
    shares: dict[str, float]
    sizes: dict[str, float]
    current_sign: float
    form: float


def kinds_of(velocity: Array) -> dict[str, Mask]:
    """Return which samples, from the third on, are of which kind."""
    earlier, before, now = velocity[:-FIRST], velocity[1:-1], velocity[FIRST:]
    reversal = before * now < 0.0
    following = (earlier * before < 0.0) & ~reversal
    rest = ((earlier == 0.0) | (before == 0.0) | (now == 0.0)) & ~reversal & ~following
    return dict(zip(KINDS, (reversal, following, rest, ~(reversal | following | rest)), strict=True))


def shares_of(errors: Array, kinds: dict[str, Mask]) -> dict[str, float]:
    """Return the share of each kind of samples in the squared error."""
    return {name: float(np.sum(errors[kind] ** 2) / np.sum(errors**2)) for name, kind in kinds.items()}


def with_current_sign(velocity: Array, torque: Array) -> tuple[Array, Array]:
    """Return regressors and outputs of (4) with the friction regressors taken at ``w(k)``, which no predictor knows."""
    rows, outputs = regression(velocity, torque)
    share = np.exp(-((np.abs(outputs) / TRUE.stribeck_velocity) ** TRUE.stribeck_shape))
    rows[:, 4], rows[:, 5] = -np.sign(outputs) * (1.0 - share), -np.sign(outputs) * share
    return rows, outputs


def measure(data: Data, coefficients: Array, current: Array) -> Reversals:
    """Measure the one-step errors of a record on each kind of samples.

    ``data``: the record; ``coefficients``, ``current`` (6,): coefficients of (4), and of (4) with the friction
    regressors of ``w(k)``.
    """
    errors = series_one_step(coefficients, data.velocity, data.acting)[FIRST:]
    kinds = kinds_of(data.velocity)
    rows, outputs = with_current_sign(data.velocity, data.acting)
    form = model_one_step(filtered(data).model, data.velocity, data.acting)[FIRST:]
    speeds = np.abs(np.diff(data.velocity[1:])) / PERIOD
    reversal = kinds["reversal"]
    return Reversals(
        float(np.median(speeds[reversal])),
        {name: float(np.mean(kind)) for name, kind in kinds.items()},
        shares_of(errors, kinds),
        {name: rms(errors[kind]) for name, kind in kinds.items()},
        rms((outputs - rows @ current)[reversal]),
        rms(form[reversal]),
    )


def old_sign_error() -> float:
    """Return the rms velocity error, rad/s, of keeping the old sign of friction until the end of the period.

    Friction turns by ``2 Fs`` at the moment of reversal and follows with the lag; all moments in a period are alike.
    """
    time = PERIOD * (np.arange(10_000) + 0.5) / 10_000
    lag = TRUE.friction_lag
    return rms(2.0 * TRUE.stiction / TRUE.inertia * (time - lag * (1.0 - np.exp(-time / lag))))


def friction(velocity: Array) -> Array:
    """Return the static friction torque (N m) of the true joint, zero at rest as (4) has it."""
    share = np.exp(-((np.abs(velocity) / TRUE.stribeck_velocity) ** TRUE.stribeck_shape))
    level: Array = np.sign(velocity) * (TRUE.coulomb + (TRUE.stiction - TRUE.coulomb) * share) + TRUE.viscous * velocity
    return level


def fast_reversal(velocity: Array) -> int:
    """Return the sample after the fastest reversal around which the velocity keeps its sign for some samples."""
    best, fastest = 0, 0.0
    for k in np.flatnonzero(kinds_of(velocity)["reversal"]) + FIRST:
        before, after = velocity[k - CLEAR : k], velocity[k : k + CLEAR]
        speed = abs(velocity[k] - velocity[k - 1])
        if k > CLEAR and np.all(before * before[-1] > 0.0) and np.all(after * after[0] > 0.0) and speed > fastest:
            best, fastest = int(k), float(speed)
    return best


def slow_reversal(velocity: Array) -> int:
    """Return the first sample at rest of the first reversal through a short rest."""
    resting = np.concatenate([[False], velocity == 0.0, [False]])
    starts, ends = (np.flatnonzero(np.diff(resting.astype(int)) == sign) for sign in (1, -1))
    for start, end in zip(starts, ends, strict=True):
        if start > 2 * CLEAR and SHORTEST_REST <= end - start <= LONGEST_REST and end + CLEAR < velocity.size:
            before, after = velocity[start - CLEAR], velocity[end + CLEAR - 1]
            if before * after < 0.0 and min(abs(before), abs(after)) > TRUE.stribeck_velocity:
                return int(start)
    return fast_reversal(velocity)
