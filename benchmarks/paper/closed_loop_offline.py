"""Section V-D, Fig. 9: the offline fit on data of the closed loop, and what spoils it."""

from collections.abc import Callable
from typing import Any

import numpy as np

from adaptive_ff.learning.batch import Array, Mask
from adaptive_ff.learning.batch_least_squares import fit_least_squares
from benchmarks.paper.experiment import Row
from benchmarks.paper.identification_data import TRUE
from benchmarks.paper.prediction import regression
from benchmarks.paper.robot import CURRENT_STEP, Drive, build_robot_setup, drive, drive_behind_interface
from benchmarks.paper.summaries import median_and_range, median_deviation
from benchmarks.paper.watching import NEAR_REST, Seen, fit_series, identify_form, physical_of, settled_rms

LATE = 0.025  # s; a longer sampling time is an outlier
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
