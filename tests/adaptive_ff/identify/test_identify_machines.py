"""Machines that other people built and measured, against their published parameters."""

import json
from pathlib import Path

import numpy as np
import pytest
from scipy import io

from adaptive_ff.identify.identification import identify_log
from adaptive_ff.logs.log import read_log

DATA = Path(__file__).resolve().parents[4] / "shared" / "data"

pytestmark = pytest.mark.skipif(
    not DATA.is_dir(), reason=f"the recorded data lie outside the repository and are not there: {DATA}"
)

EMPS = {"inertia": 95.1089, "viscous": 203.5034, "coulomb": 20.3935, "offset": -3.1648}
"""Published parameters (A. Janot, M. Gautier, M. Brunot, 2019)."""

POOR = 0.25
"""Share of the torque left from which on a model's friction is judged by its interval."""

RATIOS = [32.0, 32.0, 45.0, -48.0, 45.0, 32.0]
"""Gear ratios of the Staubli TX40, from its source."""

SOURCE = {1: {"viscous": 8.03, "coulomb": 7.23}, 4: {"viscous": 1.11, "coulomb": 2.52}}
"""Its friction, joint side, by the weighted least squares of the source."""


def read_emps(name):
    path = DATA / "emps" / name
    gain = io.loadmat(path, variable_names=["gtau"])["gtau"].item()
    return read_log(path, time="t", position="qm", torque="vir", scale={"vir": gain})


def read_staubli(joint):
    ratio = RATIOS[joint - 1]
    torque, position = f"motor_torque_Nm[{joint - 1}]", f"motor_position_rad[{joint - 1}]"
    return read_log(
        DATA / "staubli_tx40" / "tx40_exciting_trajectory.npz",
        period=2e-4,
        position=position,
        torque=torque,
        scale={position: 1.0 / ratio, torque: ratio},
    )


def read_kuka(record, axis):
    position = f"act_pos_mot_deg[{axis - 1}]"
    return read_log(
        DATA / "kuka_kr300" / f"trajectory_{record}.npz",
        time="t",
        position=position,
        torque=f"act_torque_abs_nm[{axis - 1}]",
        scale={position: np.pi / 180.0},
    )


@pytest.fixture(scope="module")
def emps():
    records = read_emps("DATA_EMPS.mat"), read_emps("DATA_EMPS_PULSES.mat")
    return identify_log(records[0], validation=records[1], linear=True, model="coulomb-viscous")


def test_emps_gives_the_published_parameters(emps):
    assert emps.value("inertia") == pytest.approx(EMPS["inertia"], rel=0.01)
    assert emps.value("viscous") == pytest.approx(EMPS["viscous"], rel=0.02)
    assert emps.value("coulomb") == pytest.approx(EMPS["coulomb"], rel=0.02)
    assert emps.value("offset") == pytest.approx(EMPS["offset"], rel=0.03)
    for name in ("viscous", "coulomb", "offset"):
        estimate = emps.parameters[name].estimate
        assert estimate.lower < EMPS[name] < estimate.upper


def test_emps_is_validated_on_the_record_with_pulses(emps):
    assert emps.bandwidth == pytest.approx(18.3, abs=0.1)
    assert emps.fit.relative_error < 0.037
    assert emps.validation.relative_error <= 0.047
    assert emps.validation.relative_error > emps.fit.relative_error


def test_emps_has_no_stribeck_peak(emps):
    assert "stiction" not in emps.parameters or not emps.parameters["stiction"].identifiable
    assert emps.curve.points.velocity.size == 6  # plateaus near 0.042, 0.083 and 0.125 m/s, both ways
    assert np.abs(emps.curve.points.velocity[3:]) == pytest.approx([0.042, 0.083, 0.125], rel=0.02)
    assert emps.curve.fit is None


def test_emps_friction_differs_by_direction_and_that_explains_its_offset(emps):
    """The published model has an offset; with viscous friction by direction it nearly vanishes."""
    found = identify_log(read_emps("DATA_EMPS.mat"), linear=True, held_out=0.0)
    assert found.parameters["viscous_asymmetry"].estimate.value < -30.0
    assert found.parameters["viscous_asymmetry"].estimate.upper < -15.0
    assert abs(found.value("offset")) < 0.5
    assert found.fit.rms_error**2 < 0.5 * emps.fit.rms_error**2
    lag = found.parameters["friction_lag"]
    assert lag.used
    assert lag.estimate.lower < 0.003 < lag.estimate.upper


@pytest.mark.parametrize(("joint", "coulomb_within"), [(1, 0.12), (4, 0.05)])
def test_staubli_gives_the_friction_of_its_source(joint, coulomb_within):
    """Parameters by the model of the source; by default, torque that was held out is said at least as well."""
    same = identify_log(read_staubli(joint), held_out=1.0 / 3.0, model="coulomb-viscous")
    assert same.value("viscous") == pytest.approx(SOURCE[joint]["viscous"], rel=0.05)
    assert same.value("coulomb") == pytest.approx(SOURCE[joint]["coulomb"], rel=coulomb_within)
    assert same.rows[0].time[-1] < 6.0 < same.held_out[0].time[0]
    found = identify_log(read_staubli(joint), held_out=1.0 / 3.0)
    assert found.validation.relative_error < {1: 0.20, 4: 0.10}[joint]
    assert found.validation.relative_error <= same.validation.relative_error


def test_staubli_joint_with_a_lumped_inertia_is_explained_worse_than_the_wrist():
    """Joint 1 turns the whole arm, whose inertia changes: its torque is explained half as well."""
    first, fourth = (identify_log(read_staubli(joint), held_out=0.0) for joint in (1, 4))
    assert first.fit.relative_error > 1.5 * fourth.fit.relative_error
    assert "no lumped joint" in first.verdict[0]
    assert "no lumped joint" not in fourth.verdict[0]


@pytest.mark.parametrize(("record", "axis"), [("A", 4), ("B", 4), ("A", 6), ("B", 6)])
def test_kuka_axis_leaves_what_was_measured_before(record, axis):
    """Rms on the own record in a band of 20 Hz, motor side: 0.26 to 0.27 N m (axes 4 and 6 of A)."""
    found = identify_log(read_kuka(record, axis), bandwidth=20.0, held_out=0.0)
    source = json.loads((DATA / "kuka_kr300" / "source_model_parameters.json").read_text(encoding="utf-8"))
    ratio = source["u"][axis - 1]
    assert found.fit.rms_error < 0.35
    published = (source["f_coul"][axis - 1] + source["f_a"][axis - 1]) / ratio
    if found.fit.relative_error > POOR:  # such a model's friction is known no better than its interval says
        _, _, lower, upper = found.parameters["coulomb"].estimate
        assert lower < 2.5 * published
        assert 0.5 * published < upper
    else:
        assert 0.5 * published < found.value("coulomb") < 2.5 * published
    assert found.value("inertia") > 0.0
