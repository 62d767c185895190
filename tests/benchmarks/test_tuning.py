"""The search for the settings of the rivals."""

from concurrent.futures import ThreadPoolExecutor

import numpy as np
import pytest
import typer

from adaptive_ff import Scenario, load_scenario, simulate
from adaptive_ff.comparison.registry import CONTROLLERS
from benchmarks import tuning
from controllers import PI


def pi_with(factor):
    return lambda scenario: PI(*(factor * gain for gain in scenario.feedback.gains), scenario.sampling.period)


@pytest.fixture
def small(monkeypatch):
    """One joint, one rate, two candidates."""
    monkeypatch.setattr(tuning, "RATES", {"100 Hz": 0.01})
    monkeypatch.setattr(tuning, "JOINTS", {"slow": tuning.JOINTS["slow"]})
    monkeypatch.setattr(tuning, "CANDIDATES", {"pi": {"weak": pi_with(0.5), "as it is": pi_with(1.0)}})


def test_no_scenario_is_a_reported_one():
    built_in = load_scenario()
    for scenario in tuning.tuning_scenarios("radial_basis").values():
        assert isinstance(scenario, Scenario)
        assert scenario.joint != built_in.joint
        assert scenario.reference != built_in.reference
    assert len(tuning.tuning_scenarios()) == 6
    assert len(tuning.tuning_scenarios("radial_basis")) == 10
    assert tuning.FIRST_SEED > 100


def test_candidates_are_of_controllers_in_the_line_up_and_each_can_be_made():
    assert set(tuning.CANDIDATES) <= set(CONTROLLERS)
    for name, makers in tuning.CANDIDATES.items():
        found = tuning.tuning_scenarios(name)
        chosen = [tuning.searched(name, found[label]) for label in ("heavy, 1 kHz", "heavy, late") if label in found]

        def made(make, scenarios=chosen):
            return tuple(comparable(make(scenario).parameters) for scenario in scenarios)

        candidates = {made(make) for make in makers.values()}
        assert len(candidates) == len(makers)
        assert made(CONTROLLERS[name]) in candidates


def comparable(parameters):
    """Parameters with arrays as tuples."""
    if isinstance(parameters, np.ndarray):
        return tuple(parameters.ravel().tolist())
    return tuple(map(comparable, parameters)) if isinstance(parameters, tuple) else parameters


def test_every_rival_whose_source_leaves_something_open_is_searched():
    observers = {"disturbance_observer", "extended_state", "kalman_disturbance"}
    learners = {"adaptive_paper", "canudas", "canudas_measured", "feedback_error"}
    observed = {name for name in CONTROLLERS if name.startswith("observed_")}
    literature = {"lugre_observer", "maxwell_adaptive", "radial_basis", "super_twisting", "repetitive"}
    literature |= {"lugre_gradient", "friction_observer", "lee_tomizuka"}
    assert set(tuning.CANDIDATES) == observers | observed | learners | literature


def test_search_gives_the_medians_over_seeds_from_101(small):
    with ThreadPoolExecutor(1) as pool:
        found = tuning.search("pi", 3, pool)
    scenario = tuning.tuning_scenarios()["slow, 100 Hz"]
    errors = [simulate(scenario.modified(seed=seed), "pi").metrics.rms_error_settled for seed in (101, 102, 103)]
    assert found["as it is"] == [pytest.approx(np.median(errors), rel=1e-12)]
    assert found["weak"][0] > 1.2 * found["as it is"][0]


def test_table_marks_the_candidate_with_the_least_mean_ratio(small):
    table = tuning.table_of("pi", {"weak": [0.02], "as it is": [0.01]})
    assert [row.style for row in table.rows] == [None, "bold"]
    assert list(table.columns[2].cells) == ["2.000", "1.000"]


def test_unknown_name_is_refused_with_those_there_are():
    with pytest.raises(typer.BadParameter, match="'mine' is not known; there are disturbance_observer"):
        tuning.main(only="mine", seeds=1)
