"""Machines in MuJoCo: their gravity and inertia against closed forms, plans, one run of each kind of loop."""

import json

import mujoco
import numpy as np
import pytest
from typer.testing import CliRunner

from benchmarks.robot import __main__ as command
from benchmarks.robot import holding
from benchmarks.robot.circle import BENDS, FORE, UPPER, circle, joints_of, tip_of
from benchmarks.robot.loops import MAKERS, Setup, drive
from benchmarks.robot.machines import KINDS, gravity_of, make_machine
from benchmarks.robot.plans import Plan, moves, multisines, then_rest

GRAVITY = 9.81


def test_gravity_of_the_arm_is_that_of_its_links():
    machine = make_machine("two-link arm", "coulomb")
    position = np.array([0.3, -0.4])
    upper, fore = BENDS[0] + position[0], BENDS[1] + position.sum()
    elbow = GRAVITY * (6.0 * 0.5 * FORE + 3.0 * FORE) * np.sin(fore)
    shoulder = elbow + GRAVITY * (12.0 * 0.5 * UPPER + 9.0 * UPPER) * np.sin(upper)
    found = gravity_of(machine.model, mujoco.MjData(machine.model), position)
    assert found == pytest.approx([shoulder, elbow], rel=1e-9)


def test_inertia_is_torque_over_acceleration():
    machine = make_machine("hinge", "coulomb")
    assert machine.inertia == pytest.approx([20.0])


@pytest.mark.parametrize("name", KINDS)
@pytest.mark.parametrize("plan", [multisines, moves])
def test_plans_start_at_rest_and_keep_within_the_swing(name, plan):
    axes = KINDS[name][0]
    planned = plan(axes, 101, 20.0, 0.01)
    assert planned.velocity.shape == planned.position.shape == (2001, len(axes))
    assert np.all(planned.velocity[0] == 0.0)
    assert np.all(planned.position[0] == 0.0)
    assert np.all(np.max(np.abs(planned.position), axis=0) <= [1.01 * axis.swing for axis in axes])
    assert np.diff(planned.position, axis=0) / 0.01 == pytest.approx(planned.velocity[:-1], abs=0.1)


def test_each_axis_ends_where_it_was_last_at_rest():
    velocity = np.array([[0.0, 0.0], [1.0, 1.0], [0.0, 1.0], [1.0, 1.0]])
    position = np.array([[0.0, 0.0], [0.5, 0.5], [1.0, 1.5], [1.5, 2.5]])
    rested = then_rest(Plan(velocity, position), 2.0, 1.0)
    assert rested.velocity[:, 0] == pytest.approx([0.0, 1.0, 0.0, 0.0, 0.0, 0.0])
    assert rested.position[:, 0] == pytest.approx([0.0, 0.5, 1.0, 1.0, 1.0, 1.0])
    assert not np.any(rested.velocity[:, 1])
    assert not np.any(rested.position[:, 1])


def test_joints_and_tip_are_inverse_and_the_circle_is_one():
    position = np.array([[0.0, 0.0], [0.2, -0.3], [-0.4, 0.5]])
    assert joints_of(tip_of(position)) == pytest.approx(position, abs=1e-12)
    plan = circle(9.0, 0.01)
    centre = tip_of(np.zeros((1, 2)))[0] + [0.1, 0.0]
    assert np.hypot(*(tip_of(plan.position) - centre).T) == pytest.approx(0.1, abs=1e-12)


def test_tip_is_where_mujoco_has_it():
    machine = make_machine("two-link arm", "LuGre")
    data = mujoco.MjData(machine.model)
    data.qpos[:] = 0.2, -0.3
    mujoco.mj_forward(machine.model, data)
    place = mujoco.mj_name2id(machine.model, mujoco.mjtObj.mjOBJ_GEOM, "tip")
    assert data.geom_xpos[place][[0, 2]] == pytest.approx(tip_of(np.array([[0.2, -0.3]]))[0], abs=1e-12)


def test_arm_whose_gravity_is_learnt_tracks_better_than_pi_in_every_joint():
    machine, setup = make_machine("two-link arm", "coulomb"), Setup(rate=100, cascade=True, gravity_given=False)
    plan = moves(machine.axes, 101, 20.0, 0.01)
    pi, adaptive = (drive(machine, MAKERS[name](machine, setup), plan, setup, 101) for name in ("pi", "adaptive"))
    settled = slice(1000, None)
    ratio = np.std(pi.position_error[settled], axis=0) / np.std(adaptive.position_error[settled], axis=0)
    assert np.min(ratio) > 2.0


def run_one_case(module, case, seed, path):
    """Return what a command prints of one case and one seed, and the row that it writes."""
    app = module.typer.Typer()
    app.command()(module.main)
    options = ("--only", case, "--seeds", "1", "--first", str(seed), "--duration", "12", "--workers", "1")
    outcome = CliRunner().invoke(app, [*options, "--json", str(path)])
    assert outcome.exit_code == 0, outcome.output
    (row,) = json.loads(path.read_text())["cases"]
    return outcome.output, row


def test_command_prints_what_is_missed_and_writes_all_errors(tmp_path):
    output, row = run_one_case(command, "hinge, LuGre, 100 Hz, multisine", 101, tmp_path / "robot.json")
    assert "hinge, LuGre, 100 Hz" in output
    assert set(row["errors"]) == {"pi", "fixed", "adaptive"}
    assert row["velocity_median"] == row["velocity_least"] > 1.0
    assert row["missed"] == []


def test_joint_on_bristles_holds_still_without_kicks(tmp_path):
    """PI kicks it at each count of the encoder; so did adaptive, 1.2 times as hard as PI."""
    output, row = run_one_case(holding, "hinge, LuGre, 500 Hz", 102, tmp_path / "holding.json")
    assert "1 of 1 joints miss nothing" in output
    (joint,) = row["joints"]
    assert joint["pi"]["steps"] > 0.5
    assert joint["adaptive"]["steps"] < 0.5 * joint["pi"]["steps"]


def test_more_than_is_allowed_at_rest_is_missed():
    quiet, loud = ({"velocity": np.array([square]), "steps": np.array([square])} for square in (1e-8, 1.0))
    assert holding.judged("hinge", 0, {"pi": [quiet], "adaptive": [quiet]}, 500)["missed"] == []
    noisy = holding.judged("hinge", 0, {"pi": [quiet], "adaptive": [quiet, loud]}, 500)
    assert noisy["missed"] == ["velocity", "steps"]
    assert noisy["adaptive"]["steps"] == pytest.approx(np.sqrt(0.5), rel=1e-6)


def test_what_is_asked_is_judged():
    arm, given = (command.Case("two-link arm", "LuGre", Setup(100, False, gravity)) for gravity in (False, True))
    row = {f"{name}_{figure}": 2.0 for name in command.QUANTITIES for figure in ("median", "least", "over_fixed")}
    assert command.missed(arm, row) == ["median velocity"]
    assert command.missed(given, row) == ["over fixed"]
    assert command.missed(arm, {**row, "start_least": 0.9}) == ["start", "median velocity"]
