"""A thinned run keeps few samples, and its figures are those of the whole run."""

import importlib

import numpy as np
import pytest
from picture_figures import Proportional

from adaptive_ff import compare, load_scenario, simulate

SCENARIOS = {
    "built-in": {},
    "late drive": {"actuator": {"delay": 0.025}, "feedback": {"bandwidth": 2.0}},
    "lagging drive": {"actuator": {"lag": 0.01}},
    "jitter": {"sampling": {"jitter": 0.3}, "change": [{"time": 2.0, "friction_scale": 0.6}]},
    "warming up": {"variation": {"warm_up_excess": 0.5, "position_amplitude": 0.1}},
    "position loop": {"position": {}},
    "standing still at first": {"reference": {"pause": [0.0, 2.0]}},
}


def scenario(name):
    return load_scenario().modified(duration=6.0, **SCENARIOS[name])


@pytest.mark.parametrize(("name", "controller"), [*((name, "pi") for name in SCENARIOS), ("built-in", "adaptive")])
def test_kept_samples_and_figures_are_those_of_the_whole_run(name, controller):
    asked = scenario(name)
    whole, thinned = simulate(asked, controller), simulate(asked, controller, thin=7)
    kept = np.unique([*range(0, whole.time.size, 7), whole.time.size - 1])
    columns = whole.columns()
    assert set(thinned.columns()) == set(columns)
    for key, series in thinned.columns().items():
        assert np.array_equal(series, columns[key][kept], equal_nan=True), key
    assert thinned.figures() == pytest.approx(whole.figures(), rel=1e-13)
    assert thinned.final_estimates == whole.final_estimates
    assert np.array_equal(thinned.uncertainty_time, whole.uncertainty_time)
    assert (thinned.position_metrics is None) == (name != "position loop")


def test_own_controller_is_thinned_too():
    asked = scenario("built-in").modified(duration=1.0)
    runs = [compare(asked, own={"mine": Proportional}, thin=thin).runs["mine"] for thin in (1, 10)]
    assert runs[1].figures() == pytest.approx(runs[0].figures(), rel=1e-13)
    assert runs[1].torque.size == 11


def test_a_long_run_is_thinned_unless_all_is_asked_for(monkeypatch):
    asked = scenario("built-in")
    assert simulate(asked, "pi").thin == 1
    monkeypatch.setattr(importlib.import_module("adaptive_ff.comparison.run"), "MOST_STEPS", 2500)
    assert [simulate(asked, "pi", thin=thin).thin for thin in (None, 1)] == [3, 1]


def test_diverging_run_is_refused_and_so_is_a_thinning_below_one():
    class Diverging:
        def step(self, reference, velocity, **_):
            return 1e200

    with np.errstate(all="ignore"), pytest.raises(ArithmeticError, match="did not stay finite"):
        simulate(scenario("built-in").modified(actuator={"torque_limit": None}), Diverging(), thin=5)
    with pytest.raises(ValueError, match="thin = 0 is not allowed"):
        simulate(scenario("built-in"), thin=0)
