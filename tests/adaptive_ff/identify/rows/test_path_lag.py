"""Friction that follows over a path: against closed forms, and properties of bristles."""

import math

import numpy as np
import pytest

from adaptive_ff.identify.rows.path_lag import Bending, OverPath, followed

PATH = 2e-3


def test_friction_after_a_reversal_is_dahls_curve_over_the_path():
    ways = np.full(4000, 5e-6) / PATH
    side = np.where(np.arange(ways.size) < 2000, 1.0, -1.0)
    after = followed(side, ways)
    beyond = 5e-6 * np.arange(1, 2001) / PATH
    assert np.allclose(after[:2000], 1.0)
    assert np.allclose(after[2000:], -1.0 + 2.0 * np.exp(-beyond), atol=1e-12)


def test_friction_holds_where_nothing_moves():
    after = followed(np.array([1.0, -1.0, -1.0, 1.0]), np.array([0.0, 0.5, 0.0, 0.0]))
    assert after == pytest.approx([1.0, -1.0 + 2.0 * math.exp(-0.5), *[-1.0 + 2.0 * math.exp(-0.5)] * 2])


def _over(time, rate=1.0, bending=None, times=1):
    phase = rate * time[:, np.newaxis] + rate * 1e-3 * ((np.arange(times) + 0.5) / times - 0.5)
    return OverPath(0.5 * rate * np.cos(phase), 1e-3 / times, bending or Bending(PATH))


def test_friction_depends_on_the_path_alone_and_not_on_its_speed():
    slow, quick = (_over(np.arange(0.0, 20.0 / rate, 1e-3), rate, times=8).at_samples(np.sign) for rate in (1.0, 4.0))
    assert np.max(np.abs(slow[::4][: quick.size] - quick)) < 2e-3


@pytest.mark.parametrize("times", [1, 4, 5])
def test_samples_lie_in_the_middle_of_their_times(times):
    time = np.arange(0.0, 10.0, 1e-3)
    fine = _over(time, times=80).at_samples(np.sign)
    assert np.max(np.abs(_over(time, times=times).at_samples(np.sign) - fine)) < 4e-3


def test_rate_is_the_derivative_along_time():
    time = np.arange(0.0, 10.0, 1e-3)
    over = _over(time, times=4)
    rate, expected = over.rate(), np.gradient(over.at_samples(np.sign), 1e-3)
    assert np.max(rate) > 10.0
    assert np.linalg.norm(rate - expected) < 0.01 * np.linalg.norm(expected)


def test_slope_is_the_derivative_by_the_logarithm_of_the_path():
    time = np.arange(0.0, 10.0, 1e-3)
    over = _over(time, times=4)
    longer, shorter = (_over(time, times=4, bending=Bending(PATH * math.exp(d))) for d in (1e-4, -1e-4))
    expected = (longer.at_samples(np.sign) - shorter.at_samples(np.sign)) / 2e-4
    assert over.slope(np.sign) == pytest.approx(expected, abs=2e-3)


def test_bristles_that_hold_more_at_low_speed_bend_as_stiff():
    """LuGre: torque rises by ``sigma0`` times the path right after a reversal from rest, whatever the stiction."""
    velocity = np.full((200, 1), 1e-3)
    bending = Bending(PATH, excess=0.5, speed=0.05)

    def level(w):
        return 1.0 + 0.5 * np.exp(-np.abs(w) / 0.05)

    rise = followed(np.concatenate([[0.0], level(velocity[1:, 0])]), bending.ways(velocity[:, 0], 1e-3))
    assert rise[10] == pytest.approx(10 * 1e-6 / PATH, rel=0.01)
