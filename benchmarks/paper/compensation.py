"""What the identified parameters are worth for control: each fed forward on the robot of section V."""

import math

import numpy as np

from adaptive_ff.baselines.model_based import ModelBased
from adaptive_ff.baselines.paper import PaperController
from adaptive_ff.friction.model import TorqueModel
from adaptive_ff.learning.batch import Array
from benchmarks.paper.data import TRUE, rms
from benchmarks.paper.experiment import Row, median_and_range
from benchmarks.paper.identification import model_of
from benchmarks.paper.robot import GAINS, PERIOD, SCENARIO, SOLVER_PERIOD, build_robot_setup, drive
from benchmarks.paper.watching import FORGETTING, TRANSIENT, Seen, adaptive, physical_of
from controllers import PI, Controller

OTHER_MOTION = 1000
"""Added to the seed of a record: the motion on which what it gave is fed forward."""
LONG_MEMORY = 5.0  # s, of RLS that averages
ALONE = "PI alone"
OFFLINE = "PI + offline LS on (4)"
SLIDING = "PI + offline LS on (4), sliding samples only"
ONLINE = f"PI + RLS on (4), lambda {FORGETTING:g}, as it learns"
SLOW = f"PI + RLS on (4), memory {LONG_MEMORY:g} s, as it learns"
FORM = "PI + torque form, identified on another motion"
LEARNING = "PI + torque form, as it learns from nothing"
ORACLE = "PI + true parameters"


def make_controllers(offline: Array, sliding: Array, form: Array) -> dict[str, Controller]:
    """Return the controllers that are compared.

    ``offline``, ``sliding``, ``form`` (5,): physical parameters by the offline fits of (4), from all samples and from
    sliding ones, and by the torque form, from another motion. Where the coefficients of the first are those of no
    joint, there is nothing to feed forward.
    """
    made: dict[str, Controller] = {ALONE: PI(*GAINS, PERIOD)}
    if np.all(np.isfinite(offline)):
        made[OFFLINE] = ModelBased(*GAINS, PERIOD, possible(offline))
    made[SLIDING] = ModelBased(*GAINS, PERIOD, possible(sliding))
    made[ONLINE] = paper_controller(-PERIOD / math.log(FORGETTING))
    made[SLOW] = paper_controller(LONG_MEMORY)
    made[FORM] = ModelBased(*GAINS, PERIOD, possible(form))
    made[LEARNING] = adaptive()
    made[ORACLE] = ModelBased(*GAINS, PERIOD, TRUE)
    return made


def possible(physical: Array) -> TorqueModel:
    """Return the model of physical parameters: its lag not negative, its stiction at least its Coulomb friction."""
    model = model_of(physical)
    return model._replace(friction_lag=max(model.friction_lag, 0.0), stiction=max(model.stiction, model.coulomb))


def paper_controller(memory: float) -> PaperController:
    """Return the loop with feedforward from the paper's RLS, its estimates kept possible; memory in s."""
    return PaperController(
        *GAINS,
        PERIOD,
        inertia=SCENARIO.feedback.inertia,
        stribeck_velocity=TRUE.stribeck_velocity,
        stribeck_shape=TRUE.stribeck_shape,
        memory=memory,
    )


def tracking_errors(one: Seen, seed: int) -> dict[str, float]:
    """Return the tracking error (mrad/s rms, true velocity) of each controller on another motion than the record's."""
    setup = build_robot_setup(seed + OTHER_MOTION)
    offline, sliding = (physical_of(fit.values) for fit in (one.series.offline, one.series.sliding))
    errors = {}
    for name, controller in make_controllers(offline, sliding, one.form.estimates[-1]).items():
        error = drive(setup, controller).tracking_error
        errors[name] = 1e3 * rms(error[round(TRANSIENT / SOLVER_PERIOD) :])
    return errors


def control_rows(seen: dict[int, Seen]) -> list[Row]:
    """Return the tracking errors of all controllers over the seeds."""
    found = [tracking_errors(one, seed) for seed, one in seen.items()]
    return [
        Row(
            f"Control: {name}: tracking error, mrad/s rms",
            median_and_range([each[name] for each in found if name in each]),
        )
        for name in found[0]
    ]
