"""Section IV-B, Fig. 5: recursive least squares (10)-(13) from zero on the data of Fig. 4."""

import itertools

import numpy as np

from adaptive_ff.learning.batch_least_squares import Array, fit_least_squares
from adaptive_ff.simulation.metrics import rms
from benchmarks.cases.reports import Row, limited
from benchmarks.paper.estimators import (
    Watched,
    fit_form,
    fit_series,
    physical_series,
    regression,
    run_rls,
    series_free_run,
)
from benchmarks.paper.experiment import Experiment, in_words, notes
from benchmarks.paper.figures import figure_05
from benchmarks.paper.records import MORE_SEEDS, PERIOD, SEED, Record, simulate_noise

TRANSIENT = 4.0  # s, after which the paper sees no transients
COVARIANCE = 1e6  # diagonal of ``R0``; the paper says "large"
COVARIANCES = (1e2, 1e4, 1e6, 1e8)
LARGEST_RATIO = 0.2
LARGEST_DIFFERENCE = 1e-9
ASSUMED_INERTIA = 30.0  # kg m^2, what the torque form starts from: half as much again as the truth
BANDWIDTH = 10.0  # Hz, of a loop around that inertia: its crossover is the pole of the filters


def identify_online(data: Record) -> Watched:
    """Run both recursive estimators over a record; ``last`` is the error of the free run of RLS's last estimate."""
    series = fit_series(data, 1.0, COVARIANCE)
    series.errors["last"] = data.velocity - series_free_run(series.coefficients[-1], data.velocity, data.acting)
    return Watched(data, series, fit_form(data, ASSUMED_INERTIA, BANDWIDTH))


def run() -> Experiment:
    """Identify the joint of Fig. 4 sample by sample."""
    online = identify_online(simulate_noise(SEED))
    rows, figures = [*agreement_rows(online.record), *error_rows(online)], {"figure_05": figure_05(*online)}
    return Experiment("Fig. 5, section IV-B: recursive least squares", rows, notes("online"), figures)


def agreement_rows(data: Record) -> list[Row]:
    """Return how the recursion with lambda = 1 agrees with one batch solution, with and without the prior."""
    rows, outputs = regression(data.velocity, data.acting)
    plain = fit_least_squares(rows, outputs).values
    same, distances = [], []
    for covariance in COVARIANCES:
        found = run_rls(rows, outputs, 1.0, covariance)[0][-1]
        prior = np.eye(rows.shape[1]) / np.sqrt(covariance)  # as many equations: zero, with this variance
        equations = np.vstack([rows, prior]), np.append(outputs, np.zeros(len(prior)))
        same.append(largest_difference(found, fit_least_squares(*equations).values))
        distances.append(largest_difference(found, plain))
    listed = "largest relative difference, R0 = " + ", ".join(f"{covariance:g}" for covariance in COVARIANCES)
    falls = all(later < earlier for earlier, later in itertools.pairwise(distances))
    shown = ", ".join(f"{distance:.1e}" for distance in distances)
    return [
        limited(f"RLS, lambda 1, against LS with prior R0^-1: {listed}", max(same), LARGEST_DIFFERENCE),
        Row(f"RLS, lambda 1, against plain LS: {listed}", shown, "falls with R0", falls),
    ]


def largest_difference(found: Array, expected: Array) -> float:
    """Return the largest relative difference of any coefficient."""
    return float(np.max(np.abs(found / expected - 1.0)))


def error_rows(online: Watched) -> list[Row]:
    """Return prediction errors after the transient, and what both estimators say of the joint."""
    time, after, many = online.record.time, f"after {TRANSIENT:g} s", f"the same, worst of {len(MORE_SEEDS)} seeds"
    series, form = online_ratios(online)
    worst = np.max([online_ratios(identify_online(simulate_noise(seed))) for seed in MORE_SEEDS], axis=0)
    errors = {
        "RLS, one-step": online.series.errors["prior"],
        "RLS, free run of the last estimate,": online.series.errors["last"],
        "torque form online, one-step": online.form.errors["prior"],
        "torque form online, free run of the last estimate,": online.form.errors["free"],
    }
    estimated = {
        "RLS": physical_series(online.series.coefficients, PERIOD),
        "torque form online": online.form.estimates,
    }
    return [
        limited(f"RLS, one-step error / that of w(k-1), {after}", series, LARGEST_RATIO),
        limited(many, float(worst[0]), LARGEST_RATIO),
        Row(f"torque form online, one-step error / that of w(k-1), {after}", form),
        Row(many, float(worst[1])),
        *(Row(f"{name} error {after}, mrad/s rms", 1e3 * rms(one[time > TRANSIENT])) for name, one in errors.items()),
        *(
            Row(f"{name}, off the truth at {moment:g} s by, %", in_words(estimates[round(moment / PERIOD)]))
            for name, estimates in estimated.items()
            for moment in (TRANSIENT, 10.0, time[-1])
        ),
    ]


def online_ratios(online: Watched) -> tuple[float, float]:
    """Return the one-step errors of RLS and of the torque form after the transient, over that of ``w(k-1)``."""
    late = online.record.time > TRANSIENT
    naive = rms(np.append(0.0, np.diff(online.record.velocity))[late])
    return rms(online.series.errors["prior"][late]) / naive, rms(online.form.errors["prior"][late]) / naive
