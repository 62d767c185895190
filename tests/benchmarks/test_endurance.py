"""A short run of the week: restarts, faults and changes are in it, and what would be wrong is seen."""

from dataclasses import replace

import numpy as np
import pytest

from benchmarks.endurance import week
from benchmarks.endurance.__main__ import verdict


@pytest.fixture(scope="module")
def scenario():
    return week.drawn_joint(3)


def test_an_hour_with_a_restart_after_every_part_holds(scenario, monkeypatch):
    monkeypatch.setattr(week, "RESTARTS", 1.0)
    outcome = week.live(scenario, 3, 1.0)
    assert (outcome.hours, outcome.restarts, outcome.outside) == (1.0, 4, 0)
    assert 0.0 < outcome.torque <= 1.0
    assert verdict(outcome) == "holds"


def test_what_is_wrong_is_named():
    good = week.Week(0, 1.0, 0, 1.0, 0, 1.0, 1.05, 3.0)
    assert verdict(good) == "holds"
    wrong = {"torque": 1.001, "outside": 1, "after": 1.2, "growth": 21.0}
    named = ["torque beyond the limit", "estimates out of bounds", "error", "memory"]
    assert [verdict(replace(good, **{name: value})) for name, value in wrong.items()] == named
    assert verdict(replace(good, torque=np.nan, after=np.nan)) == "torque beyond the limit, error"


def test_drawn_minutes_hold_all_that_is_promised(scenario):
    joint = week.Joint(scenario, np.random.default_rng(5))
    noises = np.concatenate([joint._minutes()[1] for _ in range(6)])
    assert np.any(np.isnan(noises))
    assert np.any(np.isinf(noises))
    assert np.any(np.abs(noises[np.isfinite(noises)]) > 1e3)
    torque = np.max(np.abs(joint.drawn_part().given))
    assert 0.0 < torque <= joint.limit


def test_an_estimate_out_of_bounds_is_seen(scenario):
    joint = week.Joint(scenario, np.random.default_rng(5))
    record = joint.drawn_part()
    assert joint.estimates_hold(record)
    record.estimates[17, 0] = np.nan
    assert not joint.estimates_hold(record)
    record.estimates[17, 0] = 0.0
    assert not joint.estimates_hold(record)
