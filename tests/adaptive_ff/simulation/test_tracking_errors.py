"""Errors in parts of a run and their ratios to those of PI."""

import math

import numpy as np
import pytest

from adaptive_ff.simulation.tracking_errors import TrackingErrors, pooled, ratios, tracking_errors

ERROR = np.random.default_rng(4).standard_normal(2301)


def rms(values):
    return math.sqrt(np.mean(np.square(values)))


def errors(windows, settled=1.0, start=1.0, after=()):
    return TrackingErrors(settled, start, tuple(windows), tuple(after))


def test_each_part_is_the_root_of_the_mean_square_there():
    found = tracking_errors(np.square(ERROR), 0.01, begin=0.5, changes=[6.0, 11.0])
    assert found.settled == pytest.approx(rms(ERROR[1700:]))  # half-way from 11 to 23 s
    assert found.start == pytest.approx(rms(ERROR[50:551]))
    assert found.windows == pytest.approx([rms(ERROR[a : a + 500]) for a in (0, 500, 1000, 1500)])
    assert found.after == pytest.approx([rms(ERROR[600:1100]), rms(ERROR[1100:1600])])


def test_pooling_is_a_root_of_mean_squares():
    one, two = errors([1.0, 2.0], 3.0, 1.0, [1.0]), errors([3.0, 2.0], 1.0, 7.0, [2.0])
    found = pooled([one, two])
    assert found.series == pytest.approx([math.sqrt(5.0), 5.0, math.sqrt(5.0), 2.0, math.sqrt(2.5)])


def test_window_where_pi_has_nearly_no_error_counts_as_a_share_of_its_median_window():
    found = ratios(errors([1.0, 0.01, 2.0, 1.0]), errors([0.5, 0.3, 1.0, 1.0]))
    assert found["window"] == pytest.approx(0.3 / 0.15)


def test_more_is_better_of_settled_alone_and_changes_are_meant_geometrically():
    found = ratios(errors([1.0], 2.0, 2.0, [1.0, 1.0]), errors([1.0], 1.0, 1.0, [0.5, 0.125]))
    assert found == pytest.approx({"settled": 2.0, "window": 1.0, "start": 0.5, "after": 0.25})
