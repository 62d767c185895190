"""Replay of logs whose joint is known: what is learnt, what is left, what is told apart."""

from dataclasses import replace

import numpy as np
import pytest
from synthetic_logs import JOINT, make_log, sines_log

from adaptive_ff.errors import InputError
from adaptive_ff.logs.log import Log
from adaptive_ff.replay.replay import replay_log


def test_joint_is_learnt_and_little_torque_is_left():
    found = replay_log(make_log(noise=0.1, duration=40.0))
    learnt = found.estimates["adaptive"]
    for name in ("inertia", "coulomb", "viscous", "offset"):
        assert learnt[name] == pytest.approx(JOINT[name], rel=0.05)
    assert found.left["adaptive"].second_half < 0.05 * found.left["none"].second_half
    assert found.left["fixed"].second_half < 0.05 * found.left["none"].second_half


def test_estimates_before_a_sample_know_nothing_of_what_follows():
    log = make_log(noise=0.1, period=0.005)
    changed = log.torque.copy()
    changed[4000:] *= 2.0
    one, other = replay_log(log), replay_log(replace(log, torque=changed))
    # the motion, filtered without delay, looks ahead by a moment
    before = (one.series.time > 3.0) & (one.series.time < 0.97 * log.time[4000])
    for name, series in one.series.estimates["adaptive"].items():
        apart = np.abs(other.series.estimates["adaptive"][name] - series)[before]
        assert np.all(apart <= np.maximum(0.2 * np.abs(series[before]), 0.1))
    assert other.estimates["adaptive"]["inertia"] > 1.3 * one.estimates["adaptive"]["inertia"]


def test_gravity_and_ripple_are_learnt_where_asked():
    log, _ = sines_log(lambda q, w: 0.8 * np.sign(w) + 2.0 * np.sin(q) + 0.3 * np.cos(2.0 * np.pi * q / 0.5))
    found = replay_log(log, identify="gravity", ripple_periods=(0.5,))
    learnt = found.estimates["adaptive"]
    assert learnt["gravity_sin"] == pytest.approx(2.0, rel=0.05)
    assert learnt["ripple_cos_1"] == pytest.approx(0.3, rel=0.1)
    assert found.left["adaptive"].second_half < replay_log(log).left["adaptive"].second_half


def test_standstill_is_held_and_teaches_nothing():
    log = make_log(noise=0.02)
    position = log.position[np.minimum(np.arange(log.time.size), 8000)]
    found = replay_log(replace(log, position=position, torque=np.where(np.arange(15000) <= 8000, log.torque, 1.0)))
    history = found.series.estimates["adaptive"]["coulomb"]
    assert np.ptp(history[found.series.time > 18.0]) == 0.0
    late = found.series.time > 20.0
    assert found.series.feedforward["adaptive"][late] == pytest.approx(1.0, abs=0.01)


@pytest.mark.parametrize(
    ("drift", "identify", "one_number"),
    [(3.7, "offset", {"coulomb", "stiction", "offset"}), (3.7, "symmetric", set()), (0.0, "directions", set())],
)
def test_what_one_way_motion_does_not_tell_apart_is_not_identified(drift, identify, one_number):
    log, _ = sines_log(lambda q, w: 0.8 * np.sign(w), rate=200)
    found = replay_log(replace(log, position=log.position + drift * log.time), identify=identify).verdict
    assert set(found["unidentified"]) == one_number
    assert {"inertia", "viscous"} <= set(found["identified"])
    assert not set(found["identified"]) & one_number


def test_band_beyond_a_fifth_of_the_sampling_frequency_is_said():
    log = make_log(period=0.02, duration=20.0)
    assert "The band is 10 Hz, a fifth of the sampling frequency, and not 20 Hz." in replay_log(log).notes
    assert not [note for note in replay_log(log, band=10.0).notes if note.startswith("The band is")]


def test_torque_of_something_else_is_said():
    log = make_log(duration=10.0)
    noise = 5.0 * np.random.default_rng(3).standard_normal(log.time.size)
    found = replay_log(Log("log", log.time, noise, position=log.position), inertia=2.0)
    assert any("More torque than without any feedforward is left by" in note for note in found.notes)
    assert found.fixed is None


def test_torque_of_the_wrong_sign_is_refused_as_identify_refuses_it():
    log = make_log(duration=20.0)
    with pytest.raises(InputError, match="torque and motion have opposite signs"):
        replay_log(Log("log", log.time, -log.torque, position=log.position), inertia=2.0)
