"""The regression gate, as a function, on the command line and as a plug-in of pytest in a user's own test suite."""

import json

import numpy as np
import pytest
from command_line import refusal, run_command_line
from picture_figures import Proportional
from scenario_files import refused, write_scenario
from scipy import stats

from adaptive_ff import Comparison, InputError, assert_no_regression, compare, load_scenario, read_baseline, regressions
from adaptive_ff.comparison.gate import scenario_differences
from adaptive_ff.comparison.run import simulate
from adaptive_ff.scenario.reference import Recorded
from adaptive_ff.simulation.metrics import METRIC_UNITS

SHORT = load_scenario().modified(duration=2.0, controllers=["pi", "fixed", "oracle"])


@pytest.fixture(scope="module")
def comparison():
    return compare(SHORT)


@pytest.fixture
def baseline(comparison, tmp_path):
    path = tmp_path / "baseline.json"
    comparison.write(path)
    return path


def gated(folder, scenario, *options):
    """Arguments of a comparison of a scenario, as a file in a folder, that is held against a baseline."""
    file = write_scenario(folder, scenario.model_dump(mode="json", exclude_none=True))
    return ("compare", file, "--out", folder / "out", *options)


def changed(path, **figures):
    content = json.loads(path.read_text())
    for name, value in figures.items():
        content["controllers"]["pi"][name] = value
    path.write_text(json.dumps(content))
    return path


def test_a_linear_axis_is_said_in_its_units(comparison):
    moving = compare(SHORT.modified(joint={"axis": "linear"}, controllers=["pi"]))
    stored = moving.to_dict()
    stored["controllers"]["pi"].update(max_error=1e-6, torque_variation=1e-6)
    first, second = regressions(moving, stored, 0.05)
    assert "mm/s (" in first
    assert " N (" in second


@pytest.mark.parametrize("figure", METRIC_UNITS)
def test_each_figure_is_gated(comparison, baseline, figure):
    old = comparison.to_dict()["controllers"]["pi"][figure]
    changed(baseline, **{figure: old / 1.06})
    (sentence,) = regressions(comparison, read_baseline(baseline), 0.05)
    assert sentence.startswith(f"pi: {figure} grew")
    assert "6.0 %" in sentence
    assert ("N m (" if figure == "torque_variation" else "mrad/s (") in sentence
    assert regressions(comparison, read_baseline(baseline), 0.07) == []
    with pytest.raises(AssertionError, match=figure):
        assert_no_regression(comparison, baseline)


def test_most_particular_tolerance_counts(comparison, baseline):
    figures = vars(comparison.runs["pi"].metrics)
    changed(baseline, rms_error=figures["rms_error"] / 1.2, max_error=figures["max_error"] / 1.2)
    stored = read_baseline(baseline)
    tolerances = {"default": "1%", "pi": "30%"}
    assert regressions(comparison, stored, tolerances) == []
    tolerances["rms_error"] = 0.1
    (sentence,) = regressions(comparison, stored, tolerances)
    assert "pi: rms_error grew" in sentence
    assert "allowed 10 %" in sentence
    tolerances["pi.rms_error"] = "25%"
    assert regressions(comparison, stored, tolerances) == []
    with pytest.raises(InputError, match=r"tolerance 'rms_eror' is not known; there are the metrics rms_error, "):
        regressions(comparison, stored, {"rms_eror": 0.1})


def test_oracle_is_guarded_only_where_it_is_chosen(comparison, baseline):
    content = read_baseline(baseline)
    for figure in METRIC_UNITS:
        content["controllers"]["oracle"][figure] *= 0.5
    assert regressions(comparison, content) == []
    assert len(regressions(comparison, content, controllers=["oracle"])) == len(METRIC_UNITS)
    (sentence,) = regressions(comparison, content, controllers=["oracle"], metrics=["max_error"])
    assert sentence.startswith("oracle: max_error grew")
    with pytest.raises(InputError, match="'adaptive' is not in the baseline; there are pi, fixed, oracle"):
        regressions(comparison, content, controllers=["adaptive"])
    with pytest.raises(InputError, match="metric 'rms' is not known; there are rms_error"):
        regressions(comparison, content, metrics=["rms"])
    with pytest.raises(InputError, match=r"metric 'rms_position_error' is not in the baseline of pi; there are rms_e"):
        regressions(comparison, content, metrics=["rms_position_error"])


def test_position_errors_are_gated_behind_a_position_loop(tmp_path):
    moved = compare(SHORT.modified(position={}, controllers=["pi"]))
    path = tmp_path / "cascade.json"
    moved.write(path)
    assert regressions(moved, read_baseline(path), 0.0) == []
    old = moved.to_dict()["controllers"]["pi"]["rms_position_error"]
    changed(path, rms_position_error=old / 1.06)
    (sentence,) = regressions(moved, read_baseline(path), 0.05)
    assert "rms_position_error grew" in sentence
    assert "mrad (6.0 %" in sentence
    assert regressions(moved, read_baseline(path), 0.05, metrics=["max_position_error", "rms_error"]) == []
    changed(path, rms_position_error="far")
    with pytest.raises(InputError, match=r"controllers\.pi\.rms_position_error = 'far' is not allowed"):
        read_baseline(path)


@pytest.mark.parametrize("name", ["controllers", "metrics"])
def test_gate_that_looks_at_nothing_is_refused(comparison, baseline, name):
    stored = read_baseline(baseline)
    with pytest.raises(InputError, match=rf"^{name} = \[\] is not allowed: name one at least"):
        regressions(comparison, stored, **{name: []})
    said = rf"^{name} = [\s\S]* is not allowed: it must be a list of names, such as \['[a-z_]+'\]"
    for wrong in ("pi", 5, [1.0], np.ones((2, 2))):
        with pytest.raises(InputError, match=said):
            regressions(comparison, stored, **{name: wrong})


def test_own_controller_is_guarded_by_default_and_named_where_it_did_not_run(comparison, baseline):
    content = read_baseline(baseline)
    content["controllers"] = {"oracle": content["controllers"]["oracle"], "mine": content["controllers"]["pi"]}
    assert regressions(comparison, content) == ["mine: is in the baseline, but was not run"]
    del content["controllers"]["mine"]
    with pytest.raises(InputError, match=r"not guarded by default \(oracle\)"):
        regressions(comparison, content)


def test_own_controller_that_the_baseline_does_not_have_is_named_unless_others_are_chosen(baseline):
    content = read_baseline(baseline)
    found = compare(SHORT, own={"mine": Proportional})
    assert regressions(found, content) == ["mine: is not in the baseline, so nothing guards it"]
    assert regressions(found, content, controllers=["pi"]) == []


@pytest.mark.parametrize(
    ("tables", "said"),
    [
        ({"seed": 2}, "seed is 1 there and 2 here"),
        ({"feedback": {"bandwidth": 8.0}}, "feedback.bandwidth is 10.0 there and 8.0 here"),
        ({"sensor": {"velocity_noise": 0.0}}, "sensor.velocity_noise is 0.002 there and 0.0 here"),
        ({"change": [{"time": 1.0, "friction_scale": 0.5}]}, "change.0.time is not given there and 1.0 here"),
    ],
)
def test_baseline_of_another_scenario_is_no_regression_but_refused(baseline, tables, said):
    other = Comparison(SHORT.modified(**tables), {})
    assert said in refused(f"{baseline}: is of another scenario: ", assert_no_regression, other, baseline)


def test_fields_that_an_earlier_version_did_not_have_count_as_their_defaults(comparison, baseline):
    content = read_baseline(baseline)
    del content["scenario"]["variation"], content["scenario"]["sampling"]["jitter"]
    assert scenario_differences(comparison.scenario, content) == []
    jittered = SHORT.modified(sampling={"jitter": 0.5})
    assert scenario_differences(jittered, content) == ["sampling.jitter is not given there and 0.5 here"]


def test_recorded_reference_may_lie_elsewhere(baseline):
    content = read_baseline(baseline)
    content["scenario"]["reference"] = {"kind": "csv", "path": "C:\\runs\\motion.csv"}
    here = SHORT.model_copy(update={"reference": Recorded(kind="csv", path="/home/me/motion.csv")})
    assert scenario_differences(here, content) == []
    here = SHORT.model_copy(update={"reference": Recorded(kind="csv", path="/home/me/other.csv")})
    assert scenario_differences(here, content) == ['reference.path is "motion.csv" there and "other.csv" here']


def test_command_line_passes_and_fails(baseline, tmp_path, without_pictures):
    arguments = gated(tmp_path, SHORT, "--baseline", baseline)
    outcome = run_command_line(*arguments)
    assert outcome.status == 0
    assert f"Nothing is worse than in {baseline}, within the tolerances." in outcome.out
    assert "Guarded: 6 figures of pi, fixed, within 5 %; not guarded: oracle (--guard NAME)" in outcome.out
    changed(baseline, rms_error_settled=1e-6)
    outcome = run_command_line(*arguments)
    assert outcome.status == 1
    assert f"worse than {baseline}: pi: rms_error_settled grew" in outcome.err
    assert "Guarded: 6 figures of pi, fixed, within 5 %; not guarded: oracle" in outcome.out
    for passing in (
        ("--tolerance", "1e9%"),
        ("--tolerance", "1%", "--tolerance", "pi.rms_error_settled=1e9%"),
        ("--guard", "fixed"),
        ("--metric", "max_error", "--metric", "rms_error"),
    ):
        assert run_command_line(*arguments, *passing).status == 0, passing


def test_change_of_gains_is_gated_on_demand(baseline, tmp_path, without_pictures):
    """A slower loop is another scenario; across gains its figures are compared, and are worse."""
    slower = SHORT.modified(feedback={"bandwidth": 5.0})
    arguments = gated(tmp_path, slower, "--baseline", baseline)
    assert refusal(*arguments).endswith("or make a new baseline, or compare across gains (--across gains)")
    outcome = run_command_line(*arguments, "--across", "gains")
    assert outcome.status == 1
    assert f"worse than {baseline}: pi: rms_error grew" in outcome.err
    assert regressions(compare(slower), read_baseline(baseline), "1000%", across=["gains"]) == []
    louder = slower.modified(sensor={"velocity_noise": 0.0})
    said = r"is of another scenario: sensor\.velocity_noise is 0\.002 there and 0\.0 here; .* a new baseline$"
    with pytest.raises(InputError, match=said):
        regressions(Comparison(louder, {}), read_baseline(baseline), across=["gains"])
    assert "across = 'noise' is not known; there are gains" in refusal(*arguments, "--across", "noise")
    assert "need a --baseline" in refusal("compare", "--across", "gains")


def test_gate_over_seeds_compares_means_and_tolerates_their_scatter(tmp_path):
    arguments, path = gated(tmp_path, SHORT, "--seeds", 3, "--controller", "pi"), tmp_path / "seeds.json"
    assert run_command_line(*arguments, "--json", path).status == 0
    stored = read_baseline(path)
    values = stored["by_seed"]["pi"]["rms_error"]
    assert values == [simulate(SHORT.modified(seed=seed), "pi").metrics.rms_error for seed in (1, 2, 3)]
    assert run_command_line(*arguments, "--baseline", path).status == 0
    spread = stats.sem(values) * stats.t.ppf(0.975, 2) / np.mean(values)
    for share, status, options in ((0.9, 0, ()), (1.1, 1, ()), (1.1, 0, ("--tolerance", "1000%"))):
        stored["by_seed"]["pi"]["rms_error"] = [value / (1.0 + share * spread) for value in values]
        other = tmp_path / "other.json"
        other.write_text(json.dumps(stored))
        outcome = run_command_line(*arguments, "--metric", "rms_error", "--baseline", other, *options)
        assert outcome.status == status, outcome
    line = refusal(*gated(tmp_path, SHORT, "--seeds", 2, "--baseline", path))
    assert "seeds = 2 is not allowed: the baseline is of 3" in line
    with pytest.raises(ValueError, match="seeds = 0 is not allowed"):
        compare(SHORT, seeds=0)


def test_command_line_refuses_before_it_runs(baseline, tmp_path):
    line = refusal(*gated(tmp_path, SHORT.modified(seed=7), "--baseline", baseline))
    assert f"{baseline}: is of another scenario: seed is 1 there and 7 here" in line
    for options, said in (
        (["--baseline", baseline, "--across", "gains", "--tolerance=gone=5%"], "tolerance 'gone' is not known"),
        (["--baseline", baseline, "--tolerance=5"], "tolerance = '5' is not allowed"),
        (["--guard", "pi"], "need a --baseline"),
        (["--baseline", tmp_path / "nowhere.json"], "nowhere.json: cannot be read"),
    ):
        assert said in refusal(*gated(tmp_path, SHORT, *options))
    assert not (tmp_path / "out").exists()


PLUGIN = "adaptive_ff.comparison.pytest_plugin"

SUITE = """
import pytest
from adaptive_ff import compare, load_scenario

SCENARIO = load_scenario().modified(duration=2.0, controllers=["pi"], seed={seed}, sensor={{"velocity_noise": {noise}}})


@pytest.mark.parametrize("way", ["a b"])
def test_tracking(way, tracking_baseline):
    comparison = compare(SCENARIO)
    tracking_baseline.check(comparison, tolerance="{tolerance}")
    tracking_baseline.check(comparison, name="strict", tolerance=0.0)
"""


@pytest.fixture
def suite(pytester, monkeypatch):
    """Runs a test suite that uses the fixture; returns the outcome."""
    monkeypatch.setenv("PYTEST_DISABLE_PLUGIN_AUTOLOAD", "1")

    def run(*options, seed=1, noise=0.002, tolerance="5%"):
        pytester.makepyfile(test_mine=SUITE.format(seed=seed, noise=noise, tolerance=tolerance))
        return pytester.runpytest_inprocess("-p", PLUGIN, *options)

    run.path = pytester.path
    return run


def test_baseline_is_missing_then_stored_then_guarded(suite):
    outcome = suite()
    outcome.assert_outcomes(failed=1)
    outcome.stdout.fnmatch_lines(["*there is no baseline *run pytest once with --update-tracking-baseline*"])
    outcome = suite("--update-tracking-baseline")
    outcome.assert_outcomes(passed=1)
    folder = suite.path / "tracking_baselines"
    names = {"test_mine-test_tracking_a_b.json", "test_mine-test_tracking_a_b-strict.json"}
    assert {file.name for file in folder.iterdir()} == names
    outcome.stdout.fnmatch_lines([f"tracking baseline stored: {folder}*"])
    suite().assert_outcomes(passed=1)
    file = folder / "test_mine-test_tracking_a_b.json"
    text = file.read_text(encoding="utf-8").replace('"rms_error": 0.0', '"rms_error": 0.00')
    file.write_text(text, encoding="utf-8")
    outcome = suite()
    outcome.assert_outcomes(failed=1)
    outcome.stdout.fnmatch_lines(
        ["*test_tracking*", "tracking got worse than in *: pi: rms_error grew from * mrad/s *", "*short test summary*"]
    )
    outcome.stdout.no_fnmatch_line("*comparison = compare(SCENARIO)*")


def test_another_scenario_is_named_as_such(suite):
    suite("--update-tracking-baseline").assert_outcomes(passed=1)
    outcome = suite(seed=2, noise=0.001)
    outcome.assert_outcomes(failed=1)
    outcome.stdout.fnmatch_lines(["*is of another scenario: seed is 1 there and 2 here; sensor.velocity_noise is *"])
    suite(tolerance="5").assert_outcomes(failed=1)
