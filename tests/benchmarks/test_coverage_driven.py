"""Logs of joints under PI alone: what they record, and that the command counts and writes what it finds."""

import json

import numpy as np
import pytest
import typer
from typer.testing import CliRunner

from benchmarks.cases.other_joints import draw
from benchmarks.coverage_driven import driven_case, examine_seed, main


@pytest.mark.parametrize("seed", [101, 102, 103, 104, 105, 106])
def test_the_recorded_torque_is_what_the_joint_needs(seed):
    """Over the log, inertia gives back what it takes: what is left of the work is done against friction and load."""
    case = driven_case(seed)
    joint, loop, _ = draw(seed)
    log = case.log
    assert case.delay == 0.5 * loop.period
    assert (log.velocity is None) != (loop.sensor == "tachometer")
    velocity = np.gradient(log.position, log.time) if log.velocity is None else log.velocity
    friction = joint.coulomb * np.abs(velocity) + joint.viscous * velocity**2
    done = float(np.mean((log.torque - joint.load) * velocity))
    assert float(np.mean(friction)) == pytest.approx(done, rel=0.25)


@pytest.mark.parametrize("seed", [315, 332, 364])
def test_inertia_of_a_joint_that_sticks_for_long_is_within_its_interval(seed):
    result = examine_seed(seed)
    assert result["inertia"]["covers"]
    for name in ("inertia", "coulomb"):
        assert abs(result[name]["error"]) < 0.05, name


def test_command_prints_the_table_and_writes_the_results(tmp_path):
    app = typer.Typer()
    app.command()(main)
    arguments = ["--logs", "2", "--first", "301", "--workers", "1", "--json", str(tmp_path / "found.json")]
    result = CliRunner().invoke(app, arguments)
    assert result.exit_code == 0, result.output
    assert "2 logs" in result.output
    assert "cogging: inertia, Coulomb and viscous friction held in" in result.output
    written = json.loads((tmp_path / "found.json").read_text(encoding="utf-8"))["logs"]
    assert [entry["log"] for entry in written] == ["joint 301", "joint 302"]
