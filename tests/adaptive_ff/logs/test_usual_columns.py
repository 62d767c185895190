"""Columns that are found by their usual names."""

import numpy as np
import pytest

from adaptive_ff import InputError, read_log
from adaptive_ff.logs.columns import usual_column
from adaptive_ff.logs.formats import read_content


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
