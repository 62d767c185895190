"""Columns that are found by their usual names."""

import pytest

from adaptive_ff import InputError
from adaptive_ff.logs.columns import usual_column


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
        assert usual_column(path, names, ["time"]) == ("time", found)
    else:
        with pytest.raises(InputError, match="none is called time or t or timestamp"):
            usual_column(path, names, ["time"])
