"""Sections V-B to V-E, Figs 7 and 9 to 12: identification from a closed loop with poor data, and what it is worth.

Each of the identified parameters is fed forward on the robot of section V, along another motion than the record's.
"""

import math
from collections.abc import Sequence

import numpy as np

from adaptive_ff.baselines.model_based import ModelBased
from adaptive_ff.baselines.paper import PaperController
from adaptive_ff.friction.model import TorqueModel
from adaptive_ff.learning.batch import Array
from benchmarks.paper import robot_figures
from benchmarks.paper.data import MORE_SEEDS, SEED, TRUE, rms
from benchmarks.paper.experiment import Experiment, Row, median_and_range, median_deviation, notes
from benchmarks.paper.identification import model_of
from benchmarks.paper.robot import (
    CURRENT_STEP,
    GAINS,
    LATE,
    NOISE,
    PERIOD,
    SCENARIO,
    SOLVER_PERIOD,
    TORQUE_CONSTANT,
    Drive,
    build_robot_setup,
    drive,
)
from benchmarks.paper.watching import (
    FORGETTING,
    TRANSIENT,
    Watched,
    is_possible,
    physical_of,
    physical_series,
    settled_rms,
    watch,
)
from controllers import PI, Controller

DRAWN = (robot_figures.figure_09, robot_figures.figure_11, robot_figures.figure_12)
OTHER_MOTION = 1000  # added to the seed of a record: the motion on which what it gave is fed forward
ALONE = "PI alone"
OFFLINE = "PI + offline LS on (4)"
ONLINE = f"PI + RLS on (4), lambda {FORGETTING:g}, as it learns"
FORM = "PI + torque form, identified on another motion"
ORACLE = "PI + true parameters"
PRIOR = "a-priori error, rms"
POSTERIOR = "a-posteriori error, rms"
TO_FREE = "a-priori error, rms, against the free run of the offline fit"


def run() -> Experiment:
    """Run everything on all seeds; draw the first. Figures of several seeds are medians with their range."""
    watched = {seed: watch(seed) for seed in MORE_SEEDS}
    every, record = list(watched.values()), watched[SEED].record
    rows = [*data_rows(record), *identification_rows(every), *control_rows(watched)]
    figures = {
        "figure_07": robot_figures.figure_07(record),
        "figure_10": robot_figures.figure_10(record),
        **{draw.__name__: draw(*watched[SEED]) for draw in DRAWN},
    }
    return Experiment("Sections V-B to V-E, Figs 7, 9 to 12: closed loop", rows, notes("closed_loop"), figures)


def data_rows(record: Drive) -> list[Row]:
    """Return what the data are like (Figs 7 and 10)."""
    durations = np.diff(record.time)
    mean, largest = float(np.mean(durations)), float(np.max(durations))
    return [
        Row("Fig. 10: sampling time, mean, ms", 1e3 * mean, "about 22", 21.5 <= 1e3 * mean <= 22.5),
        Row("Fig. 10: largest sampling time / mean", largest / mean, "almost 2", 1.8 <= largest / mean <= 2.0),
        Row("Fig. 10: samples that come late, %", 100.0 * float(np.mean(durations > LATE))),
        Row("Fig. 7: resolution of the torque K i, N m", TORQUE_CONSTANT * CURRENT_STEP),
        Row("V-B: largest speed of the reference, deg/s", float(np.degrees(np.max(np.abs(record.reference))))),
    ]


def identification_rows(every: Sequence[Watched]) -> list[Row]:
    """Return how well fits predict and what they say of the joint (Figs 9, 12), and RLS beside them (Fig. 11)."""
    errors = {
        "Fig. 9: one-step error of the offline LS": [(one.record, one.series.errors["offline"]) for one in every],
        "Fig. 9: free-run error of the offline LS": [(one.record, one.series.errors["free"]) for one in every],
        "Fig. 9: one-step error of the torque form": [(one.record, one.form.errors["online"]) for one in every],
        "Fig. 9: free-run error of the torque form": [(one.record, one.form.errors["free"]) for one in every],
        f"Fig. 11: a-priori error of RLS (noise {1e3 * NOISE:g})": [
            (one.record, one.series.errors["prior"]) for one in every
        ],
        "Fig. 11: a-posteriori error of RLS": [(one.record, one.series.errors["posterior"]) for one in every],
    }
    estimates = {
        "offline LS on (4)": [physical_of(one.series.offline.values) for one in every],
        "the same, sliding samples only": [physical_of(one.series.sliding.values) for one in every],
        "torque form, online, at the end": [one.form.estimates[-1] for one in every],
    }
    found = [ratios(one) for one in every]
    possible = [100.0 * float(np.mean(is_possible(physical_series(late_coefficients(one))))) for one in every]
    return [
        *(
            Row(f"{name}, mrad/s rms", median_and_range([settled_rms(*error) for error in series]))
            for name, series in errors.items()
        ),
        *(Row(f"Fig. 9: {name}: off the truth by, %", median_deviation(values)) for name, values in estimates.items()),
        *(
            Row(f"Fig. 11: RLS at lambda {FORGETTING:g} / offline LS: {key}", median_and_range([f[key] for f in found]))
            for key in found[0]
        ),
        Row("Fig. 12: samples whose coefficients stand for a possible joint, %", median_and_range(possible, 1)),
    ]


def late_coefficients(one: Watched) -> Array:
    """Return the coefficients by RLS once the transient is over."""
    return one.series.coefficients[one.record.time >= TRANSIENT]


def ratios(one: Watched) -> dict[str, float]:
    """Return errors of RLS relative to those of the offline fit."""
    errors = {name: rms(values[one.record.time >= TRANSIENT]) for name, values in one.series.errors.items()}
    return {
        PRIOR: errors["prior"] / errors["offline"],
        POSTERIOR: errors["posterior"] / errors["offline"],
        TO_FREE: errors["prior"] / errors["free"],
    }


def make_controllers(offline: Array, form: Array) -> dict[str, Controller]:
    """Return the controllers that are compared.

    ``offline`` and ``form`` (5,) are the physical parameters by the offline fit of (4) and by the torque form. Where
    the coefficients of the first are those of no joint, there is nothing to feed forward.
    """
    made: dict[str, Controller] = {ALONE: PI(*GAINS, PERIOD)}
    if np.all(np.isfinite(offline)):
        made[OFFLINE] = ModelBased(*GAINS, PERIOD, possible(offline))
    made[ONLINE] = PaperController(
        *GAINS,
        PERIOD,
        inertia=SCENARIO.feedback.inertia,
        stribeck_velocity=TRUE.stribeck_velocity,
        stribeck_shape=TRUE.stribeck_shape,
        memory=-PERIOD / math.log(FORGETTING),
    )
    made[FORM] = ModelBased(*GAINS, PERIOD, possible(form))
    made[ORACLE] = ModelBased(*GAINS, PERIOD, TRUE)
    return made


def possible(physical: Array) -> TorqueModel:
    """Return the model of physical parameters: its lag not negative, its stiction at least its Coulomb friction."""
    model = model_of(physical)
    return model._replace(friction_lag=max(model.friction_lag, 0.0), stiction=max(model.stiction, model.coulomb))


def tracking_errors(one: Watched, seed: int) -> dict[str, float]:
    """Return the tracking error (mrad/s rms, true velocity) of each controller on another motion than the record's."""
    setup = build_robot_setup(seed + OTHER_MOTION)
    made = make_controllers(physical_of(one.series.offline.values), one.form.estimates[-1])
    after = round(TRANSIENT / SOLVER_PERIOD)
    return {name: 1e3 * rms(drive(setup, controller).tracking_error[after:]) for name, controller in made.items()}


def control_rows(watched: dict[int, Watched]) -> list[Row]:
    """Return the tracking errors of all controllers over the seeds."""
    found = [tracking_errors(one, seed) for seed, one in watched.items()]
    return [
        Row(
            f"Control: {name}: tracking error, mrad/s rms",
            median_and_range([each[name] for each in found if name in each]),
        )
        for name in found[0]
    ]
