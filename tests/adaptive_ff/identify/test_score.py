"""The open-loop score on a joint that is known."""

import numpy as np
import pytest

from adaptive_ff import InputError
from adaptive_ff.identify.open_loop import OpenLoopModel, Record
from adaptive_ff.identify.score import score_log
from adaptive_ff.logs.log import Log

PERIOD = 0.002


def test_constant_torque_against_viscous_friction_is_the_closed_form():
    """``J w' + sigma w = u - Fc``: the speed goes to ``(u - Fc)/sigma`` with the time constant ``J/sigma``."""
    time = PERIOD * np.arange(1000)
    final, lag = (5.0 - 1.0) / 2.0, 0.5 / 2.0
    exact = final * (time - lag * (1.0 - np.exp(-time / lag)))
    record = Record(exact, np.zeros(1000), np.full(1000, 5.0), PERIOD)
    model = OpenLoopModel(0.5, 1.0, 2.0, 0.0, 0.0, 1.0, np.zeros(1))
    assert np.max(np.abs(model.errors(record, np.array([0]), 1000))) < 2.0 * final * PERIOD


def test_force_over_position_is_interpolated_and_offsets_add_up():
    record = Record(np.zeros(50), np.zeros(50), np.full(50, 3.0), PERIOD)
    still = OpenLoopModel(1.0, 0.1, 1.0, 0.0, -1.0, 1.0, np.array([2.0, 4.0]))  # 3 N m at zero
    assert np.all(still.errors(record, np.array([0]), 50) == 0.0)
    moved = still._replace(force=np.array([0.0, 2.0]))
    assert moved.errors(record, np.array([0]), 50)[0, -1] > 0.0


def test_velocity_alone_is_refused():
    time = PERIOD * np.arange(2000)
    log = Log("log", time, np.sin(time), velocity=np.sin(time))
    with pytest.raises(InputError, match="a score takes a position"):
        score_log(log, log)
