"""The benchmark of joints whose friction is smoothed, and what ``adaptive`` makes of one."""

import json

import pytest
import typer
from typer.testing import CliRunner

from benchmarks.smooth_friction import JOINTS, Case, cases, friction, main, next_velocity, run_case


@pytest.mark.parametrize("width", [0.002, 0.2])
@pytest.mark.parametrize(("velocity", "torque"), [(0.0, 5.0), (0.0, 200.0), (0.3, -200.0), (-1e-3, 14.0), (0.5, 0.0)])
def test_velocity_solves_implicit_euler(width, velocity, torque):
    case, step = Case(2.0, width, 100, False), 1e-3
    found = next_velocity(case, velocity, torque, step)
    assert case.inertia * (found - velocity) == pytest.approx(step * (torque - friction(case, found)), abs=1e-9)


def test_a_held_joint_creeps():
    case, velocity = Case(2.0, 0.05, 100, False), 0.0
    for _ in range(2000):
        velocity = next_velocity(case, velocity, 7.0, 1e-3)
    assert friction(case, velocity) == pytest.approx(7.0, rel=1e-6)
    assert 0.0 < velocity < case.width


@pytest.mark.parametrize(("cascade", "least"), [(False, 15.0), (True, 5.0)])
def test_friction_that_rises_from_standstill_on_is_learnt(cascade, least):
    found = run_case(Case(2.0, 0.2, 100, cascade), range(101, 102), 40.0)
    assert found["settled"] > least
    assert found["start"] > 1.0


def test_command_prints_a_row_and_writes_the_figures(tmp_path):
    name = "20 kg m², multisine, velocity loop, 100 Hz, 10 mrad/s"
    assert name in [case.name for case in cases()]
    assert len(cases()) == 8 * len(JOINTS) * 2
    options = ["--only", name, "--seeds", "1", "--duration", "12", "--workers", "1"]
    options += ["--json", str(tmp_path / "rows.json")]
    app = typer.Typer()
    app.command()(main)
    result = CliRunner().invoke(app, options)
    assert result.exit_code == 0, result.output
    assert name in result.output
    assert json.loads((tmp_path / "rows.json").read_text())[0]["settled"] > 1.0
