"""Defects of logs and the segments between them; logs that are not what they are taken for."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from synthetic_logs import JOINT, make_log

from adaptive_ff import InputError
from adaptive_ff.identify.columns import LINEAR, ROTARY, of_current
from adaptive_ff.identify.identification import identify_log
from adaptive_ff.logs.cleaning import at_limit, clean
from adaptive_ff.logs.defects import Skipped, find_jumps, runs, usable_segments
from adaptive_ff.logs.log import Log
from adaptive_ff.replay.replay import replay_log

SIZE = 60


def defective(**changes):
    series = {"time": 0.01 * np.arange(SIZE), "torque": np.ones(SIZE), "position": np.arange(float(SIZE))}
    for name, (place, value) in changes.items():
        series[name][place] = value
    return Log("log", **series)


@pytest.mark.parametrize("name", ["time", "torque", "position"])
@pytest.mark.parametrize("value", [np.nan, np.inf, -np.inf])
def test_stretch_without_numbers_is_skipped_and_the_rest_is_used(name, value):
    segments, skipped = usable_segments(defective(**{name: (slice(20, 25), value)}))
    assert segments == [range(0, 20), range(25, SIZE)]
    assert skipped == [Skipped(20, 25, "values that are no finite numbers")]


SHIFTS = {-0.2: "jumps back, from 0.29 s to 0.1 s", 0.1: "leaves a gap, from 0.29 s to 0.4 s"}
SHIFTS[-0.01] = "stands still, from 0.29 s to 0.29 s"


@pytest.mark.parametrize(("shift", "what"), SHIFTS.items())
def test_clock_that_jumps_or_stands_cuts_and_skips_nothing(shift, what):
    log = defective()
    log.time[30:] += shift
    segments, skipped = usable_segments(log)
    assert segments == [range(0, 30), range(30, SIZE)]
    assert skipped == [Skipped(30, 30, f"the clock {what}")]


def test_sound_log_is_one_piece_and_jitter_does_not_cut_it():
    log = defective()
    assert usable_segments(log) == ([range(0, SIZE)], [])
    log.time[1:-1] += 0.004 * np.sin(np.arange(1, SIZE - 1))
    assert usable_segments(log)[0] == [range(0, SIZE)]


def test_short_piece_is_skipped_with_its_length():
    segments, skipped = usable_segments(defective(torque=([10, 14], np.nan)), shortest=5)
    assert segments == [range(15, SIZE)] or segments == [range(0, 10), range(15, SIZE)]
    assert Skipped(11, 14, "segments of less than 5 samples") in skipped


def test_clock_that_never_goes_forward_is_refused():
    log = defective()
    log.time[:] = 5.0
    with pytest.raises(InputError, match=f"log: the time does not go forward in {SIZE - 1} of {SIZE - 1} steps, first"):
        usable_segments(log)


@pytest.mark.parametrize("order", [slice(None, None, -1), np.random.default_rng(3).permutation(SIZE)])
def test_samples_out_of_order_are_refused_with_the_first(order):
    log = defective()
    mixed = Log("log", log.time[order], log.torque[order], log.position[order])
    place = int(np.argmax(np.diff(mixed.time) < 0.0))
    said = rf"first from [\d.]+ s in sample {place} to [\d.]+ s in sample {place + 1}; times must increase"
    with pytest.raises(InputError, match=said):
        usable_segments(mixed)


@given(
    st.lists(st.integers(0, SIZE - 1), max_size=8),
    st.lists(st.tuples(st.integers(1, SIZE - 1), st.sampled_from([-0.3, -0.01, 0.3])), max_size=4),
)
def test_pieces_hold_every_sound_sample_once_and_no_defect(lost, jumps):
    log = defective()
    log.torque[lost] = np.nan
    for place, shift in jumps:
        log.time[place:] += shift
    segments, skipped = usable_segments(log, shortest=1)
    used = np.zeros(SIZE, dtype=int)
    for segment in segments:
        used[segment.start : segment.stop] += 1
        assert np.all(np.diff(log.time[segment.start : segment.stop]) > 0.0)
        assert np.all(np.isfinite(log.torque[segment.start : segment.stop]))
    assert np.array_equal(used, np.isfinite(log.torque))
    assert sum(skip.stop - skip.start for skip in skipped) == len(set(lost))


@given(st.lists(st.booleans()))
def test_runs_are_where_the_mask_is_true(mask):
    rebuilt = [False] * len(mask)
    for start, stop in runs(np.array(mask, dtype=bool)):
        assert stop > start
        assert start == 0 or not mask[start - 1]
        rebuilt[start:stop] = [True] * (stop - start)
    assert rebuilt == mask


ROWS = np.arange(10000)
"""Of a log of 20 s."""


def with_position(log, position):
    return Log("log", log.time, log.torque, position=position)


@pytest.mark.parametrize(
    ("rate", "unit", "step"),
    [(1e3, "milliseconds", "2"), (1e6, "microseconds", "2000"), (1e9, "nanoseconds", r"2e\+06"), (1e12, "milli", "2e")],
)
def test_clock_that_does_not_count_seconds_is_refused_with_the_unit_that_suits(rate, unit, step):
    log = make_log()
    with pytest.raises(InputError, match=rf"log: the sample time is {step}.* is the time in {unit}"):
        identify_log(Log("log", rate * log.time, log.torque, position=log.position))


def test_clock_of_a_tenth_of_a_second_or_more_is_asked_whether_it_counts_seconds():
    """Of a log of 2 kHz in milliseconds inertia came out a million times too large, and was called good."""
    log = make_log(duration=8.0, period=0.0005)
    said = ["the sample time is 0.5 s: is the time in milliseconds? Then scale the time by 1e-3"]
    for rate, expected in ((1e3, said), (160.0, [])):
        assert clean(Log("log", rate * log.time, log.torque, position=log.position))[1] == expected


def test_wraps_are_undone_and_said():
    log = make_log(noise=0.05)
    far = 20.0 * log.position
    wrapped = np.angle(np.exp(1j * far))
    count = int(np.count_nonzero(np.abs(np.diff(wrapped)) > 3.0))
    assert count > 4
    sound, said = clean(with_position(log, wrapped))
    undone = sound.position
    assert undone - undone[0] == pytest.approx(far - far[0], abs=1e-9)
    assert said == [f"the position wraps {count} times by a turn; that is undone"]
    assert clean(with_position(log, wrapped), linear=True)[0].position is wrapped


def test_log_is_cut_where_the_position_jumps():
    log = make_log(noise=0.05, duration=20.0)
    position = log.position.copy()
    position[5000:] += 0.9
    position[9000:] -= 0.9
    assert list(find_jumps(with_position(log, position))) == [5000, 9000]
    found = identify_log(with_position(log, position))
    assert [skip[:2] for skip in found.data.skipped] == [(5000, 5000), (9000, 9000)]
    assert all(skip.reason.startswith("the position jumps by") for skip in found.data.skipped)
    for name, true in JOINT.items():
        assert found.value(name) == pytest.approx(true, rel=0.05)


@pytest.mark.parametrize("as_position", [True, False])
def test_pause_of_the_recording_is_called_one_and_the_log_is_cut_there(as_position):
    """It was called a jump of the position within one sample."""
    log = make_log(noise=0.05, as_position=as_position, duration=20.0)
    paused = log.part(np.delete(ROWS, np.s_[7000:7249]))
    found = identify_log(paused)
    said = Skipped(7000, 7000, "the clock leaves a gap, from 13.998 s to 14.498 s")
    assert (found.cautions, found.data.skipped, replay_log(paused).data.skipped) == ([], [said], [said])
    _, skipped = usable_segments(log.part(np.delete(ROWS, np.r_[3000:3400, 7000:7249])))
    assert skipped[0] == Skipped(3000, 3000, "the clock leaves a gap, from 5.998 s to 6.8 s")
    assert skipped[1][1:] == (6600, said.reason)


def test_jump_beside_a_pause_is_still_a_jump():
    log = make_log(noise=0.05, duration=20.0)
    position = np.where(ROWS < 9000, log.position, log.position + 0.9)
    sound, said = clean(with_position(log, position).part(np.delete(ROWS, np.s_[7000:7249])))
    found = {skip.start: skip.reason[:13] for skip in usable_segments(sound)[1]}
    assert (said, found) == ([], {7000: "the clock lea", 9000 - 249: "the position "})


def test_each_step_says_what_it_leaves_out():
    log = make_log(noise=0.05, duration=20.0)
    log.torque[[100, 300]] = np.nan
    log.position[5000] += 3.3
    twice = log.part(np.insert(ROWS, [700, 900], [700, 900]))
    twice.torque[901] += 0.1
    sound, said = clean(twice)
    assert sound.time.size == twice.time.size - 5
    assert np.isin(sound.time, log.time).all()  # they are no clock that is rounded
    assert said[:2] == [
        "2 rows left out: with the time of the row before; 1 have other values",
        "2 rows left out: no finite number in the torque",
    ]
    (spike,) = said[2:]
    assert spike.startswith("1 row left out: the position is far off there")


def test_sound_log_is_left_as_it_is():
    log = make_log(noise=0.05)
    sound, said = clean(log)
    assert (said, find_jumps(sound)) == ([], {})
    assert sound.position is log.position


def test_units_follow_a_current():
    rotary, linear = of_current(ROTARY), of_current(LINEAR)
    assert (rotary["inertia"], rotary["coulomb"], rotary["viscous"]) == ("A s²/rad", "A", "A s/rad")
    assert (linear["inertia"], linear["coulomb"], linear["viscous"]) == ("A s²/m", "A", "A s/m")
    assert rotary["friction_lag"] == "s"


def clipped_torque(torque):
    return at_limit(Log("log", np.arange(torque.size), torque, torque))[1]


TORQUE = make_log(duration=20.0, noise=0.05).torque
PHASE = np.linspace(0.0, 60.0, 10000)


@pytest.mark.parametrize(("limits", "shown"), [((-8.0, 8.0), "-8 or 8"), ((-np.inf, 8.0), "8"), ((-8.0, np.inf), "-8")])
def test_torque_that_is_cut_off_is_said_to_be(limits, shown):
    clipped = np.clip(TORQUE, *limits)
    share = 100.0 * np.mean(clipped != TORQUE)
    (said,) = clipped_torque(clipped)
    cut = f"the torque is exactly {shown} in {share:.0f} % of the rows: if what records it cuts it off"
    assert said.startswith(cut)


def test_identification_says_it():
    log = make_log(noise=0.05, period=0.004, duration=15.0)
    np.clip(log.torque, -8.0, 8.0, out=log.torque)
    assert any(caution.startswith("the torque is exactly -8 or 8") for caution in identify_log(log).cautions)


@pytest.mark.parametrize(
    "torque",
    [
        TORQUE,
        np.clip(TORQUE, -0.98 * np.max(np.abs(TORQUE)), None),  # a few rows only
        np.round(3.0 * np.sin(PHASE) + 2.0 * np.sin(3.3 * PHASE)),  # of few digits
        np.where(np.sin(PHASE) > 0.0, 5.0, -5.0),  # switched
        np.repeat(np.random.default_rng(5).integers(-3, 4, 100).astype(float), 100),  # in steps
        np.maximum(TORQUE, 0.0),  # off where it would be negative
        np.repeat(TORQUE[::5], 5),  # held
        np.full(100, np.nan),
        np.full(100, 2.0),
    ],
    ids=["sound", "few rows", "digits", "switched", "steps", "off", "held", "nothing", "constant"],
)
def test_other_torques_are_not(torque):
    assert clipped_torque(torque) == []
