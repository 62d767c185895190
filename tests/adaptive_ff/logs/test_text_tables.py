"""Tables of text, and what the names of their columns say."""

import tracemalloc
from datetime import UTC, datetime, timedelta

import numpy as np
import pytest

from adaptive_ff import InputError
from adaptive_ff.logs.columns import foreign_unit, is_current, usual_column
from adaptive_ff.logs.formats import read_content
from adaptive_ff.logs.log import read_log
from adaptive_ff.logs.text_tables import read_table

MARKS = (("utf-16", ""), ("utf-16-le", "\ufeff"), ("utf-16-be", "\ufeff"))  # a spreadsheet's Unicode text
MINUS = "0.0 1.5 \N{MINUS SIGN}2\n0.1 1.25 300.0e\N{MINUS SIGN}1\n"
WAYS = {
    "commas": "t,q,u\n0.0,1.5,-2\n0.1,1.25,3e1\n",
    "semicolons and decimal commas": "t;q;u\n0,0;1,5;-2\n0,1;1,25;3e1\n",
    "tabs and decimal commas": "t\tq\tu\n0,0\t1,5\t-2\n0,1\t1,25\t30\n",
    "blanks": "t   q  u\n0.0 1.5   -2\n0.1  1.25 30\n",
    "comments": "# of the arm\nt,q,u\n0.0,1.5,-2\n# pause\n0.1,1.25,30\n",
    "header in a comment": "# of the arm\n# t q u\n0.0 1.5 -2\n0.1 1.25 30\n",
    "row of units": "t,q,u\n[s],[rad],[N m]\n0.0,1.5,-2\n0.1,1.25,30\n",
    "row of units and decimal commas": "t;q;u\ns;rad;\n0,0;1,5;-2\n0,1;1,25;3e1\n",
    "row of units after a blank line": "t,q,u\n\n[s],[rad],[N m]\n0.0,1.5,-2\n0.1,1.25,30\n",
    "row of units after a comment": "t,q,u\n# units\n[s],[rad],[N m]\n0.0,1.5,-2\n0.1,1.25,30\n",
    "header with a line break": 't,q,"u\n"\n0.0,1.5,-2\n0.1,1.25,30\n',
    "byte order mark": "\ufefft,q,u\n0.0,1.5,-2\n0.1,1.25,30\n",
    "Fortran in double precision": "t q u\n0.0D+00 1.5d0 -.2D+01\n1.D-01 1.25D0 0.3D+02\n",
    "minus signs": f"t q u\n{MINUS}".replace(" ", ","),  # all negative values were left out as no numbers
    "minus signs and decimal commas": f"t q u\n{MINUS}".replace(".", ",").replace(" ", ";"),
    "rows that end with a separator": "t,q,u\n0.0,1.5,-2,\n0.1,1.25,30,\n",
    "a row that ends with several": "t,q,u\n0.0,1.5,-2, ,\n0.1,1.25,30\n",
    "rows that end with a tab": "t\tq\tu\n0,0\t1,5\t-2\t\n0,1\t1,25\t30\t\n",
    "a row that ends with a comment": "t,q,u\n0.0,1.5,-2 # at rest, cold, new\n0.1,1.25,30\n",
    "quotes": 't,q,u\n"0.0","1.5","-2"\n"0.1","1.25","30"\n',
    "quotes and decimal commas": 't;q;u\n"0,0";"1,5";"-2"\n"0,1";"1,25";"30"\n',
    **{f"{order} by its mark": f"{mark}t\tq\tu\n0,0\t1,5\t-2\n0,1\t1,25\t30\n".encode(order) for order, mark in MARKS},
    "no header, Fortran": "0.0D+00 1.5d0 -.2D+01\n1.D-01 1.25D0 0.3D+02\n",
    # there are more commas in a row than what separates its cells, and it was cut at them
    **{f"no header, {one!r}": "0,0 1,5 -2\n0,1 1,25 3e1\n".replace(" ", one) for one in (";", "\t", "  ")},
}
"""The same table, as people write it."""


def written(folder, text):
    """A table as a file; its path."""
    path = folder / "log.csv"
    path.write_text(text, encoding="utf-8")
    return path


@pytest.mark.parametrize("way", WAYS)
def test_table_is_read_however_it_is_written(way, tmp_path):
    path, text = tmp_path / "log.csv", WAYS[way]
    path.write_bytes(text if isinstance(text, bytes) else text.encode())
    names = ["0", "1", "2"] if way.startswith("no header") else ["t", "q", "u"]
    layout, columns = read_table(path, [names[2], names[0], "missing", names[1]])
    assert layout.names == names
    found = {name: column.tolist() for name, column in columns.items()}
    assert found == dict(zip(names, ([0.0, 0.1], [1.5, 1.25], [-2.0, 30.0]), strict=True))


@pytest.mark.parametrize("row", ["0,1,2", "0, 1, 2", "0 ,1 ,2", "0.0,1.0, 2"])
def test_commas_between_numbers_separate_them(row, tmp_path):
    layout, columns = read_table(written(tmp_path, f"{row}\n{row}\n"), ["0", "1", "2"])
    assert layout.names == ["0", "1", "2"]
    assert [column.tolist() for column in columns.values()] == [[0.0, 0.0], [1.0, 1.0], [2.0, 2.0]]


def test_row_of_units_is_told_from_a_row_of_words(tmp_path):
    units = written(tmp_path, "t;q;u\n[s];[deg];\n0,0;1,5;-2\n")
    assert read_table(units, [])[0].units == {"t": "[s]", "q": "[deg]"}
    for text in ("t,q\n0,none\n0.1,1\n", "t,q\nnan,nan\n0.1,1\n", "t,q\n[s],[deg]\n", "0,1\n[s],[deg]\n0,1\n"):
        assert read_table(written(tmp_path, text), [])[0].units == {}, text


@pytest.mark.parametrize(
    ("text", "row", "cells"),
    [
        ("t,q,u\n1,0.0,1.5,-2\n2,0.1,1.25,30\n", 1, 4),  # numbers of rows, as R writes them
        ('"t","q","u"\n"1",0.0,1.5,-2\n"2",0.1,1.25,30\n', 1, 4),
        ("t,q,u\n0,0,0\n\n# pause\n0,002,1,5,-2,25\n", 2, 6),  # decimal commas
        ("t q u\n0.0 1.5 -2\n2026-10-03 0.1 1.25 30\n", 2, 4),
        ("t;q;u\n0,0;1,5;-2\n0,1;1,25;3e1;7\n", 2, 4),
        ("t,q,u\n0.0,lost,-2\n0.1,1.25,30,7\n", 2, 4),
    ],
)
def test_row_with_more_cells_than_the_header_is_refused(text, row, cells, tmp_path):
    with pytest.raises(InputError, match=f"the header has 3 names, but row {row} has {cells} cells: a column has no "):
        read_table(written(tmp_path, text), ["t", "q", "u"])


def test_last_line_of_words_and_rows_without_a_header_may_be_longer_and_a_header_too(tmp_path):
    longer = written(tmp_path, "t,q,u,v\n0.0,1.5,-2\n0.1,1.25,30\n")
    assert read_table(longer, ["u"])[1]["u"].tolist() == [-2.0, 30.0]
    words = written(tmp_path, "t,q\n0.0,1.5\nended, by hand, at noon\n")
    with pytest.warns(UserWarning, match="is no number"):
        assert read_table(words, ["t"])[1]["t"][0] == 0.0
    assert read_table(written(tmp_path, "0.0,1.5\n0.1,1.25,30\n"), ["1"])[1]["1"].tolist() == [1.5, 1.25]


def test_columns_without_a_header_are_named_by_their_number(tmp_path):
    (tmp_path / "log.txt").write_text("0.0 1.5 -2\n0.1 1.25 30\n", encoding="utf-8")
    log = read_log(tmp_path / "log.txt", time="0", position="1", torque="2")
    assert log.position.tolist() == [1.5, 1.25]
    with pytest.raises(InputError, match=r"there is no column t; there are 0, 1, 2"):
        read_log(tmp_path / "log.txt", time="t", position="1", torque="2")


def test_iso_times_become_seconds_and_lose_nothing_of_a_microsecond(tmp_path):
    path = written(tmp_path, "t,q\n2024-05-01T10:00:00.250,1\n2024-05-01 10:00:01.500,2\nlater,3\n")
    with pytest.warns(UserWarning, match="t = 'later' in row 3 is no number"):
        time = read_table(path, ["t"])[1]["t"]
    assert np.diff(time[:2]).tolist() == [1.25]
    assert np.isnan(time[2])
    begin = datetime(2026, 3, 1, 23, 59, 59, tzinfo=UTC)
    rows = [f"{(begin + timedelta(microseconds=2000 * k)).isoformat()},{k}" for k in range(1000)]
    time = read_table(written(tmp_path, "\n".join(["t,q", *rows])), ["t", "q"])[1]["t"]
    assert np.max(np.abs(time - 0.002 * np.arange(1000))) < 1e-12


def test_times_of_a_day_become_seconds_and_go_on_past_midnight(tmp_path):
    path = written(tmp_path, "t,q\n23:59:59.998,1\n23:59:59.999500,2\n24:01,3\n9:00,4\n:,5\n")
    with pytest.warns(UserWarning, match="t = '24:01' in row 3 is no number"):
        _, columns = read_table(path, ["t"])
    assert columns["t"][:2] == pytest.approx([0.0, 1.5e-3], abs=1e-12)
    assert np.all(np.isnan(columns["t"][2:]))
    _, columns = read_table(written(tmp_path, "t,q\n23:59:59.995,1\n00:00:00,2\n00:00:00.005,3\n"), ["t"])
    assert columns["t"] == pytest.approx([0.0, 0.005, 0.01], abs=1e-9)


def test_known_torque_is_taken_from_that_of_the_drive(tmp_path):
    path = written(tmp_path, "t,q,u,g\n0,1,5,2\n0.1,2,6,4\n")
    log = read_log(path, time="t", position="q", torque="u", known_torque="g", scale={"g": 0.5})
    assert log.torque.tolist() == [4.0, 4.0]


@pytest.mark.parametrize(
    ("ending", "hint"),
    [(".db3", "no metadata.yaml beside it"), (".xlsx", "save the"), (".npy", "numpy.savez"), (".csv.gz", "unpack it")],
)
def test_formats_that_are_not_read_get_a_hint(ending, hint, tmp_path):
    (tmp_path / f"log{ending}").write_bytes(b"x")
    with pytest.raises(InputError, match=hint):
        read_log(tmp_path / f"log{ending}", time="t", position="q", torque="u")


@pytest.mark.parametrize("gap", [False, True])
def test_reading_takes_at_most_five_times_the_size_of_the_columns(gap, tmp_path):
    rows = 8_000
    text = [f"{0.001 * k:.3f},{np.sin(k):.6f},{np.cos(k):.6f}" for k in range(rows)]
    if gap:
        text[rows // 2] = "20.0,,nan"
    path = written(tmp_path, "t,q,u\n" + "\n".join(text) + "\n")
    tracemalloc.start()
    log = read_log(path, time="t", position="q", torque="u")
    peak = tracemalloc.get_traced_memory()[1]
    tracemalloc.stop()
    assert log.time.size == rows
    assert peak <= 5 * 3 * 8 * rows


def test_a_quote_that_is_not_closed_is_refused_with_its_line_and_one_among_numbers_joins_no_lines(tmp_path):
    layout, _ = read_table(written(tmp_path, 't,q\n0,1\n1,5" pipe\n' + "2,3\n" * 5), [])
    assert (layout.units, layout.names) == ({}, ["t", "q"])
    rows = [f"{k},{2 * k}" for k in range(20)]
    rows[7] = '7,"14'
    with pytest.raises(InputError, match="a quote that begins in or after line 9 is not closed"):
        read_table(written(tmp_path, "\n".join(["time,velocity", *rows]) + "\n"), ["time", "velocity"])


FOREIGN = {
    ("position", False, "pi/180"): ["q_deg", "Position [deg]", "Angle (°)", "angleDegrees", "deg[3]"],
    ("position", False, "pi/180/1000"): ["q [mdeg]"],
    ("position", False, "2*pi"): ["q [turn]"],
    ("velocity", False, "pi/180"): ["w [deg/sec]", "speed [deg/s]", "speed_deg_per_s", "speed [degrees/s]"],
    ("velocity", False, "2*pi"): ["w [rev/sec]"],
    ("velocity", False, "pi/180/1000"): ["speed [mdeg/s]"],
    ("velocity", False, "pi/30"): ["Drehzahl [1/min]", "n_rpm[2]"],
    ("position", False, "2*pi/COUNTS_OF_A_TURN"): ["pos_counts"],
    ("time", False, "1e-3"): ["time_ms"],
    ("time", False, "1e-6"): ["t [µs]"],
    ("torque", False, "1e-3"): ["current_mA", "M [Nmm]"],
    ("torque", True, "1e-3"): ["Strom [mA]"],
    ("torque", False, "RATED/100"): ["torque [%]", "torque_pct"],
    ("torque", False, "RATED/1000"): ["torque_permille"],
    ("torque", True, "RATED/1000"): ["Torque actual value [‰]"],
    ("position", True, "1e-3"): ["z [mm]"],
    ("velocity", True, "1e-3"): ["v_mm/s"],
    ("torque", True, "1e3"): ["F [kN]"],
    # units that are taken, and words that only end like one
    ("position", False, None): ["q", "q [rad]"],
    ("position", True, None): ["z [m]"],
    ("velocity", False, None): ["w [rad/s]"],
    ("time", False, None): ["items", "t [s]"],
    ("torque", False, None): ["T [Nm]", "gamma", "I [A]"],
    ("torque", True, None): ["F [N]"],
}
"""Columns by role, whether the axis is linear, and factor; None for units as they are taken and for mere words."""


@pytest.mark.parametrize(("kind", "columns"), FOREIGN.items())
def test_unit_at_the_end_of_a_name_is_seen(kind, columns):
    role, linear, factor = kind
    found = {column: getattr(foreign_unit(column, role, linear=linear), "factor", None) for column in columns}
    assert found == dict.fromkeys(columns, factor)


def test_degrees_of_a_velocity_are_per_second_and_currents_are_known_by_their_name_or_by_amperes():
    assert foreign_unit("w_deg", "velocity", linear=False) == ("degrees per second", "rad/s", "pi/180")
    assert all(map(is_current, ("current", "i_q", "motor_current[2]", "Strom [mA]", "I [A]", "I (A rms)")))
    assert not any(map(is_current, ("u", "gamma", "M")))


OTHER_AXIS = {
    ("position", False): {"pos_mm": "millimetres", "z [m]": "m", "pos_counts": None, "q_m": None},
    ("velocity", False): {"v (m/s)": "m/s"},
    ("torque", False): {"F [N]": "N", "F_kN[2]": "kN", "u_N": None, "M [Nm]": None},
    ("position", True): {"q_deg": "degrees", "q [rad]": "rad", "Straße [RAD]": "rad", "z [mm]": None},
    ("velocity", True): {"n_rpm": "revolutions per minute"},
    ("torque", True): {"M [Nm]": "N m", "tau_Nmm": "mN m", "torque [%]": None, "I [mA]": None},
    ("time", False): {"t [min]": None},
}
"""Units that only the other kind of axis has, by role, whether the axis is linear, and name of the column."""


@pytest.mark.parametrize(("kind", "units"), OTHER_AXIS.items())
def test_unit_of_the_other_kind_of_axis_is_seen(kind, units):
    found = {column: foreign_unit(column, kind[0], linear=kind[1]) for column in units}
    assert {column: one.name if one and not one.factor else None for column, one in found.items()} == units


USUAL = [(["Time", "t"], "Time"), (["TIME", "time"], "time"), (["stamp", "t"], "t"), (["T", "stamp"], None)]
USUAL += [(["Timestamp", "position"], "Timestamp")]


@pytest.mark.parametrize(("names", "found"), USUAL)
def test_usual_names_may_be_written_with_capitals_where_they_are_words(tmp_path, names, found):
    path = written(tmp_path, ",".join(names) + "\n0.0,0.0\n")
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
