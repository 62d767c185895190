"""Rows without a value: few in a row are left out as if they were missing, many cut the log."""

import numpy as np
import pytest
from synthetic_logs import JOINT, make_log

from adaptive_ff.errors import InputError
from adaptive_ff.identify.identification import identify_log
from adaptive_ff.logs.cleaning import clean, without_missing_values
from adaptive_ff.logs.log import Log
from adaptive_ff.replay.replay import replay_log


@pytest.mark.parametrize(("every", "count"), [(2, 7500), (7, 2143)])
def test_log_whose_torque_is_missing_in_many_rows_is_identified(every, count):
    log = make_log(noise=0.05)
    log.torque[::every] = np.nan
    found = identify_log(log)
    assert found.cautions[0] == f"{count} rows left out: no finite number in the torque"
    assert (found.data.skipped, found.data.used, found.data.log.time.size) == ([], 15000 - count, 15000 - count)
    for name, true in JOINT.items():
        assert found.value(name) == pytest.approx(true, rel=0.05)


def test_columns_are_named_with_how_often_each_lacks_a_value():
    log = make_log(duration=1.0)
    log.torque[[10, 11, 50]] = np.nan
    log.position[[11, 70]] = np.inf
    named = Log("log", log.time, log.torque, log.position, columns={"torque": "u", "position": "q"})
    kept, said = without_missing_values(named)
    assert said == [
        "4 rows left out: no finite number in the column u of the torque, 3 times and the column q of the position, "
        "2 times"
    ]
    assert np.array_equal(kept.time, np.delete(log.time, [10, 11, 50, 70]))


@pytest.mark.parametrize(("rows", "left"), [((0,), 1), ((0, 1, 2, 3), 4), ((100, 101, 102, 103), 4), ((499,), 1)])
def test_short_stretches_are_left_out_at_the_ends_as_well(rows, left):
    log = make_log(duration=1.0)
    log.torque[list(rows)] = np.nan
    kept, _ = without_missing_values(log)
    assert kept.time.size == 500 - left
    assert np.all(np.isfinite(kept.torque))


def test_long_stretches_and_gaps_that_would_be_too_long_stay():
    log = make_log(duration=1.0)
    log.torque[100:105] = np.nan
    log.torque[200:204] = np.nan
    kept = np.ones(500, dtype=np.bool_)
    kept[204:206] = False  # missing as well
    short = log.part(kept)
    assert without_missing_values(short) == (short, [])


def test_missing_time_is_a_missing_row():
    log = make_log(duration=1.0)
    log.time[100] = np.nan
    assert without_missing_values(log)[1] == ["1 row left out: no finite number in the time"]


def test_replay_bridges_them_as_well_and_counts_without_them():
    log = make_log(noise=0.05, duration=10.0)
    log.torque[::50] = np.nan
    log.torque[2010:2030] = np.nan
    found = replay_log(log)
    assert "100 rows left out: no finite number in the torque." in found.notes
    first = 2010 - 41
    assert [skip[:2] for skip in found.data.skipped] == [(first, first + 20)]
    assert found.data.used == found.data.log.time.size - 20


def test_replay_names_the_column_that_lacks_values():
    log = make_log(duration=2.0)
    log.torque[np.arange(1000) % 10 != 0] = np.nan
    with pytest.raises(InputError, match=r"without defect; .*: the torque has no finite number in 900 of 1000 rows"):
        replay_log(log)


def test_rows_that_are_left_out_are_no_change_of_the_sample_rate():
    log = make_log()
    log.torque[5000:5400:2] = np.nan
    said = clean(log).said
    assert len(said) == 1
    assert "no finite number" in said[0]
