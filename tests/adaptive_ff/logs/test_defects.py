"""Defects of logs, and the segments between them."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from adaptive_ff import InputError
from adaptive_ff.logs.defects import Skipped, runs, usable_segments
from adaptive_ff.logs.log import Log

SIZE = 60


def make_log(**changes):
    series = {"time": 0.01 * np.arange(SIZE), "torque": np.ones(SIZE), "position": np.arange(float(SIZE))}
    for name, (place, value) in changes.items():
        series[name][place] = value
    return Log("log", **series)


@pytest.mark.parametrize("name", ["time", "torque", "position"])
@pytest.mark.parametrize("value", [np.nan, np.inf, -np.inf])
def test_stretch_without_numbers_is_skipped_and_the_rest_is_used(name, value):
    segments, skipped = usable_segments(make_log(**{name: (slice(20, 25), value)}))
    assert segments == [range(0, 20), range(25, SIZE)]
    assert skipped == [Skipped(20, 25, "values that are no finite numbers")]


@pytest.mark.parametrize(
    ("shift", "what"),
    [
        (-0.2, "jumps back, from 0.29 s to 0.1 s"),
        (0.1, "leaves a gap, from 0.29 s to 0.4 s"),
        (-0.01, "stands still, from 0.29 s to 0.29 s"),
    ],
)
def test_clock_that_jumps_or_stands_cuts_and_skips_nothing(shift, what):
    log = make_log()
    log.time[30:] += shift
    segments, skipped = usable_segments(log)
    assert segments == [range(0, 30), range(30, SIZE)]
    assert skipped == [Skipped(30, 30, f"the clock {what}")]


def test_sound_log_is_one_piece_and_jitter_does_not_cut_it():
    log = make_log()
    assert usable_segments(log) == ([range(0, SIZE)], [])
    log.time[1:-1] += 0.004 * np.sin(np.arange(1, SIZE - 1))
    assert usable_segments(log)[0] == [range(0, SIZE)]


def test_short_piece_is_skipped_with_its_length():
    segments, skipped = usable_segments(make_log(torque=([10, 14], np.nan)), shortest=5)
    assert segments == [range(15, SIZE)] or segments == [range(0, 10), range(15, SIZE)]
    assert Skipped(11, 14, "a segment of 3 samples; 5 are needed") in skipped


def test_clock_that_never_goes_forward_is_refused():
    log = make_log()
    log.time[:] = 5.0
    with pytest.raises(InputError, match=f"log: the time does not go forward in {SIZE - 1} of {SIZE - 1} steps, first"):
        usable_segments(log)


@pytest.mark.parametrize("order", [slice(None, None, -1), np.random.default_rng(3).permutation(SIZE)])
def test_samples_out_of_order_are_refused_with_the_first(order):
    log = make_log()
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
    log = make_log()
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
