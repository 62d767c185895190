"""Clocks that are rounded or change their rate, and columns that are sampled more slowly than the log."""

from dataclasses import replace

import numpy as np
import pytest
from scipy.interpolate import CubicSpline
from synthetic_logs import JOINT, make_log

from adaptive_ff.identify.identification import identify_log
from adaptive_ff.logs.cleaning import rows_between, with_clear_clock, without_repeated_rows
from adaptive_ff.logs.defects import Skipped, usable_segments
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
    log, times = rounded_clock(500.0, 10.0, rounding, duration=40.0)
    mended, (said,) = with_clear_clock(log)
    assert "2 ms apart" in said
    assert np.max(np.abs(np.diff(mended.time) / np.diff(times) - 1.0)) < 1e-3


def test_log_of_a_rounded_clock_tells_the_joint():
    """Nearly the whole log was lost, in segments of two samples."""
    log, _ = rounded_clock(2000.0, duration=8.0)
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
    kept = np.delete(np.arange(times.size), np.s_[20000:21000])
    mended, said = with_clear_clock(log.part(kept))
    apart = mended.time - times[kept]
    assert np.ptp(apart[:20000]) < 0.02 * TICK
    assert np.ptp(apart[20000:]) < 0.02 * TICK
    assert np.max(np.abs(apart)) < TICK
    assert len(said) == 1


def test_rows_that_are_not_evenly_sampled_are_left_out_and_counted():
    log = make_log(noise=0.05, duration=12.0)
    random = np.random.default_rng(7)
    again = np.sort(random.choice(log.time.size, 1200, replace=False))
    places = np.sort(np.concatenate([np.arange(log.time.size), again]))
    torque = log.torque[places] + 0.01 * random.standard_normal(places.size)
    found = identify_log(Log("log", log.time[places], torque, log.position[places]))
    assert found.data.used == log.time.size
    assert found.cautions == ["1200 rows left out: with the time of the row before; 1200 have other values"]
    for name, true in JOINT.items():
        assert found.value(name) == pytest.approx(true, rel=0.05)


@pytest.mark.parametrize(("added", "others"), [(0.01, 15000), (0.0, 0)])
def test_rows_written_twice_are_no_rounded_clock(added, others):
    """They are as even as those of a clock that shows every second sample, but the joint does not move between them."""
    log = make_log(noise=0.05)
    torque = np.repeat(log.torque, 2)
    torque[1::2] += added
    mended, notes = with_clear_clock(Log("log", np.repeat(log.time, 2), torque, np.repeat(log.position, 2)))
    assert np.array_equal(mended.time, log.time)
    assert np.array_equal(mended.torque, log.torque)
    assert notes == [f"15000 rows left out: with the time of the row before; {others} have other values"]


@pytest.mark.parametrize("value", [np.nan, np.inf, -np.inf, 1e300])
def test_values_that_are_none_in_the_motion_do_not_matter(value):
    log, times = rounded_clock(2000.0)
    log.position[3000:3100] = value
    mended, _ = with_clear_clock(log)
    assert np.max(np.abs(mended.time - times)) < TICK


def thinned(every, start=5000, stop=10000):
    """A log of 20 s, and of some rows only one of so many."""
    log = make_log(noise=0.05, duration=20.0)
    place = np.arange(log.time.size)
    return log.part((place < start) | (place >= stop) | ((place - start) % every == 0))


def test_slower_part_that_is_bridged_is_used():
    found = identify_log(thinned(5))
    assert (found.cautions, found.data.used) == ([], 6000)
    assert found.value("inertia") == pytest.approx(2.0, rel=0.02)


def test_much_slower_part_is_left_out_as_a_whole():
    log = thinned(10)
    skipped = [
        Skipped(5001, 5001, "the clock leaves a gap, from 10 s to 10.02 s"),
        Skipped(5001, 5500, "segments of less than 32 samples"),
    ]
    found = identify_log(log)
    assert (found.cautions, found.data.skipped, found.data.used) == ([], skipped, 5001)
    assert replay_log(log).data.skipped == skipped


def test_much_slower_part_between_others_is_skipped_as_one():
    found = identify_log(thinned(10, 3000, 6000))
    assert (found.cautions, found.data.used) == ([], 7001)
    assert [skip[:2] for skip in found.data.skipped] == [(3001, 3001), (3001, 3300), (3300, 3300)]
    assert [skip.reason for skip in found.data.skipped] == [
        "the clock leaves a gap, from 6 s to 6.02 s",
        "segments of less than 32 samples",
        "the clock leaves a gap, from 11.98 s to 12 s",
    ]


@pytest.mark.parametrize("kind", ["jitter", "missing", "rounded", "irregular"])
def test_uneven_clock_is_not_cut_to_pieces(kind):
    random = np.random.default_rng(6)
    time = 0.0015 * np.arange(10000)
    clocks = {
        "jitter": time + random.uniform(-0.0007, 0.0007, time.size),
        "missing": time[random.random(time.size) < 0.6],
        "rounded": np.floor(1e3 * time) * 1e-3,
        "irregular": np.cumsum(random.exponential(0.0015, time.size)),
    }
    assert len(usable_segments(Log(kind, *[clocks[kind]] * 3))[1]) <= 1


def held(values, every):
    """Each value is that at the last tick of a clock that ticks once in so many rows."""
    rows = np.arange(values.size)
    return CubicSpline(rows, values)(every * np.floor(rows / every + 1e-9))


def rounded(values, step):
    return step * np.round(values / step)


@pytest.mark.parametrize("every", [2, 3, 10, 3.3])
def test_rows_with_a_new_value_are_found(every):
    log = make_log()
    slow = replace(log, position=held(log.position, every))
    found, _ = without_repeated_rows(slow)
    assert rows_between(slow.position) == pytest.approx(every, abs=0.01)
    assert found.time.size == pytest.approx(log.time.size / every, rel=2e-3)
    assert np.max(np.diff(found.time)) <= np.ceil(every) * 0.002 + 1e-9


@pytest.mark.parametrize("share", [1.0, 0.05])
@pytest.mark.parametrize("counts", [256, 1024, 65536])
def test_coarse_encoder_holds_nothing(counts, share):
    """Nor does it where the joint is so slow that no two rows differ."""
    assert rows_between(rounded(share * make_log().position, 2.0 * np.pi / counts)) == 1.0


@pytest.mark.parametrize("decimals", [3, 9])
def test_coarse_encoder_of_a_slow_joint_holds_nothing_though_its_file_is_rounded(decimals):
    """A count of 1.5 mrad is written as 0.001 or 0.002 rad, and hardly two rows in a row differ."""
    time = 0.001 * np.arange(60_000)
    position = 0.3 * np.sin(2.0 * np.pi * 0.3 * time) + 0.09 * np.sin(2.0 * np.pi * 0.111 * time)
    assert rows_between(np.round(rounded(position, 2.0 * np.pi / 4096), decimals)) == 1.0


def test_ripple_of_the_torque_does_not_fold_into_the_motion():
    """Rows of the torque as they are left 13 %, and inertia 5 % off."""
    log = make_log(noise=0.05, period=0.001, duration=15.0)
    torque = log.torque + 2.0 * np.sin(2.0 * np.pi * 200.3 * log.time)
    found = identify_log(replace(log, position=held(log.position, 5), torque=torque), model="offset")
    assert found.best.left < 0.01
    for name in ("inertia", "coulomb", "viscous"):
        assert found.parameters[name].value == pytest.approx(JOINT[name], rel=0.01)


@pytest.mark.parametrize("place", [15_000, 15_001, 15_003])
def test_no_row_is_made_up_within_a_pause(place):
    log = make_log(noise=0.05, period=0.001)
    time = log.time + 5.0 * (np.arange(log.time.size) >= place)
    read, _ = without_repeated_rows(replace(log, time=time, position=held(log.position, 2.5)))
    assert np.count_nonzero(np.diff(read.time) > 0.1) == 1


def test_rest_stays_in_the_log():
    log = make_log(duration=30.0)
    position = log.position[np.minimum(np.arange(log.time.size), 10_000)]
    position[12_000:] += log.position[12_000:] - log.position[12_000]
    found, _ = without_repeated_rows(replace(log, position=held(position, 4)))
    assert np.diff(found.time) == pytest.approx(0.008)


@pytest.mark.parametrize("every", [4, 2.7])
def test_joint_is_found_behind_a_slow_encoder(every):
    """Every fourth row: inertia was 33 instead of 0.5 kg m^2 on a log of this kind, and 4000 % of the torque left."""
    log = make_log(noise=0.1, period=0.001, duration=15.0)
    found = identify_log(replace(log, position=held(log.position, every)))
    assert any(f"the position changes in one of {every} rows only" in caution for caution in found.cautions)
    assert found.best.left < 0.05
    for name in ("inertia", "coulomb"):
        assert found.parameters[name].value == pytest.approx(JOINT[name], rel=0.02)


def test_held_torque_is_left_and_found_to_be_late_and_a_sound_log_left_as_it_is():
    log = make_log(noise=0.1, duration=15.0)
    slow = replace(log, torque=held(log.torque, 5))
    assert without_repeated_rows(slow) == (slow, [])
    found = identify_log(slow)
    assert found.value("torque_delay") == pytest.approx(-0.004, rel=0.1)
    for name in ("inertia", "coulomb", "viscous"):
        assert found.parameters[name].value == pytest.approx(JOINT[name], rel=0.01)
    assert without_repeated_rows(log) == with_clear_clock(log) == (log, [])


def test_coarse_log_with_jitter_and_repeated_rows_is_used_whole():
    """Samples of 25 Hz come with jitter and are written by a faster logger: four of five rows repeat."""
    log, random = make_log(noise=0.05, duration=60.0, period=0.001), np.random.default_rng(11)
    taken = np.unique(np.round((np.arange(1, 1499) + random.uniform(-0.45, 0.45, 1498)) * 40.0).astype(int))
    written = np.unique(np.round((np.arange(5, 7480) + random.uniform(-0.45, 0.45, 7475)) * 8.0).astype(int))
    rows = taken[np.maximum(np.searchsorted(taken, written, side="right") - 1, 0)]
    coarse = replace(log, time=log.time[written], position=log.position[rows], torque=log.torque[rows])
    found = identify_log(coarse)
    assert found.data.skipped == []
    assert found.data.used == pytest.approx(taken.size, rel=0.02)
    assert found.parameters["inertia"].value == pytest.approx(JOINT["inertia"], rel=0.03)
    assert found.parameters["coulomb"].value == pytest.approx(JOINT["coulomb"], rel=0.15)


def test_rows_that_repeat_a_whole_sample_are_left_out_though_the_encoder_is_coarse():
    log = make_log(noise=0.1, period=0.001, duration=15.0)
    rows = np.arange(log.time.size) // 5 * 5
    coarse = replace(log, position=rounded(log.position, 2.0 * np.pi / 1024)[rows], torque=log.torque[rows])
    assert identify_log(coarse).value("inertia") == pytest.approx(JOINT["inertia"], rel=0.02)
