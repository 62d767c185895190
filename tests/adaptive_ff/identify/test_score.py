"""The open-loop score on a joint that is known."""

import numpy as np
import pytest

from adaptive_ff import InputError
from adaptive_ff.adaptive.map_settings import map_parameters
from adaptive_ff.identify import score
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


def test_friction_over_position_is_the_controllers_map():
    """At rest on a slope of friction: the force holds where friction is high, and moves the joint where it is low."""
    variation = map_parameters((1.0,), 0, None, 0.0, 1.0)
    model = OpenLoopModel(1.0, 2.0, 0.0, 0.0, 0.0, 1.0, np.zeros(1), variation, np.array([0.5, 0.0]))
    high, low = (Record(np.full(50, place), np.zeros(50), np.full(50, 2.5), PERIOD) for place in (0.0, 0.5))
    assert np.all(model.errors(high, np.array([0]), 50) == 0.0)  # Coulomb friction of 3 N m
    assert model.errors(low, np.array([0]), 50)[0, -1] > 0.0  # of 1 N m
    assert model.to_dict()["friction_map"]["position_periods"] == pytest.approx([1.0])


def test_a_map_is_chosen_where_the_other_record_needs_it(monkeypatch):
    for numbers in ("KNOTS", "MAPPED_KNOTS"):
        monkeypatch.setattr(score, numbers, (1,))
    train, test = (_log(0.4, seed) for seed in (101, 102))
    with_map = score_log(train, test, position_periods=(0.5,))
    assert with_map.chosen.mapped == 2
    assert with_map.model.coefficients == pytest.approx([0.0, 0.4], abs=0.05)
    assert with_map.rms < 0.5 * score_log(train, test).rms


def _log(amplitude, seed):
    """A log of a joint whose friction varies by ``1 + A sin(2 pi q/0.5)``, from its own simulation."""
    time = PERIOD * np.arange(5000)
    generator = np.random.default_rng(seed)
    frequencies, phases = generator.uniform(0.2, 0.8, 4), generator.uniform(0.0, 2.0 * np.pi, 4)
    torque = 2.5 * np.sum(np.sin(2.0 * np.pi * np.outer(frequencies, time) + phases[:, np.newaxis]), axis=0)
    variation = map_parameters((0.5,), 0, None, 0.0, 1.0)
    model = OpenLoopModel(0.5, 1.0, 2.0, 0.0, 0.0, 1.0, np.zeros(1), variation, np.array([0.0, amplitude]))
    position = model.errors(Record(np.zeros(5000), np.zeros(5000), torque, PERIOD), np.array([0]), 5000)[0]
    return Log("log", time, torque, position=position)
