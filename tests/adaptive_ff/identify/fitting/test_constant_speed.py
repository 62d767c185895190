"""Points of the friction curve from stretches at constant speed, with the curve behind them known."""

from itertools import pairwise

import numpy as np
import pytest

from adaptive_ff.identify.identification import identify_log
from adaptive_ff.logs.log import Log

SPEEDS = np.array([0.02, 0.04, 0.07, 0.1, 0.15, 0.25, 0.4, 0.6])
INERTIA, COULOMB, STICTION, VISCOUS, BEND, OFFSET = 1.0, 60.0, 90.0, 80.0, 0.05, 2.0


def stribeck(velocity):
    share = np.exp(-np.abs(velocity) / BEND)
    return np.sign(velocity) * (COULOMB + (STICTION - COULOMB) * share) + VISCOUS * velocity


def drives(speeds, noise=1.0, hold=6.0, ramp=1.0, period=0.002):
    """Stretches at each speed forward and backward, joined by half cosines."""
    targets = [0.0, *(sign * speed for speed in speeds for sign in (1.0, -1.0)), 0.0]
    velocity = [np.zeros(10)]
    rise = 0.5 * (1.0 - np.cos(np.pi * np.arange(0.0, 1.0, period / ramp)))
    for before, after in pairwise(targets):
        velocity += [before + (after - before) * rise, np.full(round(hold / period), after)]
    series = np.concatenate(velocity)
    time = period * np.arange(series.size)
    torque = INERTIA * np.gradient(series, period) + stribeck(series) + OFFSET
    torque += noise * np.random.default_rng(101).standard_normal(time.size)
    return Log("drives", time, torque, velocity=series)


@pytest.fixture(scope="module")
def found():
    return identify_log(drives(SPEEDS), bandwidth=10.0, held_out=0.0)


def test_each_speed_and_direction_makes_a_point_on_the_curve(found):
    points = found.curve.points
    assert points.velocity == pytest.approx([*-SPEEDS[::-1], *SPEEDS], rel=0.01)
    deviation = (points.torque - stribeck(points.velocity) - OFFSET) / points.standard_error
    assert np.max(np.abs(deviation)) < 4.0
    assert 0.5 < np.sqrt(np.mean(deviation**2)) < 1.6


def test_stribeck_curve_goes_through_them(found):
    fit = found.curve.fit
    assert fit.determined
    truth = {"coulomb": COULOMB, "stiction": STICTION, "viscous": VISCOUS, "offset": OFFSET}
    for name, true in {**truth, "stribeck_velocity": BEND, "stribeck_shape": 1.0}.items():
        assert fit.estimates[name].lower <= true <= fit.estimates[name].upper
    assert found.to_dict()["constant_speed"]["stribeck"]["determined"]
    assert "make a Stribeck curve" in found.verdict[-1]


def test_speeds_within_five_percent_are_one_point():
    found = identify_log(drives([0.2, 0.201, 0.202, 0.5]), bandwidth=10.0, held_out=0.0)
    assert found.curve.points.velocity == pytest.approx([-0.5, -0.201, 0.201, 0.5], rel=0.01)
    assert found.curve.fit is None
    assert "there must be at least 7 points at 5 speeds" in found.curve.remark


def test_points_at_high_speed_are_said_not_to_tell_the_curve():
    found = identify_log(drives(np.linspace(0.5, 1.5, 8)), bandwidth=10.0, held_out=0.0)
    assert found.curve.points.velocity.size == 16
    assert not found.curve.fit.determined
    assert "do not identify the Stribeck curve" in found.curve.remark


def test_motion_without_constant_speed_has_no_points():
    time = 0.002 * np.arange(10000)
    velocity = np.sin(3.0 * time)
    torque = INERTIA * 3.0 * np.cos(3.0 * time) + stribeck(velocity)
    found = identify_log(Log("log", time, torque, velocity=velocity))
    assert found.curve == (None, None, "the log has no stretch at constant speed, so no point of the Stribeck curve")
