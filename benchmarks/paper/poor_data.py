"""Sections V-D and V-E, Figs 9, 11 and 12: offline fit and RLS on data of the closed loop, and what spoils them."""

from collections.abc import Callable
from typing import Any

import numpy as np

from adaptive_ff.friction.model import ESTIMATED
from adaptive_ff.learning.batch import Array, Mask, slides_one_way
from adaptive_ff.learning.batch_least_squares import fit_least_squares
from adaptive_ff.learning.series import COEFFICIENTS, series_coefficients
from benchmarks.paper.data import SYMBOLS, TRUE, TRUTH_VALUES, rms
from benchmarks.paper.experiment import Row, median_and_range, median_deviation
from benchmarks.paper.identification import FIRST, regression, run_rls
from benchmarks.paper.robot import (
    CURRENT_STEP,
    LATE,
    NOISE,
    PERIOD,
    Drive,
    build_robot_setup,
    drive,
    drive_behind_interface,
)
from benchmarks.paper.watching import (
    COVARIANCE,
    FORGETTING,
    NEAR_REST,
    TRANSIENT,
    Seen,
    Series,
    fit_series,
    identify_form,
    is_possible,
    physical_of,
    physical_series,
    settled_rms,
)

FINE_CURRENT = 1e-6  # A
FEW_SEEDS = range(1, 6)
"""Seeds on which causes are told apart."""
VARIANTS: dict[str, tuple[dict[str, Any], float]] = {
    "as it is": ({}, CURRENT_STEP),
    "sampled evenly": ({"uniform": True}, CURRENT_STEP),
    "without noise": ({"noise": 0.0}, CURRENT_STEP),
    "with a fine current": ({}, FINE_CURRENT),
    "with none of the three faults": ({"uniform": True, "noise": 0.0}, FINE_CURRENT),
}
"""What is taken away from the data to see what spoils the fit: arguments of the setup, and the step of the current."""
CAUSES = (
    "one-step error of LS, mrad/s rms; J by LS, by LS on sliding samples, by the torque form "
    f"(true {TRUE.inertia:g} kg m^2)"
)
ERRORS: dict[str, Callable[[Seen], Array]] = {
    "one-step error of the offline LS, mrad/s rms": lambda one: one.series.errors["offline"],
    "one-step error of the torque form (last online estimate, simulated)": lambda one: one.form.errors["online"],
    "one-step error of the true joint (the noise floor)": lambda one: one.form.errors["true"],
    "one-step error of the predictor w(k-1)": lambda one: np.diff(one.record.velocity, prepend=0.0),
    "free-run error of the offline LS, mrad/s rms": lambda one: one.series.errors["free"],
    "free-run error of the torque form": lambda one: one.form.errors["free"],
    "free-run error of the true joint": lambda one: one.form.errors["true_free"],
}


def offline_rows(every: list[Seen]) -> list[Row]:
    """Return how well the offline fits predict, where they err, and what they say of the joint."""
    rows = [
        Row(f"Fig. 9: {name}", median_and_range([settled_rms(one.record, choose(one)) for one in every]))
        for name, choose in ERRORS.items()
    ]
    places = [error_places(one) for one in every]
    rows += [Row(f"Fig. 9: {name}", median_and_range([place[name] for place in places], 0)) for name in places[0]]
    conditions = [one.series.offline.condition_number for one in every]
    rows.append(Row("Fig. 9: condition number of X, columns scaled", median_and_range(conditions, 0)))
    gated = [[estimate.value for estimate in one.form.offline.physical.values()] for one in every]
    estimates = {
        "offline LS on (4): off the truth by, %": [physical_of(one.series.offline.values) for one in every],
        "the same, sliding samples only: off by, %": [physical_of(one.series.sliding.values) for one in every],
        "all samples, with u(k) the torque commanded at k: off by, %": [
            _with_commanded_torque(one.record) for one in every
        ],
        "torque form, gated LS: off by, %": [np.array(values) for values in gated],
        "torque form, online, at the end: off by, %": [one.form.estimates[-1] for one in every],
    }
    return [*rows, *(Row(f"Fig. 9: {name}", median_deviation(found)) for name, found in estimates.items())]


def _with_commanded_torque(record: Drive) -> Array:
    regressors, outputs = regression(record.velocity, record.commanded)
    return physical_of(fit_least_squares(regressors, outputs).values)


def error_places(one: Seen) -> dict[str, float]:
    """Return where the errors of the offline fit are, in %."""
    record, errors = one.record, one.series.errors["offline"]
    late = np.diff(record.time, prepend=0.0) > LATE
    near = near_rest(record)
    fastest = np.abs(record.velocity) >= np.quantile(np.abs(record.velocity), 0.9)
    largest = np.abs(errors) >= np.quantile(np.abs(errors), 0.99)
    squares, free = errors**2, one.series.errors["free"] ** 2
    shares = {
        "squared one-step error of the LS on late samples, %": np.sum(squares[late]) / np.sum(squares),
        f"squared one-step error within {NEAR_REST:g} rad/s of rest, %": np.sum(squares[near]) / np.sum(squares),
        "samples within that, %": np.mean(near),
        "largest 1 % of the one-step errors: on late samples, %": np.mean(late[largest]),
        "largest 1 % of the one-step errors: in the fastest tenth of the motion, %": np.mean(fastest[largest]),
        "free-run error, rms, in the fastest tenth / overall, %": np.sqrt(np.mean(free[fastest]) / np.mean(free)),
    }
    return {name: 100.0 * float(share) for name, share in shares.items()}


def near_rest(record: Drive) -> Mask:
    """Tell which equations of (4) have a velocity near rest in them."""
    slow = np.abs(record.velocity) < NEAR_REST
    near: Mask = slow | np.roll(slow, 1) | np.roll(slow, 2)
    return near


def cause_rows() -> list[Row]:
    """Return what the offline fits become when one fault of the data is taken away, or the loop is another."""
    rows = [
        _cause_row(f"data {name}", [_variant(*change, seed) for seed in FEW_SEEDS]) for name, change in VARIANTS.items()
    ]
    return [*rows, _cause_row("data read out of a loop at 1 kHz", [drive_behind_interface(seed) for seed in FEW_SEEDS])]


def _variant(arguments: dict[str, Any], current_step: float, seed: int) -> Drive:
    return drive(build_robot_setup(seed, **arguments), current_step=current_step)


def _cause_row(name: str, records: list[Drive]) -> Row:
    """Return the one-step error of the offline LS, and the inertia by it and by the torque form."""
    fits = [fit_series(record) for record in records]
    error = np.median([1e3 * fit.offline.residual_rms for fit in fits])
    inertias = (
        [physical_of(fit.offline.values)[0] for fit in fits],
        [physical_of(fit.sliding.values)[0] for fit in fits],
        [identify_form(record).model.inertia for record in records],
    )
    text = f"{error:.2f}; {', '.join(f'{np.median(values):.1f}' for values in inertias)}"
    return Row(f"Fig. 9: {name}: {CAUSES}", text)


FACTORS = (0.85, 0.95, 0.98, 0.99, 1.0)  # lambda
PRIOR = "a-priori error, rms"
PRIOR_KEPT = "a-priori error, rms without its largest 1 %"
PRIOR_MEDIAN = "a-priori error, median size"
POSTERIOR = "a-posteriori error, rms"
TO_FREE = "a-priori error, rms, against the free run of the offline fit"


def ratios(record: Drive, series: Series) -> dict[str, float]:
    """Return errors of RLS relative to those of the offline fit."""
    late = record.time >= TRANSIENT
    errors = {name: values[late] for name, values in series.errors.items()}
    offline, prior = errors["offline"], np.abs(errors["prior"])
    kept = prior <= np.quantile(prior, 0.99)
    return {
        PRIOR: rms(prior) / rms(offline),
        POSTERIOR: rms(errors["posterior"]) / rms(offline),
        PRIOR_MEDIAN: float(np.median(prior) / np.median(np.abs(offline))),
        PRIOR_KEPT: rms(prior[kept]) / rms(offline),
        TO_FREE: rms(prior) / rms(errors["free"]),
    }


def online_rows(every: list[Seen]) -> list[Row]:
    """Return how RLS compares with the offline fit (Fig. 11)."""
    found = [ratios(one.record, one.series) for one in every]
    name = f"Fig. 11: RLS at lambda {FORGETTING:g} / offline LS"
    rows = [Row(f"{name}: {key}", median_and_range([each[key] for each in found])) for key in found[0]]
    below = [key for key in found[0] if max(each[key] for each in found) < 1.0]
    rows.append(Row(f"{name}: below 1 on all {len(every)} seeds", "; ".join(below)))
    for key, error in (("a-priori", "prior"), ("a-posteriori", "posterior")):
        values = [settled_rms(one.record, one.series.errors[error]) for one in every]
        rows.append(Row(f"Fig. 11: {key} error of RLS (noise {1e3 * NOISE:g}), mrad/s rms", median_and_range(values)))
    offline = np.array([settled_rms(one.record, one.series.errors["offline"]) for one in every])
    by_factor = []
    for factor in FACTORS:
        prior = [fit_series(one.record, forgetting_factor=factor).errors["prior"] for one in every]
        errors = np.array([settled_rms(one.record, error) for one, error in zip(every, prior, strict=True)])
        by_factor.append(f"{np.median(errors / offline):.2f}")
    listed = ", ".join(f"{factor:g}" for factor in FACTORS)
    rows.append(Row(f"Fig. 11: RLS / offline LS, a-priori error, rms, at lambda {listed}", ", ".join(by_factor)))
    read = [drive_behind_interface(seed) for seed in FEW_SEEDS]
    others = [ratios(record, fit_series(record)) for record in read]
    for key in (PRIOR, POSTERIOR):
        row = Row(f"{name}, data read out of a loop at 1 kHz: {key}", median_and_range([each[key] for each in others]))
        rows.append(row)
    read = [sliding_ratios(one.record) for one in every]
    for key, values in zip((PRIOR, POSTERIOR), zip(*read, strict=True), strict=True):
        rows.append(Row(f"{name}, both on sliding samples only: {key}", median_and_range(values)))
    return rows


def sliding_ratios(record: Drive) -> tuple[float, float]:
    """Return a-priori and a-posteriori error of RLS to that of the offline fit, all without samples near rest."""
    used = slides_one_way(record.velocity, NEAR_REST)[FIRST:]
    late = record.time[FIRST:][used] >= TRANSIENT
    rows, outputs = (values[used] for values in regression(record.velocity, record.acting))
    online = run_rls(rows, outputs, FORGETTING, COVARIANCE)
    posterior = outputs - np.sum(rows * online.estimates, axis=1)
    offline = rms(fit_least_squares(rows, outputs).residuals[late])
    return rms(online.errors[late]) / offline, rms(posterior[late]) / offline


def parameter_rows(every: list[Seen]) -> list[Row]:
    """Return how the parameters behave once the transient is over (Fig. 12)."""
    true = np.array(series_coefficients(TRUE, PERIOD))
    spreads, possible, series, form = [], [], [], []
    for one in every:
        late = one.record.time >= TRANSIENT
        coefficients = one.series.coefficients[late]
        spreads.append(quartile_range(coefficients) / true)
        physical = physical_series(coefficients)
        possible.append(100.0 * float(np.mean(is_possible(physical))))
        series.append(quartile_range(physical) / TRUTH_VALUES)
        form.append(quartile_range(one.form.estimates[late]) / TRUTH_VALUES)
    return [
        Row(
            "Fig. 12: coefficients by RLS: interquartile range / true value",
            _listed(COEFFICIENTS, np.median(spreads, axis=0)),
        ),
        Row("Fig. 12: samples whose coefficients stand for a possible joint, %", median_and_range(possible, 1)),
        Row("Fig. 12: parameters by RLS: interquartile range / true value", _listed_physical(series)),
        Row("Fig. 12: parameters by the torque form: interquartile range / true value", _listed_physical(form)),
    ]


def quartile_range(values: Array) -> Array:
    """Return the interquartile range of each column, leaving out what is not a number."""
    low, high = np.nanquantile(values, (0.25, 0.75), axis=0)
    width: Array = high - low
    return width


def _listed(names: tuple[str, ...], values: Array) -> str:
    return ", ".join(f"{name} {value:.2f}" for name, value in zip(names, values, strict=True))


def _listed_physical(ranges: list[Array]) -> str:
    return _listed(tuple(SYMBOLS[name] for name in ESTIMATED), np.median(ranges, axis=0))
