"""Sections V-B to V-E, Figs 7 and 9 to 12: identification from a closed loop with poor data, and what it is worth.

Each of the identified parameters is fed forward on the robot of section V, along another motion than the record's.
"""

import math
from collections.abc import Callable, Sequence

import numpy as np

from adaptive_ff.baselines.model_based import ModelBased
from adaptive_ff.baselines.paper import PaperController
from adaptive_ff.friction.model import TorqueModel
from adaptive_ff.learning.batch import Array
from adaptive_ff.simulation.metrics import rms
from benchmarks.cases.reports import Row
from benchmarks.paper import figures, records
from benchmarks.paper.estimators import Watched, fit_form, fit_series, is_possible, model_of, physical_series
from benchmarks.paper.experiment import Experiment, in_words, median_and_range, notes
from benchmarks.paper.records import CURVE, FORGETTING, GAINS, MORE_SEEDS, ROBOT_PERIOD, SCENARIO, SEED, TRUE, Record
from controllers import PI, Controller

COVARIANCE = 1e4  # diagonal of R0; the paper says "large"
TRANSIENT = 5.0  # s, not counted in errors
OTHER_MOTION = 1000  # added to the seed of a record: the motion on which what it gave is fed forward
ALONE = "PI alone"
OFFLINE = "PI + offline LS on (4)"
ONLINE = f"PI + RLS on (4), lambda {FORGETTING:g}, as it learns"
FORM = "PI + torque form, identified on another motion"
ORACLE = "PI + true parameters"
PRIOR, POSTERIOR = "a-priori error, rms", "a-posteriori error, rms"


def watch(seed: int) -> Watched:
    """Record a drive with the PI loop and identify from it in every way."""
    record = records.drive(records.build_robot_setup(seed))
    form = fit_form(record, SCENARIO.feedback.inertia, records.BANDWIDTH)
    return Watched(record, fit_series(record, FORGETTING, COVARIANCE), form)


def physical_of(coefficients: Array) -> Array:
    """Return the physical parameters that coefficients of (4) stand for, shape (5,); not numbers where none."""
    return np.asarray(physical_series(coefficients[np.newaxis], ROBOT_PERIOD)[0])


def run() -> Experiment:
    """Run everything on all seeds; draw the first. Figures of several seeds are medians with their range."""
    watched = {seed: watch(seed) for seed in MORE_SEEDS}
    first = watched[SEED]
    rows = [*data_rows(first.record), *identification_rows(list(watched.values())), *control_rows(watched)]
    drawn = {draw.__name__: draw(*first) for draw in figures.OF_THE_ROBOT}
    return Experiment("Sections V-B to V-E, Figs 7, 9 to 12: closed loop", rows, notes("closed_loop"), drawn)


def data_rows(record: Record) -> list[Row]:
    """Return what the data are like (Figs 7 and 10)."""
    durations = np.diff(record.time)
    mean, largest = float(np.mean(durations)), float(np.max(durations))
    fastest = float(np.degrees(np.max(np.abs(record.reference[record.steps]))))
    return [
        Row("Fig. 10: sampling time, mean, ms", 1e3 * mean, "about 22", 21.5 <= 1e3 * mean <= 22.5),
        Row("Fig. 10: largest sampling time / mean", largest / mean, "almost 2", 1.8 <= largest / mean <= 2.0),
        Row("Fig. 10: samples that come late, %", 100.0 * float(np.mean(durations > records.LATE))),
        Row("Fig. 7: resolution of the torque K i, N m", records.TORQUE_CONSTANT * records.CURRENT_STEP),
        Row("V-B: largest speed of the reference, deg/s", fastest),
    ]


def identification_rows(every: Sequence[Watched]) -> list[Row]:
    """Return how well fits predict and what they say of the joint (Figs 9, 12), and RLS beside them (Fig. 11)."""
    errors: dict[str, Callable[[Watched], Array]] = {
        "Fig. 9: one-step error of the offline LS": lambda one: one.series.errors["offline"],
        "Fig. 9: free-run error of the offline LS": lambda one: one.series.errors["free"],
        "Fig. 9: one-step error of the torque form": lambda one: one.form.errors["online"],
        "Fig. 9: free-run error of the torque form": lambda one: one.form.errors["free"],
        f"Fig. 11: a-priori error of RLS (noise {1e3 * records.NOISE:g})": lambda one: one.series.errors["prior"],
        "Fig. 11: a-posteriori error of RLS": lambda one: one.series.errors["posterior"],
    }
    estimates: dict[str, Callable[[Watched], Array]] = {
        "offline LS on (4)": lambda one: physical_of(one.series.offline.values),
        "the same, sliding samples only": lambda one: physical_of(one.series.sliding.values),
        "torque form, online, at the end": lambda one: one.form.estimates[-1],
    }
    found = [ratios(one) for one in every]
    late = [physical_series(one.series.coefficients[one.record.time >= TRANSIENT], ROBOT_PERIOD) for one in every]
    possible = [100.0 * float(np.mean(is_possible(physical))) for physical in late]
    return [
        *(
            Row(f"{name}, mrad/s rms", median_and_range([settled_rms(one.record, error(one)) for one in every]))
            for name, error in errors.items()
        ),
        *(
            Row(f"Fig. 9: {name}: off the truth by, %", in_words(np.median([values(one) for one in every], axis=0)))
            for name, values in estimates.items()
        ),
        *(
            Row(f"Fig. 11: RLS at lambda {FORGETTING:g} / offline LS: {key}", median_and_range([f[key] for f in found]))
            for key in found[0]
        ),
        Row("Fig. 12: samples whose coefficients stand for a possible joint, %", median_and_range(possible, 1)),
    ]


def settled_rms(record: Record, errors: Array) -> float:
    """Return the rms of errors after the transient, in mrad/s."""
    return 1e3 * rms(errors[record.time >= TRANSIENT])


def ratios(one: Watched) -> dict[str, float]:
    """Return errors of RLS relative to those of the offline fit."""
    errors = {name: settled_rms(one.record, values) for name, values in one.series.errors.items()}
    return {
        PRIOR: errors["prior"] / errors["offline"],
        POSTERIOR: errors["posterior"] / errors["offline"],
        f"{PRIOR}, against the free run of the offline fit": errors["prior"] / errors["free"],
    }


def make_controllers(offline: Array, form: Array) -> dict[str, Controller]:
    """Return the controllers that are compared.

    ``offline`` and ``form`` (5,) are the physical parameters by the offline fit of (4) and by the torque form. Where
    the coefficients of the first are those of no joint, there is nothing to feed forward.
    """
    inertia, memory = SCENARIO.feedback.inertia, -ROBOT_PERIOD / math.log(FORGETTING)
    models = {OFFLINE: offline, FORM: form, ORACLE: np.array(TRUE[:5])}
    return {
        ALONE: PI(*GAINS, ROBOT_PERIOD),
        ONLINE: PaperController(*GAINS, ROBOT_PERIOD, inertia=inertia, **CURVE, memory=memory),
        **{
            name: ModelBased(*GAINS, ROBOT_PERIOD, possible(physical))
            for name, physical in models.items()
            if np.all(np.isfinite(physical))
        },
    }


def possible(physical: Array) -> TorqueModel:
    """Return the model of physical parameters: its lag not negative, its stiction at least its Coulomb friction."""
    model = model_of(physical)
    return model._replace(friction_lag=max(model.friction_lag, 0.0), stiction=max(model.stiction, model.coulomb))


def tracking_errors(one: Watched, seed: int) -> dict[str, float]:
    """Return the tracking error (mrad/s rms, true velocity) of each controller on another motion than the record's."""
    setup, after = records.build_robot_setup(seed + OTHER_MOTION), round(TRANSIENT / records.SOLVER_PERIOD)
    made = make_controllers(physical_of(one.series.offline.values), one.form.estimates[-1])
    runs = {name: records.drive(setup, controller) for name, controller in made.items()}
    return {name: 1e3 * rms((run.reference - run.true)[after:]) for name, run in runs.items()}


def control_rows(watched: dict[int, Watched]) -> list[Row]:
    """Return the tracking errors of all controllers over the seeds."""
    found = [tracking_errors(one, seed) for seed, one in watched.items()]
    errors = {name: [each[name] for each in found if name in each] for name in (ALONE, OFFLINE, ONLINE, FORM, ORACLE)}
    return [
        Row(f"Control: {name}: tracking error, mrad/s rms", median_and_range(values)) for name, values in errors.items()
    ]
