"""Columns by their names: the usual ones, and the units that others say, as laboratories write them."""

import numpy as np
import pytest

from adaptive_ff import InputError, read_log
from adaptive_ff.logs.columns import foreign_unit, is_current, usual_column
from adaptive_ff.logs.formats import read_content

FOREIGN = [
    ("q_deg", "position", False, "pi/180"),
    ("Position [deg]", "position", False, "pi/180"),
    ("Angle (°)", "position", False, "pi/180"),
    ("angleDegrees", "position", False, "pi/180"),
    ("q [mdeg]", "position", False, "pi/180/1000"),
    ("q [turn]", "position", False, "2*pi"),
    ("w [deg/sec]", "velocity", False, "pi/180"),
    ("w [rev/sec]", "velocity", False, "2*pi"),
    ("deg[3]", "position", False, "pi/180"),
    ("speed [deg/s]", "velocity", False, "pi/180"),
    ("speed_deg_per_s", "velocity", False, "pi/180"),
    ("speed [degrees/s]", "velocity", False, "pi/180"),
    ("speed [mdeg/s]", "velocity", False, "pi/180/1000"),
    ("Drehzahl [1/min]", "velocity", False, "pi/30"),
    ("n_rpm[2]", "velocity", False, "pi/30"),
    ("pos_counts", "position", False, "2*pi/COUNTS_OF_A_TURN"),
    ("time_ms", "time", False, "1e-3"),
    ("t [µs]", "time", False, "1e-6"),
    ("current_mA", "torque", False, "1e-3"),
    ("Strom [mA]", "torque", True, "1e-3"),
    ("M [Nmm]", "torque", False, "1e-3"),
    ("torque [%]", "torque", False, "RATED/100"),
    ("torque_pct", "torque", False, "RATED/100"),
    ("torque_permille", "torque", False, "RATED/1000"),
    ("Torque actual value [‰]", "torque", True, "RATED/1000"),
    ("z [mm]", "position", True, "1e-3"),
    ("v_mm/s", "velocity", True, "1e-3"),
    ("F [kN]", "torque", True, "1e3"),
    # units that are taken, and words that only end like one
    ("q", "position", False, None),
    ("q [rad]", "position", False, None),
    ("z [m]", "position", True, None),
    ("w [rad/s]", "velocity", False, None),
    ("items", "time", False, None),
    ("t [s]", "time", False, None),
    ("T [Nm]", "torque", False, None),
    ("gamma", "torque", False, None),
    ("I [A]", "torque", False, None),
    ("F [N]", "torque", True, None),
]


@pytest.mark.parametrize(("column", "role", "linear", "factor"), FOREIGN)
def test_unit_at_the_end_of_a_name_is_seen(column, role, linear, factor):
    assert getattr(foreign_unit(column, role, linear=linear), "factor", None) == factor


def test_velocity_in_degrees_is_said_to_be_per_second():
    assert foreign_unit("w_deg", "velocity", linear=False) == ("degrees per second", "rad/s", "pi/180")


def test_currents_are_known_by_their_name_or_by_amperes():
    assert all(map(is_current, ("current", "i_q", "motor_current[2]", "Strom [mA]", "I [A]", "I (A rms)")))
    assert not any(map(is_current, ("u", "gamma", "M")))


@pytest.mark.parametrize(
    ("column", "role", "linear", "unit"),
    [
        ("pos_mm", "position", False, "millimetres"),
        ("z [m]", "position", False, "m"),
        ("v (m/s)", "velocity", False, "m/s"),
        ("F [N]", "torque", False, "N"),
        ("F_kN[2]", "torque", False, "kN"),
        ("q_deg", "position", True, "degrees"),
        ("q [rad]", "position", True, "rad"),
        ("Straße [RAD]", "position", True, "rad"),
        ("n_rpm", "velocity", True, "revolutions per minute"),
        ("M [Nm]", "torque", True, "N m"),
        ("tau_Nmm", "torque", True, "mN m"),
        ("pos_counts", "position", False, None),
        ("torque [%]", "torque", True, None),
        ("I [mA]", "torque", True, None),
        ("q_m", "position", False, None),
        ("u_N", "torque", False, None),
        ("t [min]", "time", False, None),
        ("M [Nm]", "torque", False, None),
        ("z [mm]", "position", True, None),
    ],
)
def test_unit_of_the_other_kind_of_axis_is_seen(column, role, linear, unit):
    found = foreign_unit(column, role, linear=linear)
    assert (found.name if found and not found.factor else None) == unit


@pytest.mark.parametrize(
    ("names", "found"),
    [
        (["Time", "t"], "Time"),
        (["TIME", "time"], "time"),
        (["stamp", "t"], "t"),
        (["Timestamp", "position"], "Timestamp"),
        (["T", "stamp"], None),
    ],
)
def test_usual_names_may_be_written_with_capitals_where_they_are_words(tmp_path, names, found):
    path = tmp_path / "log.csv"
    path.write_text(",".join(names) + "\n0.0,0.0\n", encoding="utf-8")
    if found is not None:
        assert usual_column(path, read_content(path, ()), ["time"]) == ("time", found)
    else:
        with pytest.raises(InputError, match="none is called time or t or timestamp"):
            usual_column(path, read_content(path, ()), ["time"])


def test_file_without_a_column_is_said_to_have_none(tmp_path):
    np.savez(tmp_path / "log.npz")
    with pytest.raises(InputError, match=r"--time must name a column, .*; there are none$"):
        usual_column(tmp_path / "log.npz", read_content(tmp_path / "log.npz", ()), ["time"])
    with pytest.raises(InputError, match=r"there is no column u; there are none$"):
        read_log(tmp_path / "log.npz", time="t", position="q", torque="u")
