"""The torque at which a joint rests, less what is no friction."""

from types import SimpleNamespace

import numpy as np
import pytest

from adaptive_ff.identify.fitting.prediction import rest_torque
from adaptive_ff.identify.words.verdict import shows_stiction

ANGLE = np.linspace(-1.5, 1.5, 31)


def piece(held, rests, *, position=True):
    return SimpleNamespace(position=ANGLE if position else None, held=held, rests=rests)


def test_offset_and_gravity_are_no_friction():
    values = {"coulomb": 5.0, "offset": 1.0, "gravity_sine": 8.0, "gravity_cosine": -2.0}
    held = 1.0 + 8.0 * np.sin(ANGLE) - 2.0 * np.cos(ANGLE) + 4.0 * np.sign(ANGLE)
    problem = SimpleNamespace(pieces=[piece(held, np.ones(ANGLE.size, dtype=bool))])
    assert rest_torque(problem, values) == pytest.approx(4.0)
    assert rest_torque(problem, {"coulomb": 5.0}) > 10.0


def test_without_a_position_there_is_no_gravity_to_take_off():
    problem = SimpleNamespace(pieces=[piece(np.full(31, -3.0), np.ones(31, dtype=bool), position=False)])
    assert rest_torque(problem, {"offset": 0.5}) == pytest.approx(3.5)


def test_only_rest_counts():
    moving = piece(np.full(31, 9.0), np.zeros(31, dtype=bool))
    assert rest_torque(SimpleNamespace(pieces=[moving]), {}) is None


def test_torque_at_rest_a_little_above_coulomb_friction_says_nothing_of_stiction():
    assert shows_stiction(3.4, 3.0)
    assert not shows_stiction(3.2, 3.0)  # noise, and the beginning of a motion
    assert not shows_stiction(None, 3.0)
