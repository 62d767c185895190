"""Positions and torques that are sampled more slowly than the log they are written to."""

from dataclasses import replace

import numpy as np
import pytest
from scipy.interpolate import CubicSpline
from synthetic_logs import JOINT, make_log

from adaptive_ff.identify.identification import identify_log
from adaptive_ff.logs.cleaning import rows_between, without_repeated_rows


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
    log = make_log(noise=0.05, period=0.001)
    torque = log.torque + 2.0 * np.sin(2.0 * np.pi * 200.3 * log.time)
    found = identify_log(replace(log, position=held(log.position, 5), torque=torque), model="offset")
    assert found.best.left < 0.01
    for name in ("inertia", "coulomb", "viscous"):
        assert found.parameters[name].value == pytest.approx(JOINT[name], rel=0.01)


def test_torque_that_is_held_longer_than_the_motion_is_said_too():
    log = make_log(noise=0.1)
    said = without_repeated_rows(replace(log, position=held(log.position, 2), torque=held(log.torque, 10)))[1]
    assert said[0].startswith("the torque changes in one of 10 rows only")
    assert said[1].startswith("the position changes in one of 2 rows only")


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
    log = make_log(noise=0.1, period=0.001)
    found = identify_log(replace(log, position=held(log.position, every)))
    assert any(f"the position changes in one of {every} rows only" in caution for caution in found.cautions)
    assert found.best.left < 0.05
    for name in ("inertia", "coulomb"):
        assert found.parameters[name].value == pytest.approx(JOINT[name], rel=0.02)


def test_held_torque_is_said_and_left():
    log = make_log(noise=0.1)
    slow = replace(log, torque=held(log.torque, 5))
    same, said = without_repeated_rows(slow)
    assert same is slow
    assert said[0].startswith("the torque changes in one of 5 rows only")
    assert said[0].endswith("give --torque-delay=-0.004")
    assert without_repeated_rows(log) == (log, [])


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
