"""The main job on the recorded motion of a real robot: axis 4 of a KUKA KR300, with its published friction."""

import json
from pathlib import Path

import numpy as np
import pytest
from command_line import compile_controllers, run_command_line

from adaptive_ff import load_scenario, simulate

ROOT = Path(__file__).resolve().parents[3]
SCENARIO = ROOT / "benchmarks" / "kuka_kr300_axis4.toml"
DATA = ROOT.parent / "shared" / "data" / "kuka_kr300"
AXIS = 3
LINK_INERTIA = 50.0  # kg m^2, assumed: the source does not hold it

pytestmark = pytest.mark.skipif(
    not DATA.is_dir(), reason=f"the recorded data lie outside the repository and are not there: {DATA}"
)


def write_motion(folder, column, source):
    with np.load(DATA / "trajectory_A.npz") as record:
        series = np.column_stack([record["t"], record[source][:, AXIS]])
    path = folder / f"{column}.csv"
    np.savetxt(path, series, fmt="%.17g", delimiter=",", header=f"time,{column}", comments="")
    return path


@pytest.fixture(scope="module")
def motions(tmp_path_factory):
    """The recorded reference of the axis as CSV files: its velocity and its position."""
    folder = tmp_path_factory.mktemp("motion")
    return {
        "velocity": write_motion(folder, "velocity", "dphi_ref_rad_per_s"),
        "position": write_motion(folder, "position", "phi_ref_rad"),
    }


@pytest.fixture(scope="module")
def result(motions, tmp_path_factory):
    """Result of the command of the main job."""
    compile_controllers()
    out = tmp_path_factory.mktemp("out")
    outcome = run_command_line("compare", SCENARIO, "--reference", motions["velocity"], "--out", out)
    assert (outcome.status, outcome.err) == (0, "")
    assert "adaptive_paper" in outcome.out
    return json.loads((out / "result.json").read_text(encoding="utf-8"))


def test_scenario_holds_the_figures_of_the_source():
    source = json.loads((DATA / "source_model_parameters.json").read_text(encoding="utf-8"))
    motor_inertia = source["u"][AXIS] ** 2 * source["J_mr"][AXIS]  # on the link side
    coulomb, viscous = source["f_coul"][AXIS] + source["f_a"][AXIS], source["f_vis"][AXIS]
    scenario = load_scenario(SCENARIO)
    joint, fixed = scenario.joint, scenario.fixed
    assert joint.inertia == pytest.approx(motor_inertia + LINK_INERTIA, abs=0.005)
    assert (joint.coulomb, joint.viscous) == pytest.approx((coulomb, viscous), abs=0.005)
    assert joint.stiction == pytest.approx(1.5 * coulomb, rel=0.01)
    assert scenario.actuator.torque_limit == pytest.approx(source["torque_amp_limit"] * source["u"][AXIS], rel=1e-12)
    assert scenario.feedback.inertia == fixed.inertia == pytest.approx(motor_inertia, abs=0.005)
    assert (fixed.coulomb, fixed.viscous) == (joint.coulomb, joint.viscous)


def test_reference_is_the_recorded_motion_until_a_minute_is_over(motions):
    with np.load(DATA / "trajectory_A.npz") as record:
        time, velocity = record["t"], record["dphi_ref_rad_per_s"][:, AXIS]
    scenario = load_scenario(SCENARIO, reference=motions["velocity"])
    assert scenario.length == 60.0
    reference = scenario.reference_velocity()
    assert np.interp(time, scenario.times(), reference) == pytest.approx(velocity, abs=1e-5)
    assert np.interp(50.0 + time[:-10], scenario.times(), reference) == pytest.approx(velocity[:-10], abs=1e-3)


def test_adaptive_feedforward_improves_tracking_by_a_factor_of_three_and_more_than_fixed_parameters(result):
    improvement = result["improvement"]
    assert improvement["adaptive"] >= 3.0
    assert 1.0 < improvement["fixed"] < improvement["adaptive"]
    assert improvement["adaptive"] > improvement["adaptive_paper"]
    assert improvement["adaptive"] <= 1.05 * improvement["oracle"]


def test_joint_is_identified_though_its_inertia_was_told_wrong(result):
    assumed, estimates = result["scenario"]["feedback"]["inertia"], result["controllers"]["adaptive"]["estimates"]
    true = result["scenario"]["joint"]
    assert abs(estimates["inertia"] - true["inertia"]) < 0.5 * abs(assumed - true["inertia"])
    for name in ("coulomb", "viscous"):
        assert estimates[name] == pytest.approx(true[name], rel=0.15)


def test_recorded_position_leads_to_nearly_the_same(motions, result):
    scenario = load_scenario(SCENARIO, reference=motions["position"])
    by_velocity = load_scenario(SCENARIO, reference=motions["velocity"]).reference_velocity()
    difference = scenario.reference_velocity() - by_velocity
    assert 0.0 < np.sqrt(np.mean(difference**2)) < 0.01 * np.sqrt(np.mean(by_velocity**2))
    for name in ("pi", "adaptive"):
        error = simulate(scenario, name).metrics.rms_error_settled
        assert error == pytest.approx(result["controllers"][name]["rms_error_settled"], rel=0.1)
