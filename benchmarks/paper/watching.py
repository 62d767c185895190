"""What each way of identification makes of a record of the robot (Figs 9, 11, 12)."""

from typing import NamedTuple

import numpy as np

from adaptive_ff.friction.model import ESTIMATED
from adaptive_ff.learning.batch import Array, Mask, slides_one_way
from adaptive_ff.learning.batch_least_squares import LeastSquaresFit, fit_least_squares
from adaptive_ff.learning.series import COEFFICIENTS, write_physical
from adaptive_ff.learning.torque_form import TorqueForm
from benchmarks.paper.data import TRUE, predict, rms
from benchmarks.paper.identification import FIRST, regression, run_rls, run_torque_form, series_free_run
from benchmarks.paper.robot import GAINS, PERIOD, SCENARIO, Drive, build_robot_setup, drive

FORGETTING = 0.85  # lambda of section V-E
COVARIANCE = 1e4  # diagonal of R0; the paper says "large"
TRANSIENT = 5.0  # s, not counted in errors
FILTER_POLE = GAINS[0] / SCENARIO.feedback.inertia  # rad/s, as the adaptive controller chooses it
SLOWEST = 0.01  # rad/s, speed of the gate
HOLD = 3.0 / FILTER_POLE  # s, hold of the gate
NEAR_REST = 0.02  # rad/s; closer to rest an equation of (4) may be false


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
    rad/s, of the model that is simulated with the last of them: ``online`` one step ahead, ``free`` from its outputs.
    """

    estimates: Array
    errors: dict[str, Array]


class Watched(NamedTuple):
    """A record, and what the series (4) and the torque form make of it."""

    record: Drive
    series: Series
    form: Form


def watch(seed: int) -> Watched:
    """Record a drive with the PI loop and identify from it in every way."""
    record = drive(build_robot_setup(seed))
    return Watched(record, fit_series(record), fit_form(record))


def fit_series(record: Drive, *, forgetting_factor: float = FORGETTING) -> Series:
    """Identify the coefficients of (4) offline and online."""
    rows, outputs = regression(record.velocity, record.acting)
    used = slides_one_way(record.velocity, NEAR_REST)[FIRST:]
    offline = fit_least_squares(rows, outputs, names=COEFFICIENTS)
    sliding = fit_least_squares(rows[used], outputs[used], names=COEFFICIENTS)
    online = run_rls(rows, outputs, forgetting_factor, COVARIANCE)
    start = np.zeros(FIRST)
    errors = {
        "offline": np.append(start, offline.residuals),
        "free": record.velocity - series_free_run(offline.values, record.velocity, record.acting),
        "prior": np.append(start, online.errors),
        "posterior": np.append(start, outputs - np.sum(rows * online.estimates, axis=1)),
    }
    return Series(offline, sliding, np.vstack([np.zeros((FIRST, len(COEFFICIENTS))), online.estimates]), errors)


def fit_form(record: Drive) -> Form:
    """Identify the physical parameters by the torque form, with the real time steps."""
    torque_form = TorqueForm(FILTER_POLE, TRUE.stribeck_velocity, TRUE.stribeck_shape)
    first = np.array([SCENARIO.feedback.inertia, 0.0, 0.0, 0.0, 0.0])
    estimates = run_torque_form(torque_form, (SLOWEST, HOLD), first, record.time, record.velocity, record.acting)
    last = estimates[-1:]
    errors = {
        name: record.velocity - predict_record(last, record, one_step=name == "online") for name in ("online", "free")
    }
    return Form(estimates, errors)


def predict_record(model: Array, record: Drive, *, one_step: bool) -> Array:
    """Return the velocity (rad/s) of a simulated model, shape (1, 5), along a record; see :func:`predict`."""
    series = record.steps, record.acting, record.velocity
    return predict(model, *series, one_step=one_step, period=SCENARIO.joint.solver_period)


def physical_of(coefficients: Array) -> Array:
    """Return the physical parameters that coefficients of (4) stand for, shape (5,); not numbers where none."""
    physical = np.full(len(ESTIMATED), np.nan)
    write_physical(np.ascontiguousarray(coefficients), PERIOD, physical)
    return physical


def settled_rms(record: Drive, errors: Array) -> float:
    """Return the rms of errors after the transient, in mrad/s."""
    return 1e3 * rms(errors[record.time >= TRANSIENT])


def physical_series(coefficients: Array) -> Array:
    """Return the physical parameters for each row of coefficients, shape (n, 5); not numbers where there are none."""
    return np.array([physical_of(row) for row in coefficients])


def is_possible(physical: Array) -> Mask:
    """Tell which rows are a joint: positive inertia, friction and lag not negative."""
    with np.errstate(invalid="ignore"):
        possible: Mask = (physical[:, 0] > 0.0) & np.all(physical[:, 1:] >= 0.0, axis=1)
    return possible
