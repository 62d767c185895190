"""Section IV-B, Fig. 5: recursive least squares (10)-(13) from zero on the data of Fig. 4."""

import itertools

import numpy as np

from adaptive_ff.friction.model import ESTIMATED
from adaptive_ff.learning.batch_least_squares import Array, fit_least_squares
from adaptive_ff.learning.series import write_physical
from adaptive_ff.learning.torque_form import TorqueForm
from benchmarks.paper.data import MORE_SEEDS, PERIOD, SEED, TRUE, Data, in_words, rms, simulate_noise
from benchmarks.paper.experiment import Experiment, Row, limited, notes
from benchmarks.paper.figures import figure_05
from benchmarks.paper.identification import (
    FIRST,
    Online,
    model_free_run,
    model_of,
    models_one_step,
    regression,
    run_rls,
    run_torque_form,
    series_free_run,
)
from controllers import pi_gains

TRANSIENT = 4.0  # s, after which the paper sees no transients
COVARIANCE = 1e6  # diagonal of ``R0``; the paper says "large"
COVARIANCES = (1e2, 1e4, 1e6, 1e8)
LARGEST_RATIO = 0.2
LARGEST_DIFFERENCE = 1e-9
ASSUMED_INERTIA = 30.0  # kg m^2, what the torque form starts from: half as much again as the truth
BANDWIDTH = 10.0  # Hz, of a loop around that inertia: its crossover is the pole of the filters
GATE_SPEED = 0.2  # speed of the gate over the Stribeck velocity
GATE_HOLD = 3.0  # hold of the gate, time constants of the filters


def identify_online(data: Data) -> Online:
    """Run both recursive estimators over a record."""
    rows, outputs = regression(data.velocity, data.acting)
    recursion = run_rls(rows, outputs, 1.0, COVARIANCE)
    series = np.full((data.time.size, len(ESTIMATED)), np.nan)
    for k, coefficients in enumerate(recursion.estimates):
        write_physical(coefficients, PERIOD, series[k + FIRST])
    proportional, _ = pi_gains(ASSUMED_INERTIA, BANDWIDTH)
    pole, first = proportional / ASSUMED_INERTIA, np.array([ASSUMED_INERTIA, 0.0, 0.0, 0.0, 0.0])
    torque_form = TorqueForm(pole, TRUE.stribeck_velocity, TRUE.stribeck_shape)
    gate = GATE_SPEED * TRUE.stribeck_velocity, GATE_HOLD / pole
    form = run_torque_form(torque_form, gate, first, data.time, data.velocity, data.acting)
    return Online(
        np.append(np.zeros(FIRST), recursion.errors),
        series_free_run(recursion.estimates[-1], data.velocity, data.acting) - data.velocity,
        series,
        models_one_step(form, data.velocity, data.acting),
        model_free_run(model_of(form[-1]), data) - data.velocity,
        form,
    )


def run() -> Experiment:
    """Identify the joint of Fig. 4 sample by sample."""
    data = simulate_noise(SEED)
    online = identify_online(data)
    rows = [*agreement_rows(data), *error_rows(data, online)]
    return Experiment(
        "Fig. 5, section IV-B: recursive least squares", rows, notes("online"), {"figure_05": figure_05(data, online)}
    )


def agreement_rows(data: Data) -> list[Row]:
    """Return how the recursion with lambda = 1 agrees with one batch solution, with and without the prior."""
    rows, outputs = regression(data.velocity, data.acting)
    plain = fit_least_squares(rows, outputs).values
    same, distances = [], []
    for covariance in COVARIANCES:
        found = run_rls(rows, outputs, 1.0, covariance).estimates[-1]
        prior = np.eye(rows.shape[1]) / np.sqrt(covariance)  # as many equations: zero, with this variance
        equations = np.vstack([rows, prior]), np.append(outputs, np.zeros(len(prior)))
        same.append(largest_difference(found, fit_least_squares(*equations).values))
        distances.append(largest_difference(found, plain))
    listed = ", ".join(f"{covariance:g}" for covariance in COVARIANCES)
    falls = all(later < earlier for earlier, later in itertools.pairwise(distances))
    return [
        limited(
            f"RLS, lambda 1, against LS with prior R0^-1: largest relative difference, R0 = {listed}",
            max(same),
            LARGEST_DIFFERENCE,
        ),
        Row(
            f"RLS, lambda 1, against plain LS: largest relative difference, R0 = {listed}",
            ", ".join(f"{distance:.1e}" for distance in distances),
            "falls with R0",
            falls,
        ),
    ]


def largest_difference(found: Array, expected: Array) -> float:
    """Return the largest relative difference of any coefficient."""
    return float(np.max(np.abs(found / expected - 1.0)))


def error_rows(data: Data, online: Online) -> list[Row]:
    """Return prediction errors after the transient, and what both estimators say of the joint."""
    late, after = data.time > TRANSIENT, f"after {TRANSIENT:g} s"
    worst, form = np.max([online_ratios(simulate_noise(seed)) for seed in MORE_SEEDS], axis=0)
    errors = {
        "RLS, one-step": online.series_errors,
        "RLS, free run of the last estimate,": online.series_free,
        "torque form online, one-step": online.form_errors,
        "torque form online, free run of the last estimate,": online.form_free,
    }
    estimated = {"RLS": online.series, "torque form online": online.form}
    return [
        limited(f"RLS, one-step error / that of w(k-1), {after}", online_ratios(data, online)[0], LARGEST_RATIO),
        limited(f"the same, worst of {len(MORE_SEEDS)} seeds", float(worst), LARGEST_RATIO),
        Row(f"torque form online, one-step error / that of w(k-1), {after}", online_ratios(data, online)[1]),
        Row(f"the same, worst of {len(MORE_SEEDS)} seeds", float(form)),
        *(Row(f"{name} error {after}, mrad/s rms", 1e3 * rms(values[late])) for name, values in errors.items()),
        *(
            Row(f"{name}, off the truth at {moment:g} s by, %", in_words(model_of(estimates[round(moment / PERIOD)])))
            for name, estimates in estimated.items()
            for moment in (TRANSIENT, 10.0, data.time[-1])
        ),
    ]


def online_ratios(data: Data, online: Online | None = None) -> tuple[float, float]:
    """Return the one-step errors of RLS and of the torque form after the transient, over that of ``w(k-1)``."""
    online = identify_online(data) if online is None else online
    late = data.time > TRANSIENT
    naive = rms(np.append(0.0, np.diff(data.velocity))[late])
    return rms(online.series_errors[late]) / naive, rms(online.form_errors[late]) / naive
