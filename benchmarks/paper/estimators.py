"""Identification of the joint and prediction of its velocity, one sample ahead and on its own, by (4) and by Fig. 2."""

import math
from typing import NamedTuple

import numpy as np

from adaptive_ff.friction.model import ESTIMATED, TorqueModel
from adaptive_ff.learning.batch import (
    Identification,
    Mask,
    identify_series,
    identify_torque_form,
    series_rows,
    slides_one_way,
    torque_form_rows,
)
from adaptive_ff.learning.batch_least_squares import Array, LeastSquaresFit, fit_least_squares
from adaptive_ff.learning.rls import RLSState, initial_rls_state, update_rls_in_place
from adaptive_ff.learning.series import COEFFICIENTS, series_regressors, write_physical
from adaptive_ff.learning.torque_form import TorqueForm, initial_signals
from benchmarks.paper.records import CURVE, PERIOD, Record, predict
from controllers import compiled, pi_gains

FIRST = 2  # first sample that (4) can predict
FILTER_POLE = 60.0  # rad/s, of the torque form offline
SLOWEST = 0.01  # rad/s, speed of the gate
HOLD = 3.0  # hold of the gate, time constants of the filters
NEAR_REST = 0.02  # rad/s; closer to rest an equation of (4) may be false
VAGUE = 1e6  # variance of what the torque form begins with, in squares of the units of its columns


def regression(velocity: Array, torque: Array) -> tuple[Array, Array]:
    """Return regressors and outputs of (4), shapes (n - 2, 6) and (n - 2,), with the true Vs and delta."""
    rows = np.zeros((velocity.size, len(COEFFICIENTS)))
    velocity, torque = np.ascontiguousarray(velocity), np.ascontiguousarray(torque)
    series_rows(velocity, torque, *CURVE.values(), rows)
    return rows[FIRST:], velocity[FIRST:]


def series_one_step(coefficients: Array, velocity: Array, torque: Array) -> Array:
    """Return the one-step prediction errors of (4), rad/s; zero for the first two samples."""
    rows, outputs = regression(velocity, torque)
    return np.append(np.zeros(FIRST), outputs - rows @ coefficients)


def series_free_run(coefficients: Array, velocity: Array, torque: Array) -> Array:
    """Return the velocity (rad/s) that (4) produces from its own outputs, started with the first two samples."""
    motion, row = velocity.copy(), np.zeros(len(COEFFICIENTS))
    run_series(np.ascontiguousarray(coefficients), np.ascontiguousarray(torque), *CURVE.values(), row, motion)
    return motion


def _run_series(
    coefficients: Array, torque: Array, stribeck_velocity: float, stribeck_shape: float, row: Array, velocity: Array
) -> None:
    for k in range(2, velocity.size):
        series_regressors(
            row, (velocity[k - 1], velocity[k - 2]), (torque[k], torque[k - 1]), stribeck_velocity, stribeck_shape
        )
        total = 0.0
        for i in range(row.size):
            total += row[i] * coefficients[i]
        velocity[k] = total if math.isfinite(total) else math.inf


run_series = compiled(_run_series)


def filtered(record: Record) -> Identification:
    """Identify by the torque form with its gate."""
    gate = {"filter_pole": FILTER_POLE, "slowest": SLOWEST, "hold": HOLD / FILTER_POLE}
    return identify_torque_form(record.time, record.velocity, record.acting, **CURVE, **gate)


def series(velocity: Array, torque: Array, *, sliding: bool, period: float = PERIOD) -> Identification:
    """Identify by (4), from all samples or from those that slide one way."""
    use = slides_one_way(velocity, SLOWEST) if sliding else None
    return identify_series(velocity, torque, period, **CURVE, use=use)


def model_of(physical: Array) -> TorqueModel:
    """Return the model with five physical parameters."""
    return TorqueModel(*(float(value) for value in physical), *CURVE.values())


def run_rls(
    regressors: Array, outputs: Array, forgetting_factor: float, covariance: float, first: Array | None = None
) -> tuple[Array, Array]:
    """Return the estimate after each row, (m, n), and the prediction errors before each, (m,), by (10)-(13).

    The first estimate is zero by default; ``R0`` is ``covariance`` times the identity.
    """
    size = regressors.shape[1]
    state = initial_rls_state(np.zeros(size) if first is None else first, covariance * np.eye(size))
    found = np.zeros(regressors.shape), np.zeros(outputs.size)
    rls_loop(state, regressors, outputs, forgetting_factor, *found)
    return found


def _rls_loop(
    state: RLSState, regressors: Array, outputs: Array, forgetting_factor: float, estimates: Array, errors: Array
) -> None:
    for k in range(outputs.size):
        errors[k] = update_rls_in_place(state, regressors[k], outputs[k], forgetting_factor)
        for i in range(state.estimate.size):
            estimates[k, i] = state.estimate[i]


rls_loop = compiled(_rls_loop)


class Series(NamedTuple):
    """What the series (4) makes of a record: offline, and online with forgetting.

    ``offline``: least squares over the whole record, (9), as in the paper; ``sliding``: the same over samples that
    slide one way; ``coefficients`` (n, 6): coefficients of (4) after each sample, by RLS; ``errors`` (n,): measured
    minus predicted velocity, rad/s: ``offline`` one step ahead, ``free`` from the offline fit's own outputs; ``prior``
    with RLS's coefficients of the sample before, (10), and ``posterior`` with those of the sample that is "predicted".
    """

    offline: LeastSquaresFit
    sliding: LeastSquaresFit
    coefficients: Array
    errors: dict[str, Array]


class Form(NamedTuple):
    """What the torque form with its gate makes of a record, by recursive least squares.

    ``estimates`` (n, 5): physical parameters after each sample; ``errors`` (n,): measured minus predicted velocity,
    rad/s: ``prior`` one step ahead with those of the sample before; with the last of them ``online`` one step ahead,
    ``free`` from its own outputs.
    """

    estimates: Array
    errors: dict[str, Array]


class Watched(NamedTuple):
    """A record, and what the series (4) and the torque form make of it."""

    record: Record
    series: Series
    form: Form


def fit_series(record: Record, forgetting_factor: float, covariance: float) -> Series:
    """Identify the coefficients of (4) offline and online, from ``R0`` a multiple of the identity."""
    rows, outputs = regression(record.velocity, record.acting)
    used = slides_one_way(record.velocity, NEAR_REST)[FIRST:]
    offline = fit_least_squares(rows, outputs, names=COEFFICIENTS)
    sliding = fit_least_squares(rows[used], outputs[used], names=COEFFICIENTS)
    online, prior = run_rls(rows, outputs, forgetting_factor, covariance)
    start = np.zeros(FIRST)
    errors = {
        "offline": np.append(start, offline.residuals),
        "free": record.velocity - series_free_run(offline.values, record.velocity, record.acting),
        "prior": np.append(start, prior),
        "posterior": np.append(start, outputs - np.sum(rows * online, axis=1)),
    }
    return Series(offline, sliding, np.vstack([np.zeros((FIRST, len(COEFFICIENTS))), online]), errors)


def fit_form(record: Record, inertia: float, bandwidth: float) -> Form:
    """Identify by the rows of the torque form that its gate lets through, with the real time steps.

    The first estimate is an inertia (kg m^2) alone, as vague as ``VAGUE`` says; the pole of the filters is that which
    the adaptive controller chooses in a loop of a bandwidth (Hz) around it.
    """
    pole = pi_gains(inertia, bandwidth)[0] / inertia
    torque_form, columns = TorqueForm(pole, *CURVE.values()), ("inertia_lag", *ESTIMATED)
    count, places = record.time.size, [columns.index(name) for name in ESTIMATED]
    rows, outputs, used = np.zeros((count, len(columns))), np.zeros(count), np.zeros(count, dtype=np.bool_)
    signals = initial_signals(torque_form, len(ESTIMATED), float(record.velocity[0]))
    measured = map(np.ascontiguousarray, (record.time, record.velocity, record.acting))
    torque_form_rows(torque_form, signals, *measured, (SLOWEST, HOLD / pole), rows, outputs, used)
    begun = np.zeros(len(columns))
    begun[places[0]] = inertia
    found, _ = run_rls(rows[used], outputs[used], 1.0, VAGUE, begun)
    estimates = np.ascontiguousarray(np.vstack([begun, found])[np.cumsum(used)][:, places])
    ways = {"prior": (estimates, True), "online": (estimates[-1:], True), "free": (estimates[-1:], False)}
    errors = {name: record.velocity - predict(one, record, one_step=step) for name, (one, step) in ways.items()}
    return Form(estimates, errors)


def physical_series(coefficients: Array, period: float) -> Array:
    """Return the physical parameters for each row of coefficients, shape (n, 5); not numbers where there are none."""
    physical = np.full((len(coefficients), len(ESTIMATED)), np.nan)
    for values, row in zip(np.ascontiguousarray(coefficients), physical, strict=True):
        write_physical(values, period, row)
    return physical


def is_possible(physical: Array) -> Mask:
    """Tell which rows are a joint: positive inertia, friction and lag not negative."""
    with np.errstate(invalid="ignore"):
        return np.asarray((physical[:, 0] > 0.0) & np.all(physical[:, 1:] >= 0.0, axis=1))
