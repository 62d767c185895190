"""Logs that are not what they are taken for; a torque that is cut off at its ends is said to be."""

import numpy as np
import pytest
from synthetic_logs import JOINT, make_log

from adaptive_ff import InputError
from adaptive_ff.identify.identification import identify_log
from adaptive_ff.identify.units import LINEAR, ROTARY, of_current
from adaptive_ff.logs.cleaning import STEPS, at_limit, clean
from adaptive_ff.logs.defects import Skipped, find_jumps
from adaptive_ff.logs.log import Log
from adaptive_ff.replay.replay import replay_log

ROWS = np.arange(15000)
"""Of a log of 30 s."""


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


def test_wraps_are_undone_and_said():
    log = make_log(noise=0.05)
    far = 20.0 * log.position
    wrapped = np.angle(np.exp(1j * far))
    count = int(np.count_nonzero(np.abs(np.diff(wrapped)) > 3.0))
    assert count > 4
    sound, (row,) = clean(with_position(log, wrapped))
    undone = sound.position
    assert undone - undone[0] == pytest.approx(far - far[0], abs=1e-9)
    assert row == ("wraps", 0, [f"the position wraps {count} times by a turn; that is undone"])
    assert clean(with_position(log, wrapped), linear=True)[0].position is wrapped


def test_log_is_cut_where_the_position_jumps():
    log = make_log(noise=0.05)
    position = log.position.copy()
    position[5000:] += 0.9
    position[9000:] -= 0.9
    assert list(find_jumps(with_position(log, position))) == [5000, 9000]
    found = identify_log(with_position(log, position))
    assert any("the position jumps 2 times" in caution for caution in found.cautions)
    assert [skip.start for skip in found.data.skipped] == [5000, 9000]
    for name, true in JOINT.items():
        assert found.value(name) == pytest.approx(true, rel=0.05)
    position[9000:] += 0.9
    _, rows = clean(with_position(log, position))
    assert rows[-1] == ("jumps", 0, ["the position jumps once within one sample; the log is cut there"])


@pytest.mark.parametrize("as_position", [True, False])
def test_pause_of_the_recording_is_called_one_and_the_log_is_cut_there(as_position):
    """It was called a jump of the position within one sample."""
    log = make_log(noise=0.05, as_position=as_position)
    paused = log.part(np.delete(ROWS, np.s_[7000:7249]))
    found = identify_log(paused)
    said = "the recording pauses once for 0.5 s after 13.998 s; the log is cut there"
    assert found.cautions == [said]
    assert found.data.skipped == [Skipped(7000, 7000, "the clock leaves a gap, from 13.998 s to 14.498 s")]
    assert [note for note in replay_log(paused).notes if "pauses" in note] == [f"{said[0].upper()}{said[1:]}."]
    ((_, _, (said,)),) = clean(log.part(np.delete(ROWS, np.r_[3000:3400, 7000:7249])))[1]
    assert said == "the recording pauses 2 times, the longest for 0.802 s after 5.998 s; the log is cut there"


def test_jump_beside_a_pause_is_still_a_jump():
    log = make_log(noise=0.05)
    position = np.where(ROWS < 9000, log.position, log.position + 0.9)
    sound, rows = clean(with_position(log, position).part(np.delete(ROWS, np.s_[7000:7249])))
    assert list(find_jumps(sound)) == [9000 - 249]
    assert [row.said[0].split(" for ")[0] for row in rows] == [
        "the recording pauses once",
        "the position jumps once within one sample; the log is cut there",
    ]


def test_each_step_is_one_row_of_the_table():
    log = make_log(noise=0.05)
    log.torque[[100, 300]] = np.nan
    log.position[5000] += 3.3
    twice = log.part(np.insert(ROWS, [700, 900], [700, 900]))
    twice.torque[901] += 0.1
    _, rows = clean(twice)
    assert [row[:2] for row in rows] == [("duplicate stamps", 2), ("missing values", 2), ("spikes", 1)]
    assert rows[0].said == [
        "1 row left out: the same as the one before, time included",
        "1 row left out: with the time of the row before, but other values",
    ]
    assert {row.step for row in rows} <= set(STEPS)


def test_sound_log_is_left_as_it_is():
    log = make_log(noise=0.05)
    sound, rows = clean(log)
    assert (rows, find_jumps(sound)) == ([], {})
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
    log = make_log(noise=0.05, period=0.004)
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
