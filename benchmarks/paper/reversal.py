"""Section III, Fig. 3: the one-step error that the friction sign of ``w(k-1)`` costs at motion reversal, against speed.

The joint of Fig. 4 is driven by noise of one rms and several corner frequencies: the lower, the slower its reversals.
"""

from typing import NamedTuple

import numpy as np

from adaptive_ff.learning.batch import Mask
from adaptive_ff.learning.batch_least_squares import Array
from adaptive_ff.simulation.metrics import rms
from benchmarks.cases.reports import Row
from benchmarks.paper.estimators import FIRST, filtered, series, series_one_step
from benchmarks.paper.experiment import Experiment, notes
from benchmarks.paper.figures import figure_03
from benchmarks.paper.records import PERIOD, SEED, TRUE, Record, predict, simulate_noise

CORNERS = (0.25, 0.5, 1.0, 2.0, 4.0, 8.0)  # Hz
DURATION = 300.0  # s
KINDS = ("reversal", "next", "rest", "sliding")
"""Kinds of samples ``k``: the velocity has changed sign since ``k - 1``; it had between ``k - 2`` and ``k - 1``; the
joint rests at one of the three samples of (4); everything else."""


class Reversals(NamedTuple):
    """One-step errors in a record."""

    speed: float  # median rate of change of the velocity over a reversal, rad/s^2
    fractions: dict[str, float]  # of the squared one-step error of (4), by kind of samples
    sizes: dict[str, float]  # rms one-step error of (4), by kind of samples, rad/s
    form: float  # the same at reversals of the model that the torque form finds in the record, simulated


def run() -> Experiment:
    """Measure the errors at reversal against reversal speed."""
    data = simulate_noise(SEED)
    coefficients = series(data.velocity, data.acting, sliding=True).regression.values
    found = [measure(simulate_noise(SEED, duration=DURATION, corner=corner), coefficients) for corner in CORNERS]
    rows = []
    for one in found:
        reversals = f"reversals at {one.speed:.1f} rad/s^2: fraction of the squared error, %"
        rows.append(Row(reversals, 100.0 * one.fractions["reversal"]))
        rows.append(Row("the same, samples at rest, %", 100.0 * one.fractions["rest"]))
    sizes = {
        "(4): one-step error on reversals": [one.sizes["reversal"] for one in found],
        "torque form, simulated: one-step error on reversals": [one.form for one in found],
        "(4): one-step error while sliding": [one.sizes["sliding"] for one in found],
    }
    for name, values in sizes.items():
        rows.append(Row(f"{name}, mrad/s rms, slowest to fastest", ", ".join(f"{1e3 * one:.3g}" for one in values)))
    closed = "closed form: friction keeps the old sign to the end of the period, mrad/s rms"
    rows.append(Row(closed, 1e3 * old_sign_error()))
    title = "Fig. 3, section III: sign of friction at reversal"
    return Experiment(title, rows, notes("reversal"), {"figure_03": figure_03([one.speed for one in found], found)})


def kinds_of(velocity: Array) -> dict[str, Mask]:
    """Return which samples, from the third on, are of which kind."""
    earlier, before, now = velocity[:-FIRST], velocity[1:-1], velocity[FIRST:]
    reversal = before * now < 0.0
    following = (earlier * before < 0.0) & ~reversal
    rest = ((earlier == 0.0) | (before == 0.0) | (now == 0.0)) & ~reversal & ~following
    return dict(zip(KINDS, (reversal, following, rest, ~(reversal | following | rest)), strict=True))


def measure(data: Record, coefficients: Array) -> Reversals:
    """Measure the one-step errors of (4) with some coefficients on each kind of samples of a record."""
    errors = series_one_step(coefficients, data.velocity, data.acting)[FIRST:]
    kinds = kinds_of(data.velocity)
    form = (data.velocity - predict(filtered(data).model, data, one_step=True))[FIRST:]
    speeds = np.abs(np.diff(data.velocity[1:])) / PERIOD
    return Reversals(
        float(np.median(speeds[kinds["reversal"]])),
        {name: float(np.sum(errors[kind] ** 2) / np.sum(errors**2)) for name, kind in kinds.items()},
        {name: rms(errors[kind]) for name, kind in kinds.items()},
        rms(form[kinds["reversal"]]),
    )


def old_sign_error() -> float:
    """Return the rms velocity error, rad/s, of keeping the old sign of friction until the end of the period.

    Friction turns by ``2 Fs`` at the moment of reversal and follows with the lag; all moments in a period are alike.
    """
    time = PERIOD * (np.arange(10_000) + 0.5) / 10_000
    lag = TRUE.friction_lag
    return rms(2.0 * TRUE.stiction / TRUE.inertia * (time - lag * (1.0 - np.exp(-time / lag))))
