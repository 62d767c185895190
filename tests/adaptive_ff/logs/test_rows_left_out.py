"""Rows that lack a value, or are far off and back at once, are left out; what a machine really does is not."""

import numpy as np
import pytest
from synthetic_logs import JOINT, make_log

from adaptive_ff.errors import InputError
from adaptive_ff.identify.identification import identify_log
from adaptive_ff.logs.cleaning import clean, without_missing_values, without_spikes
from adaptive_ff.logs.log import Log
from adaptive_ff.replay.replay import replay_log

TIME = 0.002 * np.arange(10000)
ONE = "1 row left out: the {} is far off there, and back within 3 rows, first at 10"


def glitched(log, **glitches):
    """A log with values added to its series: rows and what is added, by series."""
    series = {"torque": log.torque.copy(), "position": log.position.copy()}
    for name, (rows, added) in glitches.items():
        series[name][rows] += added
    return Log("log", log.time, **series)


@pytest.mark.parametrize(
    ("glitches", "said"),
    [
        ({"position": ([5000], 3.3)}, ONE.format("position")),
        ({"position": ([5000, 5001, 5002], -3.3)}, "3 rows left out: the position is far off"),
        ({"position": ([1000, 1004, 9000], [0.5, 0.5, -0.5])}, "3 rows left out: the position is far off"),
        ({"torque": ([5000], 3276.7)}, ONE.format("torque")),
        ({"torque": ([2000, 2001, 8000], [900.0, -800.0, 900.0])}, "3 rows left out: the torque is far off"),
    ],
)
def test_glitch_is_left_out_and_the_joint_is_identified_as_without_it(glitches, said):
    found = identify_log(glitched(make_log(noise=0.05, duration=20.0), **glitches))
    assert len(found.cautions) == 1
    assert found.cautions[0].startswith(said)
    assert found.data.skipped == []
    for name, true in JOINT.items():
        assert found.value(name) == pytest.approx(true, rel=0.03)


def test_time_and_value_of_the_first_glitch_are_said_and_one_in_a_gap_that_cannot_be_bridged_is_kept():
    log = glitched(make_log(), torque=([4000, 6000], 500.0))
    kept, said = without_spikes(log)
    assert kept.time.size == 14998
    assert said[0].endswith(f"first at 8 s, where it is {log.torque[4000]:.3g}")
    log = glitched(make_log(), position=([5000], 3.3))
    rows = np.delete(np.arange(log.time.size), np.r_[4996:5000, 5001:5004])
    assert without_spikes(log.part(rows))[1] == []


def test_what_is_left_out_of_a_log_to_validate_on_is_said_with_its_name():
    other = glitched(make_log(noise=0.05, seed=102, duration=20.0), position=([5000], 3.3))
    found = identify_log(
        make_log(noise=0.05, duration=10.0), validation=Log("other", other.time, other.torque, other.position)
    )
    assert [caution[:53] for caution in found.cautions] == ["other: 1 row left out: the position is far off there,"]


def test_glitch_of_a_position_that_is_held_is_found_among_its_new_values():
    log = make_log(duration=20.0)
    position = np.repeat(log.position[::5], 5)
    position[5000:5005] += 3.3
    found = identify_log(Log("log", log.time, log.torque, position=position))
    assert any(caution.startswith("1 row left out: the position is far off") for caution in found.cautions)
    assert found.value("inertia") == pytest.approx(2.0, rel=0.05)


def test_jump_there_and_back_that_takes_longer_is_cut_on_both_sides():
    log = glitched(make_log(noise=0.05, duration=20.0), position=(slice(5000, 5010), 3.3))
    found = identify_log(log)
    assert [skip[:2] for skip in found.data.skipped] == [(5000, 5000), (5000, 5010), (5010, 5010)]
    assert [found.data.skipped[place].reason[:22] for place in (0, 2)] == ["the position jumps by "] * 2
    assert found.value("inertia") == pytest.approx(2.0, rel=0.03)


def loop_with_jumping_reference(period):
    """A joint of 0.5 kg m^2 under a fast velocity loop, whose reference jumps: real peaks of two or three rows."""
    time = period * np.arange(round(20.0 / period))
    reference = np.sign(np.sin(0.1 * np.pi * time)) * (time % 20.0 > 3.0)
    velocity, torque, velocities = 0.0, np.empty(time.size), np.empty(time.size)
    for k in range(time.size):
        torque[k] = np.clip(0.5 * 0.63 / period * (reference[k] - velocity) + 3.0 * np.sign(reference[k]), -60.0, 60.0)
        velocities[k] = velocity
        for _ in range(20):
            velocity += 0.05 * period * (torque[k] - 3.0 * np.tanh(velocity / 0.02)) / 0.5
    return Log("log", time, torque, position=np.cumsum(velocities) * period)


def switched_torque(rows):
    torque = np.repeat(np.random.default_rng(7).choice([-8.0, 8.0], 10000 // rows), rows)
    return Log("log", TIME[: torque.size], torque, position=np.cumsum(np.cumsum(torque)) * 8e-6)


def rest_and_moves(resolution):
    """A joint that mostly rests, and moves for two of ten seconds; its encoder shivers by a count."""
    speed = np.where(TIME % 10.0 < 2.0, np.sin(np.pi * TIME) * 0.5, 0.0)
    counts = np.random.default_rng(8).choice([0, 0, 0, 1], TIME.size)
    position = (np.floor(np.cumsum(speed) * 0.002 / resolution) + counts) * resolution
    return Log("log", TIME, 3.0 * np.sign(speed) + 0.1 * np.gradient(speed, 0.002), position=position)


@pytest.mark.parametrize(
    ("made", "arguments"),
    [
        *((make_log, one) for one in ({}, {"noise": 0.5}, {"noise": 0.5, "as_position": False}, {"period": 0.01})),
        *((loop_with_jumping_reference, {"period": period}) for period in (0.01, 0.002)),
        *((switched_torque, {"rows": rows}) for rows in (1, 2, 50)),
        *((rest_and_moves, {"resolution": 2.0 * np.pi / counts}) for counts in (400, 65536)),
    ],
)
def test_what_a_machine_does_is_not_touched(made, arguments):
    log = made(**arguments)
    kept, said = without_spikes(log)
    assert said == []
    assert kept is log


PERIOD, INERTIA = 0.002, 0.5
PLACES = np.array([800, 2300, 3700, 5000, 6600, 7900, 9200])
REAL = np.array([True, False, True, True, False, False, True])


def struck(width, *, sign=1.0, as_position=True):
    """A joint that is struck at some places; at the others only the recorder saw it."""
    time, random = PERIOD * np.arange(10000), np.random.default_rng(101)
    usual = 3.0 * np.sin(2.0 * np.pi * 0.4 * time) + 1.5 * np.sin(2.0 * np.pi * 1.3 * time + 1.0)
    peaks, seen = np.zeros(time.size), np.zeros(time.size)
    for place, real in zip(PLACES, REAL, strict=True):
        (peaks if real else seen)[place : place + width] = 200.0 * (-1.0) ** place
    velocity = np.concatenate([[0.0], np.cumsum(usual + peaks)[:-1]]) * PERIOD / INERTIA
    torque = sign * (usual + peaks + seen) + 0.02 * random.standard_normal(time.size)
    if not as_position:
        return Log("log", time, torque, velocity=velocity + 1e-4 * random.standard_normal(time.size))
    position = np.concatenate([[0.0], np.cumsum(velocity)[:-1]]) * PERIOD
    return Log("log", time, torque, position=position + 1e-6 * random.standard_normal(time.size))


@pytest.mark.parametrize("width", [1, 2])
@pytest.mark.parametrize("sign", [1.0, -1.0])
@pytest.mark.parametrize("as_position", [True, False])
def test_only_what_the_joint_did_not_feel_is_left_out_whatever_the_sign_of_the_torque(width, sign, as_position):
    log = struck(width, sign=sign, as_position=as_position)
    kept, said = without_spikes(log)
    left = np.flatnonzero(~np.isin(log.time, kept.time))
    assert np.array_equal(left, (PLACES[~REAL][:, np.newaxis] + np.arange(width)).ravel())
    assert len(said) == 1


@pytest.mark.parametrize(("every", "count"), [(2, 3000), (7, 858)])
def test_log_whose_torque_is_missing_in_many_rows_is_identified(every, count):
    log = make_log(noise=0.05, duration=12.0)
    log.torque[::every] = np.nan
    found = identify_log(log)
    assert found.cautions[0] == f"{count} rows left out: no finite number in the torque"
    assert (found.data.skipped, found.data.used, found.data.log.time.size) == ([], 6000 - count, 6000 - count)
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
    log = make_log(duration=1.0)
    log.time[100] = np.nan
    assert without_missing_values(log)[1] == ["1 row left out: no finite number in the time"]


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
    short = log.part(np.delete(np.arange(500), np.s_[204:206]))  # missing as well
    assert without_missing_values(short) == (short, [])


def test_replay_names_the_column_that_lacks_values():
    log = make_log(duration=2.0)
    log.torque[np.arange(1000) % 10 != 0] = np.nan
    with pytest.raises(InputError, match=r"without defect; .*: the torque has no finite number in 900 of 1000 rows"):
        replay_log(log)


def test_rows_that_are_left_out_are_no_change_of_the_sample_rate():
    log = make_log()
    log.torque[5000:5400:2] = np.nan
    _, (said,) = clean(log)
    assert "no finite number" in said
