"""A joint put into operation in one go: excite, identify, choose the bandwidth, and a scenario of what was found.

On a simulated joint the truth is known, so that a last step can show what was gained: the loop as it was given, beside
the adaptive controller with what was identified. On a real joint the log takes the place of the first two steps.
"""

import math
import tomllib
from typing import Any

import numpy as np

from adaptive_ff.comparison.own_bandwidth import settled_error, with_bandwidth
from adaptive_ff.comparison.registry import CONTROLLERS, loop_of
from adaptive_ff.comparison.run import simulate
from adaptive_ff.errors import InputError
from adaptive_ff.identify.result import LogIdentification
from adaptive_ff.identify.scenario_text import scenario_text
from adaptive_ff.scenario.scenario import Scenario
from adaptive_ff.studies.bandwidth_study import REPORTED_SEEDS, BandwidthStudy, study_bandwidths
from adaptive_ff.studies.exciting_motion import exciting_motion, with_motion
from adaptive_ff.studies.motion import Array, Excitation, MotionLimits

PERIODS = 6  # periods of the motion that are recorded: identification chooses among models, and holds a quarter out
RECORDED_SEED = 100  # seed of the noise of the recording: neither one that is tuned on nor one that is reported


def record(scenario: Scenario, limits: MotionLimits, **options: Any) -> tuple[Excitation, dict[str, Array]]:
    """Find an exciting motion and record some periods of it on the simulated joint, under the PI loop.

    Options are those of :func:`exciting_motion`. Returns the motion, and ``time`` (s), ``velocity`` as it is measured
    (rad/s) and ``torque`` of the drive (N m).
    """
    motion = exciting_motion(scenario, limits, **options)
    plan = with_motion(loop_of(scenario, "pi"), motion.reference.model_dump(), PERIODS * motion.reference.period)
    run = simulate(plan.modified(seed=RECORDED_SEED), "pi")
    return motion, {"time": run.time, "velocity": run.measured, "torque": run.torque}


def identified_scenario(scenario: Scenario, found: LogIdentification) -> Scenario:
    """Return the scenario with the joint that was identified, and with what the controllers now assume of it.

    Sensor, drive and reference stay as they are; changes of the joint and what is assumed of its sweep do, too.
    ``InputError`` where the log does not determine a joint that can be simulated.
    """
    joint = tomllib.loads(scenario_text(found, "reference.csv"))["joint"]
    joint["solver_period"] = scenario.joint.solver_period
    feedback, adaptation = (one.model_dump(exclude_unset=True) for one in (scenario.feedback, scenario.adaptation))
    try:
        return scenario.replaced(
            joint={**joint, "axis": scenario.joint.axis},
            feedback={**feedback, "inertia": joint["inertia"]},
            adaptation={**adaptation, "stribeck_velocity": joint["stribeck_velocity"]},
            fixed={name: joint[name] for name in ("inertia", "coulomb", "viscous")},
        )
    except ValueError as error:
        raise InputError(f"{found.name}: what was identified makes no scenario: {error}") from error


def tuned(identified: Scenario, **options: Any) -> tuple[Scenario, BandwidthStudy]:
    """Return a scenario with the bandwidth that suits the adaptive controller, and the study that found it.

    Options are those of :func:`study_bandwidths`.
    """
    study = study_bandwidths(identified, ["adaptive"], **options)
    best = float(f"{study.own['adaptive'].best:.4g}")
    return with_bandwidth(identified, min(best, study.own["adaptive"].bandwidths[-1])), study


def gain_on_the_true_joint(scenario: Scenario, result: Scenario, study: BandwidthStudy) -> dict[str, float]:
    """Return what the commissioned controller (result) gains on the joint of the scenario that it began with.

    Settled rms errors, rad/s, the median over seeds, and bandwidths, Hz: of the PI loop as it was given, of the one
    that suits PI, and of the adaptive controller with what was identified.
    """
    given, suits_pi = loop_of(scenario, "pi"), study.own["pi"].best
    after = result.replaced(joint=scenario.joint)

    def error(one: Scenario, name: str) -> float:
        return float(np.median([settled_error(one.modified(seed=seed), CONTROLLERS[name]) for seed in REPORTED_SEEDS]))

    return {
        "before": error(given, "pi"),
        "before_bandwidth": given.feedback.gains[0] / (2.0 * math.pi * given.feedback.inertia),
        "best_pi": error(with_bandwidth(after, suits_pi), "pi"),
        "best_pi_bandwidth": suits_pi,
        "after": error(after, "adaptive"),
        "after_bandwidth": after.feedback.hertz,
    }
