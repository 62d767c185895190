"""What a comparison looks like in a console, a notebook, pandas and xarray, and the verdict that it comes to.

A thinned run keeps few samples, and its figures are those of the whole run.
"""

import importlib
from dataclasses import replace

import numpy as np
import pytest
from closed_loops import SCENARIO
from picture_figures import Proportional

from adaptive_ff import InputError, compare, load_scenario, simulate
from adaptive_ff.comparison.comparison import error_parts, verdict
from adaptive_ff.report.verdicts import LIMITS, comparison_lines
from adaptive_ff.studies.sweep import sweep

SHORT = SCENARIO.modified(duration=10.0, controllers=["pi", "oracle", "adaptive"])
QUIET = {"velocity_noise": 0.0}


@pytest.fixture(scope="module")
def comparison():
    return compare(SHORT.modified(duration=6.0, controllers=["pi", "adaptive"]))


def test_units_are_those_of_the_axis_and_noise_is_blamed_where_there_is_some_alone():
    linear = SHORT.modified(joint={"axis": "linear"}, duration=3.0, position={})
    found = compare(linear)
    assert "rms error, m/s: pi" in repr(found)
    assert repr(found.runs["pi"]).endswith(" m/s)")
    assert "gravity_sin" not in found.runs["adaptive"].estimates
    worse = {**found.runs, "oracle": found.runs["pi"]}
    assert "noise of the measurement" in replace(found, runs=worse).cautions()[0]
    steep = linear.modified(joint={"stiction": 500.0})
    for other in (linear.modified(sensor=QUIET), steep):
        runs = {name: replace(run, scenario=other) for name, run in worse.items()}
        assert replace(found, scenario=other, runs=runs).cautions() == []


def test_a_comparison_and_a_run_are_equal_to_themselves_alone(comparison):
    run = comparison.runs["pi"]
    assert len({comparison, replace(comparison), run, replace(run)}) == 4
    assert comparison == comparison
    assert run != replace(run)


@pytest.mark.parametrize("call", [compare, simulate, lambda given: sweep(given, 1)])
@pytest.mark.parametrize("given", ["joint.toml", {"duration": 1.0}])
def test_what_is_no_scenario_is_refused_with_what_makes_one(call, given):
    with pytest.raises(TypeError) as refused:
        call(given)
    assert str(refused.value) == (
        f"scenario = {given!r} is not allowed: it must be a Scenario: load_scenario(path) reads a file, "
        "parse_scenario(tables, name) takes tables"
    )


def test_tables_in_the_place_of_a_file_and_places_that_take_no_pictures_are_refused(comparison, tmp_path):
    said = r"^path = \{'duration': 1.0\} is not allowed: it must be a path; parse_scenario"
    with pytest.raises(TypeError, match=said):
        load_scenario({"duration": 1.0})
    with pytest.raises(TypeError, match=r"folder = b'pictures' is not allowed: it must be a path"):
        comparison.plot(b"pictures")
    with pytest.raises(TypeError, match=r"path = 5 is not allowed: it must be a path"):
        comparison.runs["pi"].plot(5)
    file = tmp_path / "result.json"
    file.write_text("{}")
    with pytest.raises(InputError, match=r"result.json/tracking.png: cannot be written: Not a directory"):
        comparison.plot(file)
    with pytest.raises(InputError, match=r"path = .*result.json' is not allowed: it must end in one of .*png"):
        comparison.runs["pi"].plot(file)
    assert file.read_text() == "{}"


def test_notebook_shows_tables_and_a_picture(comparison):
    text = comparison._repr_html_()
    assert text.count("<table>") == 2
    assert text.count("<img ") == 1
    assert f"{comparison.improvement['adaptive']:.2f}</td>" in text
    assert "kg m²" in text


def test_frame_of_pandas(comparison):
    pytest.importorskip("pandas")
    frame = comparison.to_pandas()
    assert list(frame.index) == ["pi", "adaptive"]
    for name, run in comparison.runs.items():
        assert frame.loc[name, "rms_error_settled"] == run.metrics.rms_error_settled
        assert frame.loc[name, "improvement"] == comparison.improvement[name]
    assert frame.attrs["units"]["rms_error"] == "rad/s"
    assert set(frame.attrs["units"]) == set(frame.columns)


def test_dataset_of_xarray(comparison):
    pytest.importorskip("xarray")
    dataset = comparison.to_xarray()
    run = comparison.runs["adaptive"]
    assert np.array_equal(dataset["torque"].sel(controller="adaptive"), run.torque)
    assert np.array_equal(dataset["time"], run.time)
    assert (dataset["torque"].attrs["units"], dataset["velocity"].attrs["units"]) == ("N m", "rad/s")
    assert dataset["time"].attrs["units"] == "s"


LIMITED = {"noise": {}, "friction": {"sensor": QUIET}, "saturation": {"actuator": {"torque_limit": 80.0}}}
LIMITED["bandwidth"] = {"sensor": QUIET, "joint": {"coulomb": 0.0, "stiction": 0.0, "viscous": 0.0}}


@pytest.mark.parametrize(("limit", "changed"), LIMITED.items())
def test_limit_is_the_largest_part_of_the_error(changed, limit):
    found = verdict(compare(SHORT.modified(**changed)))
    assert found.limit == limit
    assert any(LIMITS[limit][0] in line for line in comparison_lines(found))


def test_best_is_a_controller_that_does_not_know_the_truth_and_says_what_it_identified():
    comparison = compare(SHORT.modified(controllers=["pi", "oracle", "fixed", "adaptive"]))
    found = verdict(comparison)
    assert found.best == "adaptive"
    assert found.over_pi == comparison.improvement["adaptive"]
    assert "inertia" in found.identified
    assert "gravity_sin" in found.given  # there is none
    assert not set(found.identified) & set(found.given)


def test_where_nothing_beats_pi_it_is_kept():
    found = verdict(compare(SHORT.modified(duration=5.0, controllers=["pi", "oracle"])))
    assert (found.best, found.over_pi, found.worth, found.identified) == ("pi", 1.0, False, ())
    assert comparison_lines(found)[0] == "Verdict: pi: nothing that ran is worth it on this joint, keep pi."


def test_without_pi_nothing_is_said_of_worth_and_late_changes_do_not_hide_the_limit():
    late = {"duration": 70.0, "controllers": ["oracle", "fixed"], "change": [{"time": 65.0, "friction_scale": 0.5}]}
    found = verdict(compare(SCENARIO.modified(**late)))
    assert (found.best, found.over_pi, found.worth) == ("fixed", None, False)
    assert comparison_lines(found)[0].startswith("Verdict: fixed: the least settled error")
    assert found.limit is not None


def test_parts_add_up_to_the_error():
    parts = error_parts(SHORT, 1e-2)
    assert sum(value**2 for value in parts.values()) == pytest.approx(1e-4)


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
