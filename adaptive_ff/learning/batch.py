"""Identification of a joint from a whole record at once: by the paper's series (4), or by the torque form.

Both take the torque as an array ``torque[k]`` that belongs to the period which ends at sample ``k``. With a held torque
that is the one commanded at ``k - 1``: ``numpy.roll(commanded, 1)``. The first entry is not used.
"""

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from adaptive_ff.friction.identifying import check_parameters
from adaptive_ff.friction.model import ESTIMATED, TorqueModel
from adaptive_ff.learning.batch_least_squares import Array, Estimate, LeastSquaresFit, fit_least_squares
from adaptive_ff.learning.checks import check_all
from adaptive_ff.learning.series import COEFFICIENTS, series_regressors, write_physical
from adaptive_ff.learning.torque_form import (
    Signals,
    TorqueForm,
    advance_signals_in_place,
    initial_signals,
    write_regressors,
)
from controllers import check_positive, compiled
from controllers.arrays import ArrayLike, NDArray
from controllers.checks import check_numbers, checked_array

Mask = NDArray[np.bool_]

FILTER_MEMORY = 6.0
"""Time constants of the filters after which they have forgotten an error: the equations are correlated that long."""


@dataclass(frozen=True, eq=False)
class Identification:
    """A joint identified from a record."""

    regression: LeastSquaresFit  # the fit behind it
    # inertia (kg m^2), Coulomb friction, stiction (N m), viscous coefficient (N m s/rad), friction lag (s), and what
    # else was asked for, by the names of ``TorqueModel``, with confidence intervals
    physical: dict[str, Estimate]
    # the same with the given Stribeck velocity and shape; nothing is confined to what is physically possible
    model: TorqueModel
    used: Mask  # shape (n,); samples whose equation took part


def identify_series(
    velocity: ArrayLike,
    torque: ArrayLike,
    period: float,
    *,
    stribeck_velocity: float,
    stribeck_shape: float = 1.0,
    use: ArrayLike | None = None,
    confidence: float = 0.95,
) -> Identification:
    """Identify a joint by the paper's series (4), equations (7)-(9).

    Parameters
    ----------
    velocity, torque : array_like, shape (n,)
        Velocity at the samples (rad/s), and the ``u(k)`` of (4), N m. Handing in the commanded torque instead of the
        one that acted over the period which ends at ``k`` is the other reading of the paper; it biases the result.
    period : float
        Sampling period, s.
    stribeck_velocity, stribeck_shape : float
        Pre-estimated ``Vs`` (rad/s) and ``delta``.
    use : array_like of bool, shape (n,), optional
        Samples ``k`` whose equation counts, such as ``slides_one_way`` gives; all by default, as in the paper.
    confidence : float, optional
        Probability of the intervals; those of physical parameters are carried over to first order.

    Raises
    ------
    ValueError
        Arguments are of the wrong shape, not finite or out of range, too few samples are used, or the coefficients
        are those of no joint.
    """
    speeds, torques = _check_series(velocity=velocity, torque=torque)
    check_positive(period=period, stribeck_velocity=stribeck_velocity, stribeck_shape=stribeck_shape)
    used = np.ones(speeds.size, dtype=np.bool_) if use is None else np.array(use)
    if used.shape != speeds.shape or used.dtype != np.bool_:
        raise ValueError(f"use has shape {used.shape} and type {used.dtype}; it must be {speeds.shape} and bool")
    used[:2] = False
    rows = np.zeros((speeds.size, len(COEFFICIENTS)))
    series_rows(speeds, torques, float(stribeck_velocity), float(stribeck_shape), rows)
    fit = fit_least_squares(rows[used], speeds[used], names=COEFFICIENTS, confidence=confidence)
    physical = np.empty(len(ESTIMATED))
    if not write_physical(fit.values, period, physical):
        b0, b1 = fit.values[2:4]
        raise ValueError(f"b0 = {b0:g} and b1 = {b1:g} came out; b0 must be larger than b1 for there to be a joint")
    slopes = _physical_slopes(fit.values, period)
    errors = np.sqrt(np.einsum("ij,jk,ik->i", slopes, fit.covariance, slopes))
    return _identification(fit, ESTIMATED, physical, errors, used, (stribeck_velocity, stribeck_shape))


def identify_torque_form(
    time: ArrayLike,
    velocity: ArrayLike,
    torque: ArrayLike,
    *,
    stribeck_velocity: float,
    stribeck_shape: float = 1.0,
    filter_pole: float,
    slowest: float,
    hold: float,
    parameters: Sequence[str] = ESTIMATED,
    confidence: float = 0.95,
) -> Identification:
    """Identify a joint by the filtered torque form, on the samples that its gate lets through.

    Parameters
    ----------
    time, velocity, torque : array_like, shape (n,)
        Time of the samples (s), increasing, velocity there (rad/s), linear in between, and torque over the period that
        ends there (N m).
    stribeck_velocity, stribeck_shape : float
        Pre-estimated ``Vs`` (rad/s) and ``delta``.
    filter_pole : float
        Pole of the filters, rad/s.
    slowest, hold : float
        Gate: speed below which the joint may stick, rad/s, and for how long it must have been faster, s; at the start
        twice as long.
    parameters : sequence of str, optional
        What is identified: ``ESTIMATED``, ``WITH_OFFSET`` or ``PER_DIRECTION`` of :mod:`adaptive_ff.friction.model`.
    confidence : float, optional
        Probability of the intervals; they take the correlation of filtered errors into account.

    Raises
    ------
    ValueError
        Arguments are of the wrong shape, not finite or out of range, or too few samples pass the gate.
    """
    times, speeds, torques = _check_series(time=time, velocity=velocity, torque=torque)
    steps = np.diff(times)
    if np.any(steps <= 0.0):
        place = int(np.argmax(steps <= 0.0)) + 1
        raise ValueError(f"time[{place}] = {times[place]} s is not allowed: it must be later than the one before")
    check_positive(stribeck_velocity=stribeck_velocity, stribeck_shape=stribeck_shape, filter_pole=filter_pole)
    _check_not_negative(slowest=slowest, hold=hold)
    names = check_parameters(parameters)
    columns = ("inertia_lag", *names)  # the first is ``J tau``
    form = TorqueForm(float(filter_pole), float(stribeck_velocity), float(stribeck_shape))
    rows, outputs = np.zeros((times.size, len(columns))), np.zeros(times.size)
    used = np.zeros(times.size, dtype=np.bool_)
    signals = initial_signals(form, len(names), float(speeds[0]))
    torque_form_rows(form, signals, times, speeds, torques, (float(slowest), float(hold)), rows, outputs, used)
    correlated = math.ceil(FILTER_MEMORY / (filter_pole * float(np.median(steps))))
    count, needed = int(np.count_nonzero(used)), max(len(columns), correlated)
    if count <= needed:
        raise ValueError(
            f"slowest = {slowest:g} rad/s and hold = {hold:g} s let {count} samples through; there must be more than "
            f"{needed}"
        )
    fit = fit_least_squares(
        rows[used], outputs[used], names=columns, confidence=confidence, correlated_samples=correlated
    )
    places = [columns.index(name) for name in names]
    values, errors = fit.values[places], fit.standard_errors[places]
    return _identification(fit, names, values, errors, used, (stribeck_velocity, stribeck_shape))


def slides_one_way(velocity: ArrayLike, slowest: float) -> Mask:
    """Tell which equations of (4) are taken from sliding motion that does not reverse.

    Parameters
    ----------
    velocity : array_like, shape (n,)
        Velocity at the samples, rad/s.
    slowest : float
        Speed below which the joint may stick, rad/s.

    Returns
    -------
    ndarray of bool, shape (n,)
        Whether ``w(k)``, ``w(k-1)`` and ``w(k-2)`` are at least as fast and of one sign.
    """
    speeds = checked_array("velocity", velocity)
    direction = np.where(np.abs(speeds) >= slowest, np.sign(speeds), 0.0)
    found = np.zeros(speeds.size, dtype=np.bool_)
    found[2:] = (direction[2:] != 0.0) & (direction[2:] == direction[1:-1]) & (direction[2:] == direction[:-2])
    return found


def _physical_slopes(coefficients: Array, period: float) -> Array:
    """Return the derivatives of ``J, Fc, Fs, sigma, tau`` by the coefficients of (4), shape (5, 6)."""
    a1, a2, b0, b1, c1, d1 = coefficients
    span = b0 - b1
    slopes = np.zeros((len(ESTIMATED), len(COEFFICIENTS)))
    numerators = (period * (a1 - 2.0 * a2), c1, d1, 1.0 - a1 + a2, period * b1)  # each over b0 - b1
    for row, numerator in zip(slopes, numerators, strict=True):
        row[2], row[3] = -numerator / span**2, numerator / span**2
    slopes[0, :2] = period / span, -2.0 * period / span
    slopes[1, 4] = slopes[2, 5] = 1.0 / span
    slopes[3, :2] = -1.0 / span, 1.0 / span
    slopes[4, 3] += period / span
    return slopes


def _identification(
    fit: LeastSquaresFit,
    names: tuple[str, ...],
    values: Array,
    errors: Array,
    used: Mask,
    stribeck: tuple[float, float],
) -> Identification:
    pairs = zip(values, errors, strict=True)
    physical = {
        name: fit.interval(float(value), float(error)) for name, (value, error) in zip(names, pairs, strict=True)
    }
    found = {name: estimate.value for name, estimate in physical.items()}
    model = TorqueModel(**found, stribeck_velocity=float(stribeck[0]), stribeck_shape=float(stribeck[1]))
    return Identification(fit, physical, model, used)


def _check_not_negative(**values: float) -> None:
    check_numbers(**values)
    for name, value in values.items():
        if not (math.isfinite(value) and value >= 0.0):
            raise ValueError(f"{name} = {value} is not allowed: it must be zero or more and finite")


def _check_series(**series: ArrayLike) -> list[Array]:
    checked: list[Array] = []
    for name, given in series.items():
        array = np.ascontiguousarray(checked_array(name, given))
        if array.ndim != 1 or array.size < 3:
            raise ValueError(f"{name} has shape {array.shape}; it must be a series of three samples at least")
        if checked and array.shape != checked[0].shape:
            raise ValueError(
                f"{name} has {array.size} samples; it must have {checked[0].size}, as {next(iter(series))}"
            )
        check_all(name, array, np.isfinite(array))
        checked.append(array)
    return checked


@compiled
def series_rows(velocity: Array, torque: Array, stribeck_velocity: float, stribeck_shape: float, rows: Array) -> None:
    """Write the regressors of (4) of each sample, from the third on, into the rows."""
    for k in range(2, velocity.size):
        series_regressors(
            rows[k], (velocity[k - 1], velocity[k - 2]), (torque[k], torque[k - 1]), stribeck_velocity, stribeck_shape
        )


@compiled
def torque_form_rows(
    form: TorqueForm,
    signals: Signals,
    time: Array,
    velocity: Array,
    torque: Array,
    gate: tuple[float, float],
    rows: Array,
    outputs: Array,
    used: Mask,
) -> None:
    """Write regressors, outputs and whether the gate is open; the gate is its speed (rad/s) and hold (s).

    Slower than the gate the joint may stick, where friction is whatever the torque is and an equation false; a filter
    remembers it for a few of its time constants, so the gate opens a hold after. A reversal so fast that both samples
    around it are above the speed of the gate does not close it: the joint cannot have stuck for long, and the filters
    split it where it happens.
    """
    sliding = -gate[1]
    for k in range(1, time.size):
        duration = time[k] - time[k - 1]
        signals = advance_signals_in_place(form, signals, torque[k], velocity[k], duration)
        sliding = sliding + duration if abs(velocity[k]) >= gate[0] and velocity[k] != 0.0 else 0.0
        outputs[k] = write_regressors(form, signals, rows[k])
        used[k] = sliding > gate[1]
