"""Controllers against PI on a scenario, over draws of the noise."""

import numpy as np
import pytest

from adaptive_ff import load_scenario, simulate
from adaptive_ff.comparison.registry import CONTROLLERS
from adaptive_ff.simulation.metrics import rms
from adaptive_ff.studies.tracking import noisy_setups, run_errors, track_scenario

SCENARIO = load_scenario().modified(duration=23.0, change=[{"time": 11.0, "load": 30.0}])


def test_errors_are_roots_of_mean_squares_over_draws():
    found = track_scenario(SCENARIO, ["oracle"], draws=3)["oracle"]
    runs = [simulate(SCENARIO, "oracle", setup=setup) for setup in noisy_setups(SCENARIO, 3)]
    joined = np.array([run.reference - run.velocity for run in runs])
    assert found["error"] == pytest.approx(rms(joined[:, 17_000:]), rel=1e-12)


def test_behind_a_position_loop_the_error_is_that_of_the_position():
    run = simulate(SCENARIO.modified(position={}), "pi")
    found = run_errors(run)
    assert found.settled == pytest.approx(rms(run.position_error[17_000:]), rel=1e-12)
    assert found.settled < 0.2 * rms((run.reference - run.velocity)[17_000:])


def test_first_draw_is_the_scenario_itself_and_the_others_differ_in_noise_where_there_is_any():
    own, *others = noisy_setups(SCENARIO, 3)
    assert np.array_equal(own.noise, SCENARIO.noise())
    assert all(np.array_equal(setup.reference, own.reference) for setup in others)
    noises = np.array([own.noise, *(setup.noise for setup in others)])
    assert np.std(noises, axis=1) == pytest.approx(0.002, rel=0.05)
    assert np.max(np.abs(np.corrcoef(noises) - np.eye(3))) < 0.1
    assert len(list(noisy_setups(SCENARIO.modified(sensor={"velocity_noise": 0.0}), 5))) == 1


def test_pi_against_itself_is_one_everywhere_and_a_better_controller_is_better():
    found = track_scenario(SCENARIO, ["pi", "oracle", "noise_floor"])
    assert {found["pi"][name] for name in ("settled", "window", "start", "after", "torque_variation")} == {1.0}
    assert found["oracle"]["settled"] > 2.0
    assert found["oracle"]["window"] < 0.8
    assert found["noise_floor"]["error"] < found["oracle"]["error"]


class Runaway:
    calls = 0

    def step(self, reference, velocity):
        self.calls += 1
        return 10.0**self.calls if self.calls < 300 else 0.0


def test_a_loop_that_does_not_stay_finite_is_infinitely_worse(monkeypatch):
    monkeypatch.setitem(CONTROLLERS, "runaway", lambda _: Runaway())
    scenario = load_scenario().modified(duration=5.0, actuator={"torque_limit": 1e300})
    found = track_scenario(scenario, ["runaway"])["runaway"]
    assert (found["settled"], found["window"]) == (0.0, float("inf"))


def test_draws_must_be_positive():
    with pytest.raises(ValueError, match="draws = 0 is not allowed"):
        track_scenario(SCENARIO, ["pi"], draws=0)
