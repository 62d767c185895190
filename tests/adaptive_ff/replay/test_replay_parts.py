"""What a replay is made of: means of torques, references, the filter in parts, extremes, the watching loop."""

import math
from itertools import pairwise

import numpy as np
import pytest
from synthetic_logs import make_log, motion

from adaptive_ff.adaptive.controller import UnsupervisedController
from adaptive_ff.logs.defects import Piece
from adaptive_ff.logs.derivatives import lowpass
from adaptive_ff.logs.log import Log
from adaptive_ff.replay.judging import BINS, Extremes, Judge, Stretch
from adaptive_ff.replay.parts import mean_torque, paths_gone, reference_velocity, split_log, with_rest
from adaptive_ff.replay.settings import ReplaySettings
from adaptive_ff.replay.watching import Seen, watch
from controllers import difference_velocity, initial_velocity_state


@pytest.mark.parametrize("shift", [0.0, 0.5, 0.2, 1.0, 2.7, -0.5])
def test_mean_torque_is_read_between_the_samples(shift):
    """Oracle: linear interpolation by numpy."""
    torque = np.random.default_rng(105).standard_normal(60)
    piece = Piece(10, 50)
    for start, stop in ((10, 51), (11, 12), (30, 40), (48, 51)):
        ends = np.arange(start, stop)
        places = ends - 0.5 - shift
        expected = np.interp(places, np.arange(10, 50), torque[10:50])
        expected[(places < 10) | (places > 49)] = np.nan
        np.testing.assert_allclose(mean_torque(torque, piece, start, stop, shift), expected, atol=1e-12)


def test_held_command_is_its_own_mean_whatever_the_clock_rounds():
    torque = np.arange(20.0)
    for shift in (0.5 - 1e-9, 0.5, 0.5 + 1e-9):
        assert mean_torque(torque, Piece(0, 20), 1, 21, shift) == pytest.approx(torque, abs=1e-8)


def test_reference_from_a_position_and_from_the_motion_is_the_velocity():
    time = 0.002 * np.arange(5000)
    position, velocity, _ = motion(time)
    torque = np.zeros_like(time)
    referenced = Log("log", time, torque, velocity=torque, extra={"reference_position": position})
    for log in (referenced, Log("log", time, torque, position=position), Log("log", time, torque, velocity=velocity)):
        found = reference_velocity(log, Piece(1000, 4000), 2000, 2500, 0.002, 50.0)
        assert found == pytest.approx(velocity[2000:2500], abs=2e-3)
    beyond = reference_velocity(referenced, Piece(1000, 4000), 3990, 4001, 0.002, 50.0)
    assert np.isnan(beyond).tolist() == [False] * 10 + [True]


def test_reference_rests_when_it_has_slowed_down_but_not_when_it_starts():
    speeds = 1e-4 * np.array([0.0, 0.0, 0.5, 2.0, 20.0, 60.0, 110.0, 150.0, 99.0, 40.0, 5.0, 0.0, -1.5, -3.0, -120.0])
    paths = paths_gone(speeds, 0.1, 0.0)[1:]
    rests = with_rest(speeds, paths, 0.01, 1e-5) == 0.0
    expected = [True] * 3 + [False] * 5 + [True] * 4 + [False] * 3
    assert rests.tolist() == expected
    assert np.array_equal(with_rest(speeds, paths, 0.0, 0.0), speeds)


def test_small_way_against_the_motion_before_it_starts_is_rest():
    """Half a second at up to 0.9 of the rest speed the wrong way: any constant share of that speed lets it through."""
    time = 0.002 * np.arange(1500)
    before = -0.9e-4 * np.sin(np.pi * np.clip((time - 0.5) / 0.5, 0.0, 1.0))
    reference = before + np.where(time > 1.0, 0.05 * (time - 1.0) ** 2, 0.0)
    gone = paths_gone(reference, 0.002, 0.0)[1:]
    seen = with_rest(reference, gone, 1e-4, 5e-5)
    assert np.all(seen[time < 1.0] == 0.0)
    assert np.min(gone) == pytest.approx(-0.9e-4 * 0.5 * 2.0 / np.pi, rel=0.01)
    moves = time[np.flatnonzero(seen)[0]]
    assert 1.0 < moves < time[np.flatnonzero(reference > 1e-4)[0]] + 0.002


def test_motion_that_stands_for_a_reference_is_filtered_without_delay():
    time = 0.002 * np.arange(5000)
    position, velocity, _ = motion(time)
    noisy = position + 1e-4 * np.random.default_rng(108).standard_normal(5000)
    found = reference_velocity(Log("log", time, time, position=noisy), Piece(0, 5000), 1000, 4000, 0.002, 20.0)
    differences = np.gradient(noisy, time)[1000:4000]
    assert np.std(found - velocity[1000:4000]) < 0.1 * np.std(differences - velocity[1000:4000])


def test_parts_follow_a_jittered_clock_and_join_without_a_seam():
    generator = np.random.default_rng(109)
    time = np.cumsum(0.01 * generator.uniform(0.5, 1.5, 300))
    velocity = 1e-3 * np.cumsum(generator.standard_normal(300))
    extra = {"reference_velocity": velocity, "feedforward": 2.0 * time}
    log = Log("log", time, time.copy(), velocity=velocity, extra=extra)
    settings = ReplaySettings(0.01, 1.0, 0.05, 10.0, rest_speed=5e-3, start_path=1e-4)
    pieces = [Piece(3, 120), Piece(120, 300)]
    parts = {size: list(split_log(log, pieces, settings, 20.0, size)) for size in (1000, 7)}
    for get in (
        lambda part: part.seen.reference,
        lambda part: part.seen.coming,
        lambda part: part.seen.realised,
        lambda part: part.seen.elapsed,
        lambda part: part.needed,
        lambda part: part.recorded,
    ):
        whole, parted = (np.concatenate([get(part) for part in parts[size]]) for size in (1000, 7))
        assert np.array_equal(whole, parted, equal_nan=True)
    elapsed = np.concatenate([part.seen.elapsed for part in parts[7]])
    expected = np.diff(time, prepend=0.0)[3:]
    expected[[0, 117]] = 0.01  # nothing is known of what was before a piece
    assert elapsed == pytest.approx(expected, rel=1e-12)
    assert [part.start for part in parts[1000]] == [3, 120]
    assert {part.begins for part in parts[1000]} == {part.ends for part in parts[1000]} == {True}
    assert sum(part.begins for part in parts[7]) == sum(part.ends for part in parts[7]) == 2


@pytest.mark.parametrize("band", [5.0, 40.0, None])
@pytest.mark.parametrize("sizes", [[4000], [1, 999, 3000], [500] * 8, [10] * 400])
def test_filter_in_parts_is_the_filter(band, sizes):
    series = np.cumsum(np.random.default_rng(106).standard_normal((2, 4000)), axis=1)
    stretch = Stretch(band, 0.002)
    edges = np.cumsum([0, *sizes])
    for _ in range(2):  # after a last part the next one begins anew
        parts = [stretch.feed(series[:, start:stop], last=bool(stop == 4000)) for start, stop in pairwise(edges)]
        whole = series if band is None else np.array([lowpass(row, (band,), 0.002) for row in series])
        np.testing.assert_allclose(np.hstack(parts), whole, rtol=0.0, atol=1e-9)


def test_judge_counts_what_is_known_by_half_and_by_motion():
    needed = np.array([math.nan, 3.0, -3.0, 1.0, 1.0, math.nan])
    moving = np.array([True, True, True, False, True, True])
    judge = Judge(("zero", "one"), 6, None, 0.01)
    judge.add(0, needed[:2], [np.zeros(2), np.ones(2)], moving[:2], last=False)
    judge.add(2, needed[2:], [np.zeros(4), np.ones(4)], moving[2:], last=True)
    found = judge.result()
    assert found["zero"] == pytest.approx((math.sqrt(20 / 4), 1.0, math.sqrt(19 / 3)))
    assert found["one"] == pytest.approx((math.sqrt(20 / 4), 0.0, math.sqrt(20 / 3)))
    assert judge.left[1].series()[0][1:5].tolist() == [2.0, -4.0, 0.0, 0.0]
    assert np.isnan(Judge(("zero",), 6, None, 0.01).result()["zero"].whole)


def test_extremes_keep_every_peak_of_a_long_series():
    samples = 5 * BINS - 3
    values = np.random.default_rng(107).standard_normal(samples)
    extremes = Extremes(samples)
    assert extremes.width == 5
    for start in range(0, samples, 777):
        part = np.arange(start, min(start + 777, samples))
        extremes.add(part, values[part])
    low, high = extremes.series()
    padded = np.append(values, [values[-1]] * 3).reshape(-1, 5)
    assert np.array_equal(low, padded.min(axis=1))
    assert np.array_equal(high, padded.max(axis=1))


def test_watching_in_plain_python_agrees_bit_for_bit():
    log = make_log(duration=1.0, noise=0.1)
    velocity = make_log(duration=1.0, as_position=False).velocity
    count = log.time.size
    seen = Seen(
        velocity,
        np.append(velocity[1:], np.nan),
        log.position,
        np.append(np.nan, log.torque[:-1]),
        np.full(count, 0.002),
        log.position,
    )
    found = []
    for loop in (watch, watch.py_func):
        controller = UnsupervisedController(100.0, 1000.0, 0.002, inertia=2.0, stribeck_velocity=0.05)
        compiled = loop is watch
        step = (controller.native, 0) if loop is watch else (controller.parameters, controller.state)
        observer = difference_velocity(0.002)
        feedforward, estimates = np.zeros(count), np.zeros((count, 5))
        observed = initial_velocity_state(observer, float(log.position[0]))
        loop(*step, observer, observed, seen, feedforward, estimates)
        found.append((feedforward, estimates))
    assert np.ptp(found[0][1][:, 1]) > 0.0
    for compiled, plain in zip(*found, strict=True):
        assert np.array_equal(compiled, plain)
