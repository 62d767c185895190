import numpy as np
import pytest

from adaptive_ff.errors import InputError
from adaptive_ff.scenario import content as module
from adaptive_ff.scenario.scenario import load_scenario


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
    module.measured_motion.cache_clear()
    np.testing.assert_array_equal(scenario.reference_velocity(), second)
    assert len(calls) == 1


@pytest.mark.parametrize("change", [{"seed": 124}, {"duration": 4.0}, {"joint": {"solver_period": 0.0005}}])
def test_reference_is_another_one_where_what_it_depends_on_differs(change):
    scenario = load_scenario().modified(duration=3.0, seed=123)
    other = scenario.modified(**change).reference_velocity()
    kept = other.copy()
    module.measured_motion.cache_clear()
    np.testing.assert_array_equal(scenario.modified(**change).reference_velocity(), kept)
    assert other.size != scenario.reference_velocity().size or np.any(other != scenario.reference_velocity())


def test_reference_too_fast_for_one_sampling_is_still_refused_after_another():
    wave = {"frequencies": [4.0], "amplitudes": [1.0]}
    scenario = load_scenario().modified(duration=3.0, reference=wave, feedback={"bandwidth": 1.0})
    with pytest.raises(InputError, match="lie between the samples"):
        scenario.modified(sampling={"period": 0.1})
