"""Section III: the three misprints below (4), and what they do to a joint that is identified with them.

The fit (7)-(9) finds the coefficients of (4) whatever their names; misprints matter to who maps them to a joint or
back. With ``D = J tau + J Ts + sigma Ts^2`` the paper prints

    a1 = (J tau + J Ts)/D   instead of   (2 J tau + J Ts)/D
    b0 = (Ts^2 + tau Ts^2)/D   instead of   (Ts^2 + tau Ts)/D
    b1 = tau Ts^2/D   instead of   tau Ts/D
"""

import numpy as np

from adaptive_ff.friction.model import ESTIMATED, TorqueModel
from adaptive_ff.learning.batch_least_squares import Array
from adaptive_ff.learning.series import SeriesCoefficients, series_coefficients
from adaptive_ff.simulation.metrics import rms
from benchmarks.cases.reports import Row
from benchmarks.paper.estimators import physical_series, series, series_one_step
from benchmarks.paper.experiment import SYMBOLS, Experiment, notes
from benchmarks.paper.records import PERIOD, SEED, TRUE, simulate_noise

MILLISECOND = 1e-3  # s
EXACT = 1e-9  # relative difference below which two numbers count as equal

READINGS = {
    "corrected": (False, False),
    "a1 as printed": (True, False),
    "b0, b1 as printed": (False, True),
    "all as printed": (True, True),
}
"""Whether ``a1``, and ``b0`` and ``b1``, are taken as printed."""


def coefficients_of(model: TorqueModel, period: float, reading: str) -> SeriesCoefficients:
    """Return the coefficients of (4) in one of the readings for a joint sampled with a period in s."""
    inertia, lag, found = model.inertia, model.friction_lag, series_coefficients(model, period)
    denominator = inertia * lag + inertia * period + model.viscous * period**2
    printed_a1, printed_b = READINGS[reading]
    if printed_a1:
        found = found._replace(a1=(inertia * lag + inertia * period) / denominator)
    if printed_b:
        found = found._replace(b0=(period**2 + lag * period**2) / denominator, b1=lag * period**2 / denominator)
    return found


def joint_of_reading(coefficients: Array, period: float, reading: str) -> dict[str, float]:
    """Return the joint that coefficients of (4) stand for in one of the readings.

    As printed, ``a1 - a2 = J Ts/D``, ``1 - a1 = sigma Ts^2/D`` and ``tau = b1/(b0 - b1)``; in all readings
    ``b0 - b1 = Ts^2/D``, so the friction torques come out alike.
    """
    found = dict(zip(ESTIMATED, physical_series(coefficients[np.newaxis], period)[0].tolist(), strict=True))
    a1, a2, b0, b1 = (float(value) for value in coefficients[:4])
    printed_a1, printed_b = READINGS[reading]
    if printed_a1:
        found |= {"inertia": (a1 - a2) * period / (b0 - b1), "viscous": (1.0 - a1) / (b0 - b1)}
    return {**found, "friction_lag": b1 / (b0 - b1)} if printed_b else found


def in_other_unit_of_time(model: TorqueModel, seconds: float) -> TorqueModel:
    """Return the same joint with time counted in units of so many seconds."""
    return model._replace(
        inertia=model.inertia / seconds**2,
        viscous=model.viscous / seconds,
        friction_lag=model.friction_lag / seconds,
        stribeck_velocity=model.stribeck_velocity * seconds,
    )


def run() -> Experiment:
    """Show that the printed coefficients cannot be right, and what they cost."""
    data = simulate_noise(SEED)
    fitted = series(data.velocity, data.acting, sliding=True).regression.values
    rows = [*consistency_rows(), *joint_rows(fitted)]
    for name in READINGS:
        coefficients = np.array(coefficients_of(TRUE, PERIOD, name))
        error = rms(series_one_step(coefficients, data.velocity, data.acting))
        rows.append(Row(f"(4) of the true joint, {name}: one-step error on Fig. 4, mrad/s rms", 1e3 * error))
    rows.append(Row("velocity itself, mrad/s rms", 1e3 * rms(data.velocity)))
    return Experiment("Section III: misprints of a1, b0 and b1", rows, notes("misprints"))


def consistency_rows() -> list[Row]:
    """Return what any discretisation of (2) must satisfy, corrected and as printed."""
    free = TRUE._replace(coulomb=0.0, stiction=0.0, viscous=0.0)
    other = in_other_unit_of_time(TRUE, MILLISECOND)
    rows = []
    for name, reading in (("corrected", "corrected"), ("as printed", "all as printed")):
        kept = coefficients_of(free, PERIOD, reading)
        here, there = coefficients_of(TRUE, PERIOD, reading), coefficients_of(other, PERIOD / MILLISECOND, reading)
        values = {
            f"a1 - a2 without friction, {name}: velocity kept in a sample": kept.a1 - kept.a2,
            f"b1/b0 {name}: time in ms against time in s": (there.b1 / there.b0) / (here.b1 / here.b0),
        }
        for quantity, value in values.items():
            asked = ("1", abs(value - 1.0) < EXACT) if reading == "corrected" else ("", None)
            rows.append(Row(quantity, value, *asked))
    return rows


def joint_rows(fitted: Array) -> list[Row]:
    """Return the joint that one and the same fit stands for, with and without each misprint."""
    true = {name: getattr(TRUE, name) for name in ESTIMATED}
    rows = [Row(f"the true joint: {', '.join(SYMBOLS.values())}", in_words(true))]
    products: list[Row] = []
    product = float(fitted[1]) * PERIOD**2 / float(fitted[2] - fitted[3])
    for name in READINGS:
        found = joint_of_reading(fitted, PERIOD, name)
        rows.append(Row(f"the joint that one fit stands for, {name}", in_words(found)))
        products.append(Row(f"its J tau over J tau by a2, {name}", found["inertia"] * found["friction_lag"] / product))
    return rows + products


def in_words(parameters: dict[str, float]) -> str:
    """Return physical parameters as a line of text, SI units."""
    return ", ".join(f"{parameters[name]:.4g}" for name in ESTIMATED)
