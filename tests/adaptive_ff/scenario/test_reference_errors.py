"""Recorded motions that cannot be used: the message names the file, the column, the value and the row."""

import numpy as np
import pytest
from scenario_files import refused

from adaptive_ff import load_scenario
from adaptive_ff.scenario.reference import Recorded

GOOD = ["time,velocity", "0,0.0", "20,0.1", "40,-0.1", "60,0.0"]


def refusal(path):
    """The message; the same, behind its own name, when the motion is asked for by a scenario."""
    message = refused(f"{path}: ", Recorded(kind="csv", path=str(path)).read)
    assert refused(f"built-in scenario: {path}: ", load_scenario, reference=path) == message
    return message


def refusal_of(folder, lines):
    path = folder / "motion.csv"
    path.write_text("\n".join(lines) + "\n", encoding="utf-8")
    return refusal(path)


def with_line(number, line):
    return [*GOOD[:number], line, *GOOD[number + 1 :]]


def test_motion_is_read_as_logs_are(tmp_path):
    """In all ways in which tables of a log are: here comments, semicolons and decimal commas."""
    plain, other = tmp_path / "plain.csv", tmp_path / "other.csv"
    plain.write_text("\n".join(GOOD), encoding="utf-8")
    other.write_text("# by the drive\ntime;velocity\n0;0,0\n\n20;0,1\n40;-0,1\n60;0,0", encoding="utf-8")
    time = np.linspace(0.0, 60.0, 61)
    motions = [Recorded(kind="csv", path=str(path)).read().velocity(time) for path in (plain, other)]
    assert np.array_equal(*motions)
    assert np.ptp(motions[0]) > 0.1


COLUMNS = ("t,velocity", "time,speed", "time", "0,0.0", "Time,Velocity")
CELLS = ("nan", "inf", "-inf", "1e400", "", " ", "fast", "0.1 rad/s", "0x10", "1_0", "--1", "None", "\u00bd")
NUMBER = "is not allowed: it must be a finite number"
MESSAGES = [
    *((lines, "the file is empty; it must have a header line and rows of numbers") for lines in ([], ["", "  ", ",,"])),
    *((GOOD[:rows], f"{rows - 1} rows are not enough for a motion; there must be at least 4") for rows in (1, 2, 4)),
    *(
        (with_line(0, one), f"the columns are {one.replace(',', ', ')}; there must be time and velocity or position")
        for one in COLUMNS
    ),
    *((with_line(3, f"40,{cell}"), f"velocity = {cell!r} in row 3 {NUMBER}") for cell in CELLS),
    *((with_line(3, f"{cell},0.1"), f"time = {cell!r} in row 3 {NUMBER}") for cell in CELLS),
    (with_line(2, "20"), f"velocity = '' in row 2 {NUMBER}"),
    ([f"{line},{line.split(',')[1]}" for line in GOOD], "there are 2 columns velocity; there must be one"),
    *(
        (lines, f"time = {time} s in row {row} follows {before} s; times must ascend strictly")
        for lines, time, row, before in (
            (with_line(3, "20,0.1"), 20, 3, 20),
            (with_line(3, "19.9,0.1"), 19.9, 3, 20),
            (with_line(3, "-1e300,0.1"), "-1e+300", 3, 20),
            (with_line(3, "60,0.1"), 60, 4, 60),
            (with_line(1, "-1e18,0"), 40, 3, 20),  # too far from the first to be told apart
            ([GOOD[0], "-1e308,0", "0,0", "1e308,0", "1.1e308,0"], "1.1e+308", 4, "1e+308"),
        )
    ),
]


@pytest.mark.parametrize(("lines", "message"), MESSAGES)
def test_lines_that_are_no_motion(tmp_path, lines, message):
    assert refusal_of(tmp_path, lines) == message


@pytest.mark.parametrize(
    ("lines", "begin"),
    [
        # as decimal commas would make it
        (with_line(2, "20,0,0,1"), "the header has 2 names, but row 2 has 4 cells: "),
        (with_line(2, "20,0.1,,7"), "the header has 2 names, but row 2 has 4 cells: "),
        ([GOOD[0], "-1e308,0", "-1e307,0", "0,0", "1e308,0"], "no smooth curve goes through the values: "),
        (with_line(0, ",".join(f'"column\n{i}"' for i in range(100))), "the columns are column 0, column 1"),
    ],
)
def test_message_of_long_lines_is_short(tmp_path, lines, begin):
    message = refusal_of(tmp_path, lines)
    assert message.startswith(begin)
    assert len(message) < 200


@pytest.mark.parametrize("content", [b"\xff\xfe\x00\xd8t\x00i\x00", b"time,velocity\n0,\xe9\n", b"x" * 200_000])
def test_file_that_is_no_text_of_this_kind(tmp_path, content):
    path = tmp_path / "motion.csv"
    path.write_bytes(content)
    assert refusal(path).startswith("cannot be read: ")


@pytest.mark.parametrize("name", [".", "missing.csv", "motion.csv/inside", "x" * 300])
def test_file_that_cannot_be_read(tmp_path, name):
    (tmp_path / "motion.csv").write_text("\n".join(GOOD), encoding="utf-8")
    assert refusal(tmp_path / name).startswith("cannot be read: ")
