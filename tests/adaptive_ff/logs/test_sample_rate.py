"""A sample rate that changes within a log gets one sentence."""

import numpy as np
import pytest
from synthetic_logs import make_log

from adaptive_ff.identify.identification import identify_log
from adaptive_ff.logs.cleaning import clean
from adaptive_ff.logs.defects import Skipped, find_pauses
from adaptive_ff.replay.replay import replay_log


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
    said = (
        "499 rows left out: the sample time changes to 20 ms instead of 2 ms at 10 s; identify such a part as a log of "
        "its own"
    )
    found = identify_log(log)
    assert (found.cautions, found.data.skipped, found.data.log.time.size) == ([said], [], 5001)
    assert f"{said}." in replay_log(log).notes


def test_much_slower_part_between_others_is_one_gap_and_no_pause():
    sound = clean(thinned(10, 3000, 6000))
    assert len(sound.said) == 1
    assert sound.said[0].startswith("299 rows left out: the sample time changes to 20 ms instead of 2 ms at 6 s")
    found = identify_log(thinned(10, 3000, 6000))
    assert found.data.skipped == [Skipped(3001, 3001, "the clock leaves a gap, from 6 s to 12 s")]


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
    assert find_pauses(clocks[kind]).size <= 1
