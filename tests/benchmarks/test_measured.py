"""The benchmark over recorded machines: what it does without data, and with a long log."""

import json

import numpy as np
import pytest
from typer import Typer
from typer.testing import CliRunner

from adaptive_ff.logs.log import read_log
from benchmarks.measured import __main__ as command
from benchmarks.measured.long_log import replay_in_process, write_log
from benchmarks.measured.machines import DATA, EMPS, JOBS, KUKA, STAUBLI
from benchmarks.measured.results import measure, results_table


def test_absent_data_are_said_and_are_no_failure(tmp_path):
    app = Typer()
    app.command()(command.main)
    done = CliRunner().invoke(app, ["--data", str(tmp_path), "--json", str(tmp_path / "out.json")])
    assert done.exit_code == 0
    text = " ".join(done.stdout.split())
    for machine in (EMPS, STAUBLI, KUKA):
        assert f"{machine.name} is left out" in text
        for file in machine.files:
            assert file in text
        assert machine.origin in text
    assert json.loads((tmp_path / "out.json").read_text(encoding="utf-8")) == {}
    assert [path.name for path in tmp_path.iterdir()] == ["out.json"]


def test_jobs_are_the_joints_that_suit_a_lumped_model():
    assert [job.name for job in JOBS] == [
        "EMPS",
        *(f"Staubli TX40 joint {joint}" for joint in (1, 4)),
        *(f"KUKA KR300 axis {axis}" for axis in (1, 4, 6)),
    ]


@pytest.mark.skipif(
    bool(KUKA.missing(DATA)), reason=f"the recorded data lie outside the repository and are not there: {DATA}"
)
def test_identified_axis_in_the_closed_loop_along_its_recorded_reference():
    (job,) = [job for job in JOBS if job.name == "KUKA KR300 axis 6"]
    result = measure(job, DATA)
    loop = result.closed_loop
    recorded = job.read(DATA, "trajectory_A.npz").extra["reference_velocity"]
    assert np.ptp(loop.runs["pi"].reference) == pytest.approx(np.ptp(recorded), rel=1e-3)
    assert loop.improvement["adaptive"] > 5.0
    assert result.found.validated_on.endswith("trajectory_B.npz")
    assert set(result.to_dict()["replays"]) == set(job.records)
    assert results_table([result]).row_count == 2


def test_long_log_is_measured(tmp_path):
    path = tmp_path / "log.npz"
    write_log(path, 30_000)
    log = read_log(path, time="time", velocity="velocity", torque="torque")
    friction = log.torque - 2.0 * np.gradient(log.velocity, 0.001)
    assert np.std(friction - 3.0 * np.sign(log.velocity) - 4.0 * log.velocity) == pytest.approx(0.05, rel=0.1)
    ballast = np.ones(100_000_000)  # of the process that starts it, 800 MB, must not count
    found = replay_in_process(path)
    assert ballast[-1] == 1.0
    assert found["seconds"] > 0.0
    assert 1e8 < found["peak"] < 1e9
