"""Joints of another simulator: its physics, its sensors, and that compensation makes none of them worse."""

import json
import math

import numpy as np
import pytest
import typer
from typer.testing import CliRunner

from benchmarks.other_joints import MOTIONS, DrawnJoint, Velocity, advance_joint, draw, drawn_plan, main, run_joint

JOINT = DrawnJoint(2.0, 5.0, 8.0, 3.0, 0.05, 1.0, 0.0, 6.0)


def moved(torque, velocity=0.0, seconds=5.0):
    motion = np.array([0.0, velocity])
    for _ in range(round(seconds / 1e-3)):
        advance_joint(JOINT, motion, torque, 1e-3, 5)
    return motion


def test_a_joint_sticks_until_stiction_is_overcome_and_then_slides():
    assert tuple(moved(8.9)) == (0.0, 0.0)
    assert moved(9.2, seconds=20.0)[1] == pytest.approx((9.2 - 1.0 - 5.0) / 3.0, rel=1e-3)
    assert moved(0.0, velocity=1.0)[1] == 0.0


@pytest.mark.parametrize("kind", MOTIONS)
def test_a_plan_begins_at_rest_and_stays_within_its_speed(kind):
    plan = drawn_plan(kind, 2.0, 0.01, np.random.default_rng(101))
    assert plan.size == 4000
    assert plan[0] == 0.0
    assert 0.5 < np.abs(plan).max() <= 2.0 + 1e-12
    assert min(plan) < 0.0 < max(plan)


def test_every_sensor_tells_a_constant_speed_after_its_lag():
    seen = set()
    for seed in range(101, 130):
        joint, loop, plan = draw(seed)
        sensor = Velocity(loop, 0.0, np.random.default_rng(seed))
        speed = 500.0 * loop.resolution
        told = [sensor.step(speed * k * loop.period, speed) for k in range(round(1.0 / loop.period))]
        assert np.mean(told[len(told) // 2 :]) == pytest.approx(speed, abs=0.05 * speed + loop.noise)
        assert 2.0 * math.pi * loop.bandwidth * ((loop.delay + 0.5) * loop.period + loop.velocity_lag) < 0.501
        assert joint.stiction >= joint.coulomb > 0.0
        assert np.isfinite(plan).all()
        seen.add(loop.sensor)
    assert len(seen) == 4


@pytest.mark.parametrize("seed", [101, 102, 105])
def test_compensation_makes_such_a_joint_better(seed):
    row = run_joint(seed)
    assert row["settled"] > 3.0
    assert max(row["windows"]) < 1.0


def test_command_prints_the_table_and_writes_the_figures(tmp_path):
    app = typer.Typer()
    app.command()(main)
    options = ["--joints", "2", "--first", "101", "--workers", "1", "--json", str(tmp_path / "rows.json")]
    result = CliRunner().invoke(app, options)
    assert result.exit_code == 0, result.output
    assert "noise over plan" in result.output
    assert [row["seed"] for row in json.loads((tmp_path / "rows.json").read_text())["joints"]] == [101, 102]
