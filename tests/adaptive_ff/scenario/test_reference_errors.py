"""Recorded motions that cannot be used: the message names the file, the column, the value and the row."""

import numpy as np
import pytest

from adaptive_ff import InputError, load_scenario
from adaptive_ff.scenario.reference import Recorded

GOOD = ["time,velocity", "0,0.0", "20,0.1", "40,-0.1", "60,0.0"]


def refusal(path):
    """The message; the same, behind its own name, when the motion is asked for by a scenario."""
    with pytest.raises(InputError) as caught:
        Recorded(kind="csv", path=str(path)).read()
    with pytest.raises(InputError) as asked:
        load_scenario(reference=path)
    message = str(caught.value)
    assert message.splitlines() == [message]
    assert message.startswith(f"{path}: ")
    assert str(asked.value) == f"built-in scenario: {message}"
    return message.removeprefix(f"{path}: ")


def refusal_of(folder, lines):
    path = folder / "motion.csv"
    path.write_text("\n".join(lines) + "\n", encoding="utf-8")
    return refusal(path)


def with_line(number, line):
    return [*GOOD[:number], line, *GOOD[number + 1 :]]


def test_good_lines_are_accepted(tmp_path):
    path = tmp_path / "motion.csv"
    path.write_text("\n".join(GOOD), encoding="utf-8")
    assert load_scenario(reference=path).motion.duration == 60.0


@pytest.mark.parametrize(
    "lines",
    [
        ["time;velocity", "0;0,0", "20;0,1", "40;-0,1", "60;0,0"],
        ["# by the drive", "time\tvelocity", "0\t0.0", "20\t0.1", "", "40\t-0.1", "60\t0.0"],
        ['"time","velocity"', *GOOD[1:]],
    ],
    ids=["semicolons and decimal commas", "tabs and comments", "quotes"],
)
def test_motion_is_read_as_logs_are(tmp_path, lines):
    plain, other = tmp_path / "plain.csv", tmp_path / "other.csv"
    plain.write_text("\n".join(GOOD), encoding="utf-8")
    other.write_text("\n".join(lines), encoding="utf-8")
    time = np.linspace(0.0, 60.0, 61)
    motions = [Recorded(kind="csv", path=str(path)).read().velocity(time) for path in (plain, other)]
    assert np.array_equal(*motions)
    assert np.ptp(motions[0]) > 0.1


@pytest.mark.parametrize("lines", [[], ["", "  ", ",,"]])
def test_empty_file(tmp_path, lines):
    assert refusal_of(tmp_path, lines) == "the file is empty; it must have a header line and rows of numbers"


@pytest.mark.parametrize("rows", [0, 1, 3])
def test_too_few_rows(tmp_path, rows):
    message = refusal_of(tmp_path, GOOD[: 1 + rows])
    assert message == f"{rows} rows are not enough for a motion; there must be at least 4"


@pytest.mark.parametrize("header", ["t,velocity", "time,speed", "time", "0,0.0", "Time,Velocity"])
def test_missing_column(tmp_path, header):
    message = refusal_of(tmp_path, with_line(0, header))
    assert message == f"the columns are {', '.join(header.split(','))}; there must be time and velocity or position"


def test_long_header_with_quoted_line_breaks_is_answered_in_one_line(tmp_path):
    message = refusal_of(tmp_path, with_line(0, ",".join(f'"column\n{i}"' for i in range(100))))
    assert message.startswith("the columns are column 0, column 1")
    assert len(message) < 200


@pytest.mark.parametrize(
    "cell", ["nan", "inf", "-inf", "1e400", "", " ", "fast", "0.1 rad/s", "0x10", "1_0", "--1", "None", "\u00bd"]
)
def test_cell_that_is_no_finite_number(tmp_path, cell):
    message = refusal_of(tmp_path, with_line(3, f"40,{cell}"))
    assert message == f"velocity = {cell!r} in row 3 is not allowed: it must be a finite number"
    message = refusal_of(tmp_path, with_line(3, f"{cell},0.1"))
    assert message == f"time = {cell!r} in row 3 is not allowed: it must be a finite number"


def test_row_that_is_too_short(tmp_path):
    message = refusal_of(tmp_path, with_line(2, "20"))
    assert message == "velocity = '' in row 2 is not allowed: it must be a finite number"


@pytest.mark.parametrize("line", ["20,0,0,1", "20,0.1,,7"])  # the first as decimal commas would make it
def test_row_that_is_too_long(tmp_path, line):
    assert refusal_of(tmp_path, with_line(2, line)).startswith("the header has 2 names, but row 2 has 4 cells: ")


def test_column_that_is_there_twice(tmp_path):
    lines = [f"{line},{line.split(',')[1]}" for line in GOOD]
    assert refusal_of(tmp_path, lines) == "there are 2 columns velocity; there must be one"


@pytest.mark.parametrize(
    ("time", "row", "before"), [("20", 3, "20"), ("19.9", 3, "20"), ("-1e300", 3, "20"), ("60", 4, "60")]
)
def test_times_that_do_not_ascend(tmp_path, time, row, before):
    message = refusal_of(tmp_path, with_line(3, f"{time},0.1"))
    after = "60" if row == 4 else f"{float(time):g}"
    assert message == f"time = {after} s in row {row} follows {before} s; times must ascend strictly"


def test_times_that_are_too_far_from_the_first_to_be_told_apart(tmp_path):
    message = refusal_of(tmp_path, [GOOD[0], "-1e18,0", *GOOD[2:]])
    assert message == "time = 40 s in row 3 follows 20 s; times must ascend strictly"


def test_times_that_span_more_than_floating_point(tmp_path):
    message = refusal_of(tmp_path, [GOOD[0], "-1e308,0", "0,0", "1e308,0", "1.1e308,0"])
    assert message == "time = 1.1e+308 s in row 4 follows 1e+308 s; times must ascend strictly"
    message = refusal_of(tmp_path, [GOOD[0], "-1e308,0", "-1e307,0", "0,0", "1e308,0"])
    assert message.startswith("no smooth curve goes through the values: ")


@pytest.mark.parametrize("content", [b"\xff\xfe\x00\xd8t\x00i\x00", b"time,velocity\n0,\xe9\n", b"x" * 200_000])
def test_file_that_is_no_text_of_this_kind(tmp_path, content):
    path = tmp_path / "motion.csv"
    path.write_bytes(content)
    assert refusal(path).startswith("cannot be read: ")


@pytest.mark.parametrize("name", [".", "missing.csv", "motion.csv/inside", "x" * 300])
def test_file_that_cannot_be_read(tmp_path, name):
    (tmp_path / "motion.csv").write_text("\n".join(GOOD), encoding="utf-8")
    assert refusal(tmp_path / name).startswith("cannot be read: ")
