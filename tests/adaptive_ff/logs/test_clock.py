"""Rows with the time of the row before: a rounded clock is rebuilt, repeated rows are left out, and both are said."""

from dataclasses import replace

import numpy as np
import pytest
from synthetic_logs import JOINT, make_log

from adaptive_ff.identify.identification import identify_log
from adaptive_ff.logs.cleaning import with_clear_clock
from adaptive_ff.logs.log import Log
from adaptive_ff.replay.replay import replay_log

TICK = 1e-3


def rounded_clock(rate, tick=TICK, rounding=np.round, **options):
    """A log with the times that a coarse clock shows, and the true ones."""
    log = make_log(period=1.0 / rate, noise=0.05, **options)
    return replace(log, time=tick * rounding(log.time / tick)), log.time


@pytest.mark.parametrize("as_position", [True, False])
@pytest.mark.parametrize("rounding", [np.round, np.floor])
@pytest.mark.parametrize(("rate", "tick"), [(2000.0, TICK), (1300.0, TICK), (500.0, 1.0 / 64.0)])
def test_times_of_a_rounded_clock_are_rebuilt_and_said(rate, tick, rounding, as_position):
    log, times = rounded_clock(rate, tick, rounding, as_position=as_position)
    repeated = np.count_nonzero(np.diff(log.time) == 0.0)
    mended, said = with_clear_clock(log)
    assert np.std(mended.time - times) < 0.01 * tick  # a constant offset does not matter
    assert np.max(np.abs(mended.time - times)) < tick
    assert said == [
        f"{repeated} rows have the time of the one before, as of a rounded clock; the rows look evenly sampled, so "
        f"their times are rebuilt, {1e3 / rate:.4g} ms apart"
    ]


@pytest.mark.parametrize("rounding", [np.round, np.floor])
def test_a_clock_of_few_ticks_tells_the_sample_time_too(rounding):
    """As where a spreadsheet wrote seconds since 1970 with nine digits: it came out 1.4 % too long."""
    log, times = rounded_clock(500.0, 10.0, rounding, duration=60.0)
    mended, (said,) = with_clear_clock(log)
    assert "2 ms apart" in said
    assert np.diff(mended.time) == pytest.approx(np.diff(times), rel=1e-3)


def test_log_of_a_rounded_clock_tells_the_joint():
    """Nearly the whole log was lost, in segments of two samples."""
    log, _ = rounded_clock(2000.0, duration=15.0)
    found = identify_log(log)
    assert found.data.used == log.time.size
    assert any("as of a rounded clock" in caution for caution in found.cautions)
    for name, true in JOINT.items():
        assert found.value(name) == pytest.approx(true, rel=0.05)
    replayed = replay_log(log)
    assert replayed.data.used == log.time.size
    assert any("as of a rounded clock" in note for note in replayed.notes)


def test_rounded_clock_is_followed_anew_behind_a_pause():
    log, times = rounded_clock(2000.0)
    kept = np.ones(times.size, dtype=np.bool_)
    kept[20000:21000] = False
    mended, said = with_clear_clock(log.part(kept))
    apart = mended.time - times[kept]
    assert np.ptp(apart[:20000]) < 0.02 * TICK
    assert np.ptp(apart[20000:]) < 0.02 * TICK
    assert np.max(np.abs(apart)) < TICK
    assert len(said) == 1


def test_rows_that_are_not_evenly_sampled_are_left_out_and_counted():
    log = make_log(noise=0.05)
    random = np.random.default_rng(7)
    again = np.sort(random.choice(log.time.size, 3000, replace=False))
    places = np.sort(np.concatenate([np.arange(log.time.size), again]))
    torque = log.torque[places] + 0.01 * random.standard_normal(places.size)
    found = identify_log(Log("log", log.time[places], torque, log.position[places]))
    assert found.data.used == log.time.size
    assert found.cautions == ["3000 rows left out: with the time of the row before, but other values"]
    for name, true in JOINT.items():
        assert found.value(name) == pytest.approx(true, rel=0.05)


def test_rows_written_twice_with_another_torque_are_no_rounded_clock():
    """They are as even as those of a clock that shows every second sample, but the joint does not move between them."""
    log = make_log(noise=0.05)
    torque = np.repeat(log.torque, 2)
    torque[1::2] += 0.01
    mended, said = with_clear_clock(Log("log", np.repeat(log.time, 2), torque, np.repeat(log.position, 2)))
    assert np.array_equal(mended.time, log.time)
    assert np.array_equal(mended.torque, log.torque)
    assert said == [f"{log.time.size} rows left out: with the time of the row before, but other values"]


def test_a_few_repeated_times_leave_the_others_as_they_are():
    log = make_log(noise=0.05)
    places = np.insert(np.arange(log.time.size), [400, 9000], [400, 9000])
    torque = log.torque[places]
    torque[401] += 0.1
    mended, said = with_clear_clock(Log("log", log.time[places], torque, log.position[places]))
    assert np.array_equal(mended.time, log.time)
    assert said == [
        "1 row left out: the same as the one before, time included",
        "1 row left out: with the time of the row before, but other values",
    ]


def test_clear_clock_is_left_as_it_is():
    log = make_log(noise=0.05)
    assert with_clear_clock(log) == (log, [])


@pytest.mark.parametrize("value", [np.nan, np.inf, -np.inf, 1e300])
def test_values_that_are_none_in_the_motion_do_not_matter(value):
    log, times = rounded_clock(2000.0)
    log.position[3000:3100] = value
    mended, _ = with_clear_clock(log)
    assert np.max(np.abs(mended.time - times)) < TICK
