"""The estimator that knows the noise: it becomes white, and intervals are those of least squares where they can be."""

import numpy as np
import pytest

from benchmarks.coverage import _noise, draw_joint, make_case
from benchmarks.coverage_limit import fit, ideal, intervals, judge, whitened

SATURATES, SATURATES_NOT = 406, 401
"""Seeds of logs, of joints whose friction saturates and does not."""


@pytest.mark.parametrize("rate", [100.0, 1000.0])
def test_noise_of_the_logs_becomes_white_and_of_unit_deviation(rate):
    noise = 3.0 * _noise(np.random.default_rng(101), 200_000, 1.0 / rate)
    white = whitened(noise, rate, 3.0)
    assert np.std(white) == pytest.approx(1.0, abs=0.01)
    for lag in (1, 2, 5, 20):
        assert abs(np.mean(white[lag:] * white[:-lag])) < 0.01
    assert np.mean(noise[1:] * noise[:-1]) > 0.25 * np.var(noise)  # before it is not


def test_joint_that_does_not_saturate_has_the_intervals_of_least_squares():
    seen = ideal(SATURATES_NOT)
    assert seen.joint.saturation == 0.0
    values, *_ = np.linalg.lstsq(seen.columns, seen.torque, rcond=None)
    errors = np.sqrt(np.diag(np.linalg.inv(seen.columns.T @ seen.columns)))
    for place, (name, found) in enumerate(intervals(seen, (0, 1, 2)).items()):
        half = 1.96 * errors[place]
        assert found == pytest.approx((values[place], values[place] - half, values[place] + half), rel=1e-6), name


def test_a_shape_that_is_not_told_makes_the_viscous_coefficient_vaguer():
    seen = ideal(SATURATES)
    assert seen.joint.saturation > 0.0
    told, untold = (intervals(seen, shapes)["viscous"] for shapes in ((seen.joint.shape,), (0, 1, 2)))
    assert told[1] < seen.joint.viscous < told[2]
    assert untold[2] - untold[1] > 1.3 * (told[2] - told[1])
    assert judge(ideal(SATURATES), told=True)["viscous"]["covers"]


def test_without_noise_the_true_terms_leave_nothing():
    seen = ideal(SATURATES)
    columns = np.column_stack([seen.columns, seen.bent(seen.joint.shape, seen.joint.bend)])
    torque = whitened(seen.joint.torque(), seen.joint.rate, seen.noise)
    left, values, _ = fit(columns, torque)
    assert left < 1e-3
    assert values[:3] == pytest.approx([seen.joint.inertia, seen.joint.coulomb, seen.joint.viscous], rel=1e-3)


def test_joint_and_noise_are_those_of_the_log():
    case = make_case(SATURATES)
    joint = draw_joint(np.random.default_rng(SATURATES))
    assert (joint.inertia, joint.viscous) == (case.truth["inertia"], case.truth["viscous"])
    assert np.std(case.log.torque - joint.torque()) == pytest.approx(case.noise, rel=0.05)
