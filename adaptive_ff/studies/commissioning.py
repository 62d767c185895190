"""A joint put into operation in one go: excite, identify, choose the bandwidth, and a scenario of what was found.

On a simulated joint the truth is known, so that a last step can show what was gained: the loop as it was given, beside
the adaptive controller with what was identified. On a real joint the log takes the place of the first two steps.
"""

import tomllib
from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from adaptive_ff.comparison.own_bandwidth import TUNING_SEEDS, settled_error, with_bandwidth
from adaptive_ff.comparison.registry import CONTROLLERS, loop_of
from adaptive_ff.comparison.run import simulate
from adaptive_ff.errors import InputError
from adaptive_ff.identify.result import LogIdentification
from adaptive_ff.identify.scenario_text import scenario_text
from adaptive_ff.scenario.scenario import Scenario
from adaptive_ff.studies.bandwidth_study import REPORTED_SEEDS, BandwidthStudy, study_bandwidths
from adaptive_ff.studies.exciting_motion import exciting_motion, with_motion
from adaptive_ff.studies.motion import Array, Excitation, MotionLimits

PERIODS = 6
"""Periods of the motion that are recorded: identification chooses among models, and holds a quarter out."""

RECORDED_SEED = 100
"""Seed of the noise of the recording: neither one that is tuned on nor one that is reported."""


@dataclass(frozen=True, eq=False)
class Recording:
    """A recorded motion of a simulated joint."""

    motion: Excitation  # the motion
    columns: dict[str, Array]  # ``time`` (s), ``velocity`` as it is measured (rad/s) and ``torque`` of the drive (N m)


@dataclass(frozen=True, eq=False)
class Gain:
    """What commissioning gains on a simulated joint: settled rms errors, rad/s, the median over seeds."""

    # PI loop as it was given, and its bandwidth, Hz
    before: float
    before_bandwidth: float
    # PI loop with the bandwidth that suits it
    best_pi: float
    best_pi_bandwidth: float
    # adaptive controller with what was identified, and the bandwidth that was chosen
    after: float
    after_bandwidth: float


def record(
    scenario: Scenario,
    limits: MotionLimits,
    *,
    period: float = 10.0,
    workers: int | None = 1,
    progress: Callable[[float], None] | None = None,
) -> Recording:
    """Find an exciting motion of a period (s) and record some of them on the simulated joint, under the PI loop."""
    motion = exciting_motion(scenario, limits, period=period, workers=workers, progress=progress)
    plan = with_motion(loop_of(scenario, "pi"), motion.reference.model_dump(), PERIODS * period)
    run = simulate(plan.modified(seed=RECORDED_SEED), "pi")
    return Recording(motion, {"time": run.time, "velocity": run.measured, "torque": run.torque})


def identified_scenario(scenario: Scenario, found: LogIdentification) -> Scenario:
    """Return the scenario with the joint that was identified, and with what the controllers now assume of it.

    Sensor, drive and reference stay as they are; changes of the joint and what is assumed of its sweep do, too.
    ``InputError`` where the log does not determine a joint that can be simulated.
    """
    joint = tomllib.loads(scenario_text(found, "reference.csv"))["joint"]
    joint["solver_period"] = scenario.joint.solver_period
    content = scenario.model_dump(exclude_unset=True)
    assumed = {name: joint[name] for name in ("inertia", "coulomb", "viscous")}
    try:
        return Scenario.model_validate(
            {
                **content,
                "joint": {**joint, "axis": scenario.joint.axis},
                "feedback": {**content["feedback"], "inertia": joint["inertia"]},
                "adaptation": {**content["adaptation"], "stribeck_velocity": joint["stribeck_velocity"]},
                "fixed": assumed,
            }
        )
    except ValueError as error:
        raise InputError(f"{found.name}: what was identified makes no scenario: {error}") from error


def tuned(
    identified: Scenario, *, workers: int | None = 1, progress: Callable[[float], None] | None = None
) -> tuple[Scenario, BandwidthStudy]:
    """Return a scenario with the bandwidth that suits the adaptive controller, and the study that found it."""
    study = study_bandwidths(identified, ["adaptive"], tuning_seeds=TUNING_SEEDS, workers=workers, progress=progress)
    best = float(f"{study.own['adaptive'].best:.4g}")
    return with_bandwidth(identified, min(best, study.own["adaptive"].bandwidths[-1])), study


def gain_on_the_true_joint(scenario: Scenario, result: Scenario, study: BandwidthStudy) -> Gain:
    """Return what the commissioned controller (result) gains on the joint of the scenario that it began with."""
    given = loop_of(scenario, "pi")
    content = result.model_dump(exclude_unset=True)
    after = Scenario.model_validate({**content, "joint": scenario.joint.model_dump(exclude_unset=True)})

    def error(one: Scenario, name: str) -> float:
        return float(np.median([settled_error(one.modified(seed=seed), CONTROLLERS[name]) for seed in REPORTED_SEEDS]))

    crossover = given.feedback.gains[0] / (2.0 * np.pi * given.feedback.inertia)
    suits_pi = study.own["pi"].best
    return Gain(
        error(given, "pi"),
        float(crossover),
        error(with_bandwidth(after, suits_pi), "pi"),
        suits_pi,
        error(after, "adaptive"),
        after.feedback.hertz,
    )
