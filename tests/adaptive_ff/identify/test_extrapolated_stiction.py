"""Stiction of a log that is nowhere as slow as the Stribeck velocity is what the shape of friction makes of it."""

import math

import numpy as np
import pytest

from adaptive_ff.identify.identification import identify_log
from adaptive_ff.identify.terms import SQUARE_STICTION
from adaptive_ff.logs.log import Log

COULOMB, STICTION, STRIBECK = 3.0, 4.0, 0.05


def one_way_log(slowest, shape):
    """A log of a joint that turns one way, with four passages at the slowest speed, rad/s; its truth is above."""
    time = np.arange(15000) / 500.0
    wave = np.sin(2.0 * np.pi * 0.13 * time) * np.sin(2.0 * np.pi * 0.9 * time)
    fast = 0.8 + 0.4 * wave
    depth = np.exp(-(np.subtract.outer((4.0, 11.0, 17.0, 25.0), time) ** 2) / 0.5).sum(axis=0)
    velocity = slowest + (fast - slowest) * (1.0 - depth)
    position = np.concatenate([[0.0], np.cumsum(0.5 * (velocity[1:] + velocity[:-1]))]) / 500.0
    friction = COULOMB + (STICTION - COULOMB) * np.exp(-((velocity / STRIBECK) ** shape)) + 1.5 * velocity
    noise = 0.003 * np.random.default_rng(7).standard_normal(time.size)
    return Log("one way", time, 0.5 * np.gradient(velocity, time) + friction + noise, position=position)


@pytest.mark.parametrize("share", [1.0, 1.5])
def test_stiction_beyond_the_slowest_speed_is_confounded_with_its_shape(share):
    """Of a shape between the two that are known it came out 1.3 and 1.6 times the true one, within 3 %."""
    found = identify_log(one_way_log(share * STRIBECK, 1.5), held_out=0.0)
    for name, true in {"stiction": STICTION, "stribeck_velocity": STRIBECK}.items():
        reported = found.parameters[name]
        assert reported.used
        assert not reported.is_known, name
        assert SQUARE_STICTION in reported.confounded
        assert reported.estimate.lower <= true <= reported.estimate.upper, name
    assert found.parameters["stiction"].estimate.value > 1.25 * STICTION


def test_stiction_that_the_log_is_slow_enough_for_is_identifiable():
    found = identify_log(one_way_log(0.1 * STRIBECK, 2.0), held_out=0.0)
    assert found.selection.chosen.shown > math.exp(-1.0)
    assert found.parameters["stiction"].estimate.value == pytest.approx(STICTION, rel=0.2)
    assert SQUARE_STICTION not in found.parameters["stiction"].confounded
