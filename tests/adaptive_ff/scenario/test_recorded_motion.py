"""The main job on the recorded motion of a real robot: axis 4 of a KUKA KR300, with its published friction."""

import json
from pathlib import Path

import numpy as np
import pytest

from adaptive_ff import load_scenario
from adaptive_ff.files import write_csv

ROOT = Path(__file__).resolve().parents[3]
SCENARIO = ROOT / "benchmarks" / "kuka_kr300_axis4.toml"
DATA = ROOT.parent / "shared" / "data" / "kuka_kr300"
AXIS = 3
LINK_INERTIA = 50.0  # kg m^2, assumed: the source does not hold it

pytestmark = pytest.mark.skipif(
    not DATA.is_dir(), reason=f"the recorded data lie outside the repository and are not there: {DATA}"
)


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


def test_reference_is_the_recorded_motion_until_a_minute_is_over(tmp_path):
    with np.load(DATA / "trajectory_A.npz") as record:
        time, velocity = record["t"], record["dphi_ref_rad_per_s"][:, AXIS]
    write_csv(tmp_path / "motion.csv", {"time": time, "velocity": velocity})
    scenario = load_scenario(SCENARIO, reference=tmp_path / "motion.csv")
    assert scenario.length == 60.0
    reference = scenario.reference_velocity()
    assert np.interp(time, scenario.times(), reference) == pytest.approx(velocity, abs=1e-5)
    assert np.interp(50.0 + time[:-10], scenario.times(), reference) == pytest.approx(velocity[:-10], abs=1e-3)
