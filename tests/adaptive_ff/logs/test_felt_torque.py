"""Torques far outside the range of all others: which of them the joint felt."""

import numpy as np
import pytest

from adaptive_ff.logs.cleaning import without_spikes
from adaptive_ff.logs.log import Log

PERIOD, INERTIA = 0.002, 0.5
PLACES = np.array([800, 2300, 3700, 5000, 6600, 7900, 9200])
REAL = np.array([True, False, True, True, False, False, True])


def struck(width, *, sign=1.0, as_position=True):
    """A joint that is struck at some places; at the others only the recorder saw it."""
    time, random = PERIOD * np.arange(10000), np.random.default_rng(101)
    usual = 3.0 * np.sin(2.0 * np.pi * 0.4 * time) + 1.5 * np.sin(2.0 * np.pi * 1.3 * time + 1.0)
    peaks, seen = np.zeros(time.size), np.zeros(time.size)
    for place, real in zip(PLACES, REAL, strict=True):
        (peaks if real else seen)[place : place + width] = 200.0 * (-1.0) ** place
    velocity = np.concatenate([[0.0], np.cumsum(usual + peaks)[:-1]]) * PERIOD / INERTIA
    torque = sign * (usual + peaks + seen) + 0.02 * random.standard_normal(time.size)
    if not as_position:
        return Log("log", time, torque, velocity=velocity + 1e-4 * random.standard_normal(time.size))
    position = np.concatenate([[0.0], np.cumsum(velocity)[:-1]]) * PERIOD
    return Log("log", time, torque, position=position + 1e-6 * random.standard_normal(time.size))


@pytest.mark.parametrize("width", [1, 2])
@pytest.mark.parametrize("sign", [1.0, -1.0])
@pytest.mark.parametrize("as_position", [True, False])
def test_only_what_the_joint_did_not_feel_is_left_out_whatever_the_sign_of_the_torque(width, sign, as_position):
    log = struck(width, sign=sign, as_position=as_position)
    kept, said = without_spikes(log)
    left = np.flatnonzero(~np.isin(log.time, kept.time))
    assert np.array_equal(left, (PLACES[~REAL][:, np.newaxis] + np.arange(width)).ravel())
    assert len(said) == 1
