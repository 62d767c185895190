"""Recorded machines: a joint identified from a log, its logs replayed, and the identified joint in a closed loop.

``identify`` has the torque that the fit leaves unexplained in its log and in the validation, over the torque's, and
the open-loop error of the second log from its torque (rad or m), whole and in windows of 1 s. Feedforwards have the
torque that is left to the feedback in the logs, rms in N m (or N), 20 Hz: ``left`` of the whole log, ``second_half``,
``moving``; of two logs the second goes on from the state at the end of the first where that is ``adaptive_saved``.
``closed loop`` has the settled errors of PI and of the oracle over that of ``adaptive``.

Assumed in the closed loops: a PI loop of 10 Hz for the identified inertia, which every controller assumes as well;
where the log does not identify them, stiction as Coulomb friction and a Stribeck velocity of 0.05 of the largest speed;
a sensor of velocity, as noisy as the log's velocity; a drive without limit; the reference repeats until 60 s.
"""

import json
import tempfile
from functools import partial
from pathlib import Path

import numpy as np

from adaptive_ff import compare, load_scenario
from adaptive_ff.files import write_csv
from adaptive_ff.identify.identification import identify_log
from adaptive_ff.identify.result import LogIdentification
from adaptive_ff.identify.scenario_text import joined_ends, scenario_text
from adaptive_ff.identify.score import score_log
from adaptive_ff.logs.log import Log
from adaptive_ff.replay.replay import replay_log
from adaptive_ff.studies.study import Found
from benchmarks.recorded_machines import DATA, JOBS, Job
from benchmarks.suite import Case

COMPARED = ("pi", "oracle", "adaptive")


def closed_loop(found: LogIdentification, log: Log) -> dict[str, float]:
    """Return settled errors over that of ``adaptive`` on an identified joint along the reference of its log."""
    if "reference_velocity" in log.extra:
        velocity = log.extra["reference_velocity"]
    else:
        velocity = np.gradient(log.extra["reference_position"], log.time)
    with tempfile.TemporaryDirectory() as folder:
        write_csv(Path(folder) / "reference.csv", joined_ends(log.time - log.time[0], velocity))
        scenario = Path(folder) / "scenario.toml"
        scenario.write_text(scenario_text(found, "reference.csv"), encoding="utf-8")
        runs = compare(load_scenario(scenario)).runs
    errors = {name: runs[name].metrics.rms_error_settled for name in COMPARED}
    return {name: errors[name] / errors["adaptive"] for name in COMPARED[:-1]}


def job_of(name: str) -> Job:
    """Return the job of a joint by its name, which a process of its own is sent."""
    return next(job for job in JOBS if job.name == name)


def run_job(name: str, controllers: list[str]) -> Found:
    """Identify a joint, replay its logs and simulate it; ``controllers`` are the columns of the result."""
    job = job_of(name)
    if missing := job.data.missing(DATA):
        raise ValueError(f"{', '.join(missing)} not there; source: {job.data.origin}")
    logs = [job.read(DATA, record) for record in job.records]
    other = logs[1] if len(logs) > 1 else None
    validation = {"held_out": 0.0, "validation": other} if other is not None else {"held_out": job.held_out}
    found = identify_log(logs[0], linear=job.linear, **validation)
    columns: Found = {name: {} for name in controllers}
    columns["identify"] = {"unexplained": found.best.left}
    if found.validation is not None:
        columns["identify"]["validation"] = found.validation
    if job.scored and other is not None:
        score = score_log(logs[0], other, linear=job.linear)
        columns["identify"] |= {"open_loop": score.rms, "windows": score.windows}
    state = {}
    for log in logs:
        replay = replay_log(log, linear=job.linear, **state, **job.settings)
        state = {"state": replay.state_to_json()}
        for name in set(controllers) & set(replay.left):
            for figure, value in replay.left[name]._asdict().items():
                columns[name].setdefault("left" if figure == "whole" else figure, []).append(value)
    if job.simulated:
        columns["closed loop"] = closed_loop(found, logs[0])
    return {"": {"row": job.name}, **{name: columns[name] for name in controllers}}


def joints(count: int = 1, first: int = 1) -> list[Case]:
    """Return the joints that suit a lumped model."""
    return [Case(job.name, first, partial(run_job, job.name)) for job in JOBS]


def identified(joint: str, controllers: list[str]) -> Found:
    """Identify a joint: its parameters, and the largest torque of its log (its 99.9th percentile), N m or N."""
    (name,), job = controllers, job_of(joint)
    log = job.read(DATA, job.records[0])
    found = identify_log(log, linear=job.linear)
    largest = float(np.nanquantile(np.abs(log.torque), 0.999))
    values = {one: parameter.value for one, parameter in found.parameters.items()} | {"largest": largest}
    return {"": {"row": job.name}, name: values | {"over_largest": found.value("coulomb") / largest}}


def frictions(count: int = 1, first: int = 1) -> list[Case]:
    """Return the joints for the orders of magnitude of their friction."""
    return [Case(job.name, first, partial(identified, job.name)) for job in JOBS]


SERVOS = {"eRob80 50:1": "erob80_50", "eRob80 100:1": "erob80_100", "MX-64": "mx64", "MX-106": "mx106"}
"""Servos that the authors of github.com/Rhoban/bam (commit 1b5a1ce, Apache-2.0) identified: their model m1."""

PUBLISHED = {
    # github.com/dfki-ric-underactuated-lab/double_pendulum, commit a6a1242, tmotors_v1.0/model_parameters.yml: shoulder
    "AK80-6": {"coulomb": 0.093, "viscous": 0.081, "largest": 10.0},
    # github.com/nielsSkov/masterThesisMatlab, commit 13dd4a8, cartPendulum/initCartPendulum.m: means of two directions
    "cart": {"inertia": 6.28, "coulomb": (3.021 + 2.746) / 2.0, "viscous": (1.937 + 1.422) / 2.0},
    # github.com/JuliaComputing/QuanserInterface.jl, commit 0465b39, examples/estimate_friction.jl: breakaway at 0.11 V
    # of 10 V; torque constant and resistance in src/qube_servo.jl
    "Qube-Servo": {"coulomb": 0.042 * 0.11 / 8.4, "largest": 0.042 * 10.0 / 8.4},
}
"""Frictions that others published, in SI units at the joint."""


def quoted(joint: str, controllers: list[str]) -> Found:
    """Return what others identified on a joint."""
    (name,) = controllers
    if joint in SERVOS:
        file = DATA / "reference_parameters/bam_servo_friction_parameters.json"
        if not file.is_file():
            raise ValueError(f"{file.name} is not there; source: github.com/Rhoban/bam")
        model = json.loads(file.read_text(encoding="utf-8"))[SERVOS[joint]]["m1"]
        values = {"inertia": model["armature"], "coulomb": model["friction_base"], "viscous": model["friction_viscous"]}
    else:
        values = dict(PUBLISHED[joint])
    if "largest" in values:
        values["over_largest"] = values["coulomb"] / values["largest"]
    return {"": {"row": joint}, name: values}


def published(count: int = 1, first: int = 1) -> list[Case]:
    """Return the joints whose friction others published."""
    return [Case(joint, first, partial(quoted, joint)) for joint in (*SERVOS, *PUBLISHED)]
