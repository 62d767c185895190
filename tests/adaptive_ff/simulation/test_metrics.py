"""Figures of merit against series small enough to be reckoned by hand."""

import math

import numpy as np
import pytest

from adaptive_ff.simulation.metrics import evaluate


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
