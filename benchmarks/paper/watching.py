"""What each way of identification makes of a record of the robot (Figs 9, 11, 12)."""

from typing import NamedTuple

import numpy as np

from adaptive_ff.adaptive.controller import AdaptiveController
from adaptive_ff.friction.model import ESTIMATED, TorqueModel
from adaptive_ff.learning.batch import Array, Identification, identify_torque_form, slides_one_way
from adaptive_ff.learning.batch_least_squares import LeastSquaresFit, fit_least_squares
from adaptive_ff.learning.series import COEFFICIENTS, write_physical
from adaptive_ff.learning.torque_form import TorqueForm
from benchmarks.paper.identification_data import TRUE, joint_of
from benchmarks.paper.prediction import FIRST, regression, rms, series_free_run
from benchmarks.paper.recursion import run_rls, run_torque_form
from benchmarks.paper.robot import GAINS, PERIOD, SCENARIO, Drive, build_robot_setup, drive, predict

FORGETTING = 0.85  # lambda of section V-E
COVARIANCE = 1e4  # diagonal of R0; the paper says "large"
TRANSIENT = 5.0  # s, not counted in errors
FILTER_POLE = GAINS[0] / SCENARIO.feedback.inertia  # rad/s, as the adaptive controller chooses it
SLOWEST = 0.01  # rad/s, speed of the gate
HOLD = 3.0 / FILTER_POLE  # s, hold of the gate
NEAR_REST = 0.02  # rad/s; closer to rest an equation of (4) may be false


class Series(NamedTuple):
    """What the series (4) makes of a record: offline, and online with forgetting.

    Attributes
    ----------
    offline : LeastSquaresFit
        Least squares over the whole record, (9), as in the paper.
    sliding : LeastSquaresFit
        The same over samples that slide one way.
    coefficients : ndarray, shape (n, 6)
        Coefficients of (4) after each sample, by RLS.
    errors : dict of ndarray, shape (n,)
        Measured minus predicted velocity, rad/s: ``offline`` one step ahead, ``free`` from the offline fit's own
        outputs; ``prior`` with RLS's coefficients of the sample before, (10), and ``posterior`` with those of the
        sample that is "predicted".
    """

    offline: LeastSquaresFit
    sliding: LeastSquaresFit
    coefficients: Array
    errors: dict[str, Array]


class Form(NamedTuple):
    """What the torque form with its gate makes of a record.

    Attributes
    ----------
    offline : Identification
        Gated least squares over the whole record.
    estimates : ndarray, shape (n, 5)
        Physical parameters after each sample, by recursive least squares over the same rows.
    errors : dict of ndarray, shape (n,)
        Measured minus predicted velocity, rad/s, of the model that is simulated with the last estimates: ``online`` one
        step ahead, ``free`` from its own outputs; ``true`` and ``true_free`` the same of the true joint.
    """

    offline: Identification
    estimates: Array
    errors: dict[str, Array]


class Seen(NamedTuple):
    """A record and what was made of it.

    Attributes
    ----------
    record : Drive
        The record.
    series : Series
        By the series (4).
    form : Form
        By the torque form.
    """

    record: Drive
    series: Series
    form: Form


def watch(seed: int) -> Seen:
    """Record a drive with the PI loop and identify from it in every way."""
    record = drive(build_robot_setup(seed))
    return Seen(record, fit_series(record), fit_form(record))


def fit_series(record: Drive, *, forgetting_factor: float = FORGETTING) -> Series:
    """Identify the coefficients of (4) offline and online."""
    rows, outputs = regression(record.velocity, record.acting)
    used = slides_one_way(record.velocity, NEAR_REST)[FIRST:]
    offline = fit_least_squares(rows, outputs, names=COEFFICIENTS)
    sliding = fit_least_squares(rows[used], outputs[used], names=COEFFICIENTS)
    online = run_rls(rows, outputs, forgetting_factor, COVARIANCE)
    posterior = outputs - np.sum(rows * online.estimates, axis=1)
    start = np.zeros(FIRST)
    errors = {
        "offline": np.append(start, offline.residuals),
        "free": record.velocity - series_free_run(offline.values, record.velocity, record.acting),
        "prior": np.append(start, online.errors),
        "posterior": np.append(start, posterior),
    }
    coefficients = np.vstack([np.zeros((FIRST, len(COEFFICIENTS))), online.estimates])
    return Series(offline, sliding, coefficients, errors)


def fit_form(record: Drive) -> Form:
    """Identify the physical parameters by the torque form, offline and online."""
    torque_form = TorqueForm(FILTER_POLE, TRUE.stribeck_velocity, TRUE.stribeck_shape)
    first = np.array([SCENARIO.feedback.inertia, 0.0, 0.0, 0.0, 0.0])
    estimates = run_torque_form(torque_form, (SLOWEST, HOLD), first, record.time, record.velocity, record.acting)
    joints = {"": joint_of(model_of(estimates[-1])), "true": joint_of(TRUE)}
    errors = {}
    for name, joint in joints.items():
        errors[name or "online"] = record.velocity - predict(joint, record, one_step=True)
        errors[f"{name}_free".strip("_")] = record.velocity - predict(joint, record, one_step=False)
    return Form(identify_form(record), estimates, errors)


def identify_form(record: Drive) -> Identification:
    """Identify by gated least squares on the torque form, with the real time steps."""
    return identify_torque_form(
        record.time,
        record.velocity,
        record.acting,
        stribeck_velocity=TRUE.stribeck_velocity,
        stribeck_shape=TRUE.stribeck_shape,
        filter_pole=FILTER_POLE,
        slowest=SLOWEST,
        hold=HOLD,
    )


def adaptive() -> AdaptiveController:
    """Return the adaptive controller for this loop, with the true Vs and delta, as the paper assumes them known."""
    return AdaptiveController(
        *GAINS,
        PERIOD,
        inertia=SCENARIO.feedback.inertia,
        stribeck_velocity=TRUE.stribeck_velocity,
        stribeck_shape=TRUE.stribeck_shape,
        parameters=ESTIMATED,
    )


def model_of(physical: Array) -> TorqueModel:
    """Return the model with five physical parameters."""
    return TorqueModel(*(float(value) for value in physical), TRUE.stribeck_velocity, TRUE.stribeck_shape)


def physical_of(coefficients: Array) -> Array:
    """Return the physical parameters that coefficients of (4) stand for, shape (5,); not numbers where none."""
    physical = np.full(len(ESTIMATED), np.nan)
    write_physical(np.ascontiguousarray(coefficients), PERIOD, physical)
    return physical


def settled_rms(record: Drive, errors: Array) -> float:
    """Return the rms of errors after the transient, in mrad/s."""
    return 1e3 * rms(errors[record.time >= TRANSIENT])
