import numpy as np
import pytest

from adaptive_ff.errors import InputError
from adaptive_ff.scenario import content as module
from adaptive_ff.scenario.scenario import load_scenario
from adaptive_ff.scenario.series import SharedSeries


def test_series_is_computed_once_for_a_key_and_is_read_only():
    calls = []
    shared = SharedSeries()

    def compute():
        calls.append(1)
        return np.ones(3)

    first = shared.get("a", compute)
    assert shared.get("a", compute) is first
    assert len(calls) == 1
    with pytest.raises(ValueError, match="read-only"):
        first[0] = 2.0


def test_oldest_goes_where_room_is_short_and_what_is_too_long_is_not_kept():
    shared = SharedSeries(room=90)
    for name in "ab":
        shared.get(name, lambda: np.zeros(6))
    assert shared.get("b", lambda: np.ones(6))[0] == 0.0
    assert shared.get("a", lambda: np.ones(6))[0] == 1.0
    shared.get("long", lambda: np.zeros(12))
    assert shared.get("long", lambda: np.ones(12))[0] == 1.0


def test_reference_is_computed_once_and_handed_out_as_a_copy(monkeypatch):
    scenario = load_scenario().modified(duration=3.0, seed=123)
    kind = type(scenario.reference)
    calls = []
    original = kind.velocity
    monkeypatch.setattr(kind, "velocity", lambda self, *rest: calls.append(1) or original(self, *rest))
    first = scenario.modified(actuator={"torque_limit": 90.0}).reference_velocity()
    first[:] = 0.0
    second = scenario.reference_velocity()
    assert not calls
    assert second.flags.writeable
    assert np.any(second)
    module.MOTIONS.clear()
    np.testing.assert_array_equal(scenario.reference_velocity(), second)
    assert len(calls) == 1


@pytest.mark.parametrize("change", [{"seed": 124}, {"duration": 4.0}, {"joint": {"solver_period": 0.0005}}])
def test_reference_is_another_one_where_what_it_depends_on_differs(change):
    scenario = load_scenario().modified(duration=3.0, seed=123)
    other = scenario.modified(**change).reference_velocity()
    kept = other.copy()
    module.MOTIONS.clear()
    np.testing.assert_array_equal(scenario.modified(**change).reference_velocity(), kept)
    assert other.size != scenario.reference_velocity().size or np.any(other != scenario.reference_velocity())


def test_reference_too_fast_for_one_sampling_is_still_refused_after_another():
    wave = {"frequencies": [4.0], "amplitudes": [1.0]}
    scenario = load_scenario().modified(duration=3.0, reference=wave, feedback={"bandwidth": 1.0})
    with pytest.raises(InputError, match="lie between the samples"):
        scenario.modified(sampling={"period": 0.1})


def test_grid_of_times_is_shared_and_read_only():
    scenario = load_scenario().modified(duration=3.0)
    times = scenario.times()
    np.testing.assert_array_equal(times, 0.001 * np.arange(3001))
    assert scenario.modified(seed=5).times() is times
    assert not times.flags.writeable
    assert scenario.modified(joint={"solver_period": 0.0005}).times().size == 6001
