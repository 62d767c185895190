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
import tomllib
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
from scipy import io

from adaptive_ff import compare, load_scenario
from adaptive_ff.files import write_csv
from adaptive_ff.identify.identification import identify_log
from adaptive_ff.identify.result import LogIdentification
from adaptive_ff.identify.scenario_text import joined_ends, scenario_text
from adaptive_ff.identify.score import score_log
from adaptive_ff.logs.log import Log, read_log
from adaptive_ff.replay.replay import replay_log
from adaptive_ff.studies.study import Found
from benchmarks.suite import pooled

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


DATA = Path(__file__).resolve().parents[4] / "shared" / "data"

MACHINES: dict[str, dict[str, Any]] = tomllib.loads(Path(__file__).with_suffix(".toml").read_text(encoding="utf-8"))
"""Tables of the machines by name."""

PUBLISHED = MACHINES.pop("published")  # what others identified


class Job(NamedTuple):
    """A joint of a machine: one log to identify and to start cold on, and perhaps another one."""

    table: dict[str, Any]  # table of the machine
    joint: str  # empty where there is only one

    @property
    def linear(self) -> bool:
        """Whether it is a linear axis."""
        return bool(self.table.get("linear"))

    def missing(self) -> list[str]:
        """Return the files that are not there."""
        return [file for file in self.table["files"] if not (DATA / self.table["folder"] / file).is_file()]

    def read(self, record: str) -> Log:
        """Read a log."""
        path, place = DATA / self.table["folder"] / record, self.table.get("joints", {}).get(self.joint)
        columns = dict(self.table["read"])
        columns["extra"] = {name: text.format(place) for name, text in columns.get("extra", {}).items()}
        columns |= {name: columns[name].format(place) for name in ("position", "torque")}
        scale = {}
        if "gain" in self.table:
            scale[columns["torque"]] = io.loadmat(path, variable_names=[self.table["gain"]])[self.table["gain"]].item()
        if "ratios" in self.table:
            ratio = self.table["ratios"][place]
            scale = {columns["position"]: 1.0 / ratio, columns["torque"]: ratio}
        if "degrees" in self.table:
            scale = {columns["position"]: np.pi / 180.0}
        return read_log(path, scale=scale, **columns)


LISTED = {name: table for name, table in MACHINES.items() if "files" in table}
JOBS = {f"{name} {one}".strip(): Job(table, one) for name, table in LISTED.items() for one in table.get("joints", [""])}
"""Joints by machine and joint."""


def run_job(joint: str, _: list[int], controllers: list[str]) -> Found:
    """Identify a joint, replay its logs and simulate it; ``controllers`` are the columns of the result."""
    job = JOBS[joint]
    if missing := job.missing():
        raise ValueError(f"{', '.join(missing)} not there; source: {job.table['origin']}")
    logs = [job.read(record) for record in job.table["files"]]
    other = logs[1] if len(logs) > 1 else None
    validation = {"held_out": 0.0, "validation": other} if other is not None else {"held_out": job.table["held_out"]}
    found = identify_log(logs[0], linear=job.linear, **validation)
    columns: Found = {name: {} for name in controllers}
    columns["identify"] = {"unexplained": found.best.left}
    if found.validation is not None:
        columns["identify"]["validation"] = found.validation
    if "scored" in job.table and other is not None:
        score = score_log(logs[0], other, linear=job.linear)
        columns["identify"] |= {"open_loop": score.rms, "windows": score.windows}
    state = {}
    for log in logs:
        replay = replay_log(log, linear=job.linear, **state, **job.table["settings"])
        state = {"state": replay.state_to_json()}
        for name in set(controllers) & set(replay.left):
            for figure, value in replay.left[name]._asdict().items():
                columns[name].setdefault("left" if figure == "whole" else figure, []).append(value)
    if job.table["simulated"] is True or job.joint in job.table["simulated"]:
        columns["closed loop"] = closed_loop(found, logs[0])
    return {"": {"row": joint}, **{name: columns[name] for name in controllers}}


def identified(joint: str, _: list[int], controllers: list[str]) -> Found:
    """Identify a joint: its parameters, and the largest torque of its log (its 99.9th percentile), N m or N."""
    (name,), job = controllers, JOBS[joint]
    log = job.read(job.table["files"][0])
    found = identify_log(log, linear=job.linear)
    largest = float(np.nanquantile(np.abs(log.torque), 0.999))
    values = {one: parameter.value for one, parameter in found.parameters.items()} | {"largest": largest}
    return {"": {"row": joint}, name: values | {"over_largest": found.value("coulomb") / largest}}


def quoted(joint: str, _: list[int], controllers: list[str]) -> Found:
    """Return what others identified on a joint."""
    (name,), servos = controllers, PUBLISHED["servos"]
    if joint in servos:
        file = DATA / "reference_parameters/bam_servo_friction_parameters.json"
        if not file.is_file():
            raise ValueError(f"{file.name} is not there; source: github.com/Rhoban/bam")
        model = json.loads(file.read_text(encoding="utf-8"))[servos[joint]]["m1"]
        values = {"inertia": model["armature"], "coulomb": model["friction_base"], "viscous": model["friction_viscous"]}
        values["largest"] = PUBLISHED["largest"][joint]
    else:
        values = dict(PUBLISHED["joints"][joint])
    if "largest" in values:
        values["over_largest"] = values["coulomb"] / values["largest"]
    return {"": {"row": joint}, name: values}


joints, frictions = (pooled(run, {name: (name,) for name in JOBS}) for run in (run_job, identified))
published = pooled(quoted, {joint: (joint,) for joint in (*PUBLISHED["servos"], *PUBLISHED["joints"])})
