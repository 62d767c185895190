"""Section V-E, Figs 11 and 12: RLS with a short memory against the offline fit, and what its parameters are worth."""

import numpy as np

from adaptive_ff.friction.model import ESTIMATED
from adaptive_ff.learning.batch import Array, Mask, slides_one_way
from adaptive_ff.learning.batch_least_squares import fit_least_squares
from adaptive_ff.learning.series import COEFFICIENTS, series_coefficients
from benchmarks.paper.closed_loop_offline import FEW_SEEDS
from benchmarks.paper.experiment import Row
from benchmarks.paper.identification_data import SYMBOLS, TRUE
from benchmarks.paper.prediction import FIRST, regression, rms
from benchmarks.paper.recursion import run_rls
from benchmarks.paper.robot import NOISE, PERIOD, Drive, drive_behind_interface
from benchmarks.paper.summaries import TRUTH, median_and_range
from benchmarks.paper.watching import (
    COVARIANCE,
    FORGETTING,
    NEAR_REST,
    TRANSIENT,
    Seen,
    Series,
    fit_series,
    physical_of,
    settled_rms,
)

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
        series.append(quartile_range(physical) / TRUTH)
        form.append(quartile_range(one.form.estimates[late]) / TRUTH)
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


def physical_series(coefficients: Array) -> Array:
    """Return the physical parameters for each row of coefficients, shape (n, 5); not numbers where there are none."""
    return np.array([physical_of(row) for row in coefficients])


def is_possible(physical: Array) -> Mask:
    """Tell which rows are a joint: positive inertia, friction and lag not negative."""
    with np.errstate(invalid="ignore"):
        possible: Mask = (physical[:, 0] > 0.0) & np.all(physical[:, 1:] >= 0.0, axis=1)
    return possible


def _listed(names: tuple[str, ...], values: Array) -> str:
    return ", ".join(f"{name} {value:.2f}" for name, value in zip(names, values, strict=True))


def _listed_physical(ranges: list[Array]) -> str:
    return _listed(tuple(SYMBOLS[name] for name in ESTIMATED), np.median(ranges, axis=0))
