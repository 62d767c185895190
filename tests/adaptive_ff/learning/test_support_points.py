import numpy as np
import pytest

from adaptive_ff.learning.support_points import support_points

SPEEDS = np.geomspace(0.005, 0.35, 30)
BOTH = np.concatenate([-SPEEDS[::-1], SPEEDS])


def readings(seed, count, spread=0.03, offset=0.0):
    torque = np.sign(BOTH) * (60.0 + 30.0 * np.exp(-np.abs(BOTH) / 0.05)) + 80.0 * BOTH + offset
    noise = spread * np.abs(torque)[:, np.newaxis] * np.random.default_rng(seed).standard_normal((BOTH.size, count))
    return np.repeat(BOTH[:, np.newaxis], count, axis=1), torque[:, np.newaxis] + noise


def test_mean_spread_and_count_are_those_of_each_drive():
    points = support_points([0.1, 0.3, 0.12, 0.32, 0.11], [5.0, 7.0, 6.0, 8.0, 7.0], ["a", "b", "a", "b", "a"])
    assert points.velocity == pytest.approx([0.11, 0.31])
    assert points.torque == pytest.approx([6.0, 7.5])
    assert points.spread == pytest.approx([1.0, np.sqrt(0.5)])
    assert points.count.tolist() == [3, 2]


def test_standard_errors_from_few_readings_scatter_less_than_their_spread():
    velocity, torque = readings(4, 5)
    points = support_points(velocity, torque)
    true = 0.03 * np.abs(torque.mean(axis=1))
    own, shared = (np.std(np.log(error / true)) for error in (points.spread, points.standard_error))
    assert own > 0.25
    assert shared < 0.15
    assert np.median(points.standard_error * np.sqrt(5.0) / true) == pytest.approx(1.0, abs=0.15)
