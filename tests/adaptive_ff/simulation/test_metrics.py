"""Figures of merit of series small enough to be reckoned by hand, in parts of a run, and ratios to those of PI."""

import math

import numpy as np
import pytest

from adaptive_ff.simulation.metrics import evaluate
from adaptive_ff.simulation.tracking_errors import TrackingErrors, failed, pooled, ratios, tracking_errors


def errors(*values):
    """Series of 21 errors: the given ones, then zeros."""
    return np.array([*values, *([0.0] * (21 - len(values)))])


def measure(error, *, reference=None, torque=(0.0,), last_change=0.0):
    reference = np.ones(21) if reference is None else np.asarray(reference, dtype=float)
    return evaluate(reference, reference - error, np.asarray(torque, dtype=float), 1.0, last_change)


def test_error_of_the_whole_run_counts_every_point_once():
    metrics = measure(errors(3.0, -4.0))
    assert metrics.rms_error == pytest.approx(math.sqrt(25.0 / 21.0), rel=1e-14)
    assert metrics.max_error == 4.0


def test_error_is_that_against_the_reference_given():
    metrics = evaluate(np.linspace(0.0, 1.0, 21), np.zeros(21), np.zeros(20), 1.0, 0.0)
    assert metrics.max_error == 1.0
    assert metrics.rms_error == pytest.approx(math.sqrt(sum((k / 20.0) ** 2 for k in range(21)) / 21.0), rel=1e-14)


def test_start_counts_from_the_first_motion():
    reference = [0.0] * 8 + [-1.0] + [0.0] * 3 + [1.0] * 9  # a pause later does not matter
    before, first = errors(*[0.0] * 7, 6.0), errors(*[0.0] * 8, 6.0)
    last, after = errors(*[0.0] * 13, 6.0), errors(*[0.0] * 14, 6.0)
    found = [measure(error, reference=reference).rms_error_start for error in (before, first, last, after)]
    assert found == pytest.approx([0.0, 6.0 / math.sqrt(6.0), 6.0 / math.sqrt(6.0), 0.0], rel=1e-14)


@pytest.mark.parametrize(("last_change", "begin"), [(0.0, 10), (10.0, 15), (11.0, 16), (19.0, 20)])
def test_settled_part_is_the_last_half_of_the_time_after_the_last_change(last_change, begin):
    count = 21 - begin
    just_before, first = errors(*[0.0] * (begin - 1), 6.0), errors(*[0.0] * begin, -6.0)
    metrics = measure(just_before, last_change=last_change)
    assert (metrics.rms_error_settled, metrics.max_error_settled) == (0.0, 0.0)
    metrics = measure(first, last_change=last_change)
    assert metrics.rms_error_settled == pytest.approx(6.0 / math.sqrt(count), rel=1e-14)
    assert metrics.max_error_settled == 6.0


def test_torque_variation_sums_all_steps_of_the_torque_without_regard_to_sign():
    assert measure(errors(), torque=[5.0, 7.0, -1.0, -1.0, 2.0]).torque_variation == 2.0 + 8.0 + 0.0 + 3.0
    assert measure(errors(), torque=[5.0]).torque_variation == 0.0


ERROR = np.random.default_rng(4).standard_normal(2301)


def rms(values):
    return math.sqrt(np.mean(np.square(values)))


def parts(windows, settled=1.0, start=1.0, after=()):
    return TrackingErrors(settled, start, tuple(windows), tuple(after))


def test_each_part_is_the_root_of_the_mean_square_there():
    found = tracking_errors(np.square(ERROR), 0.01, begin=0.5, changes=[6.0, 11.0])
    assert found.settled == pytest.approx(rms(ERROR[1700:]))  # half-way from 11 to 23 s
    assert found.start == pytest.approx(rms(ERROR[50:551]))
    assert found.windows == pytest.approx([rms(ERROR[a : a + 500]) for a in (0, 500, 1000, 1500)])
    assert found.after == pytest.approx([rms(ERROR[600:1100]), rms(ERROR[1100:1600])])


def test_pooling_is_a_root_of_mean_squares():
    one, two = parts([1.0, 2.0], 3.0, 1.0, [1.0]), parts([3.0, 2.0], 1.0, 7.0, [2.0])
    found = pooled([one, two])
    assert found.series == pytest.approx([math.sqrt(5.0), 5.0, math.sqrt(5.0), 2.0, math.sqrt(2.5)])


def test_window_where_pi_has_nearly_no_error_counts_as_a_share_of_its_median_window():
    found = ratios(parts([1.0, 0.01, 2.0, 1.0]), parts([0.5, 0.3, 1.0, 1.0]))
    assert found["window"] == pytest.approx(0.3 / 0.15)


def test_more_is_better_of_settled_alone_and_changes_are_meant_geometrically():
    found = ratios(parts([1.0], 2.0, 2.0, [1.0, 1.0]), parts([1.0], 1.0, 1.0, [0.5, 0.125]))
    assert found == pytest.approx({"settled": 2.0, "window": 1.0, "start": 0.5, "after": 0.25})
    assert ratios(failed(parts([1.0])), failed(parts([1.0])))["settled"] == math.inf
