"""Units that names of columns say, as laboratories write them."""

import pytest

from adaptive_ff.logs.columns import foreign_unit, is_current, unit_of_other_axis

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
]
OWN = [
    ("q", "position", False),
    ("q [rad]", "position", False),
    ("z [m]", "position", True),
    ("w [rad/s]", "velocity", False),
    ("items", "time", False),
    ("t [s]", "time", False),
    ("T [Nm]", "torque", False),
    ("gamma", "torque", False),
    ("I [A]", "torque", False),
    ("F [N]", "torque", True),
]


@pytest.mark.parametrize(("column", "role", "linear", "factor"), FOREIGN)
def test_unit_at_the_end_of_a_name_is_seen(column, role, linear, factor):
    unit = foreign_unit(column, role, linear=linear)
    assert unit is not None
    assert unit.factor == factor


def test_velocity_in_degrees_is_said_to_be_per_second():
    assert foreign_unit("w_deg", "velocity", linear=False) == ("degrees per second", "rad/s", "pi/180")


@pytest.mark.parametrize(("column", "role", "linear"), OWN)
def test_unit_that_is_taken_and_words_that_only_end_like_one_are_left(column, role, linear):
    assert foreign_unit(column, role, linear=linear) is None


@pytest.mark.parametrize(
    ("column", "expected"), [("Strom [mA]", True), ("I [A]", True), ("I (A rms)", True), ("gamma", False), ("M", False)]
)
def test_amperes_are_seen(column, expected):
    assert is_current(column) is expected


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
        ("Straße [RAD]", "position", True, "RAD"),
        ("n_rpm", "velocity", True, "revolutions per minute"),
        ("M [Nm]", "torque", True, "Nm"),
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
    assert unit_of_other_axis(column, role, linear=linear) == unit
