"""The regression gate, as a function and on the command line."""

import json

import pytest
from command_line import refusal, run_command_line
from scenario_files import write_scenario

from adaptive_ff import InputError, assert_no_regression, compare, load_scenario, read_baseline, regressions
from adaptive_ff.comparison.baseline import GATED

SHORT = load_scenario().modified(duration=2.0, controllers=["pi", "oracle"])


@pytest.fixture(scope="module")
def comparison():
    return compare(SHORT)


@pytest.fixture
def baseline(comparison, tmp_path):
    path = tmp_path / "baseline.json"
    path.write_text(json.dumps(comparison.to_dict()))
    return path


def changed(path, **figures):
    content = json.loads(path.read_text())
    for name, value in figures.items():
        content["controllers"]["pi"][name] = value
    path.write_text(json.dumps(content))
    return path


def test_same_result_passes(comparison, baseline):
    assert regressions(comparison, read_baseline(baseline), 0.0) == []
    assert_no_regression(comparison, baseline)


@pytest.mark.parametrize("figure", GATED)
def test_each_figure_is_gated(comparison, baseline, figure):
    old = comparison.to_dict()["controllers"]["pi"][figure]
    changed(baseline, **{figure: old / 1.06})
    (sentence,) = regressions(comparison, read_baseline(baseline), 0.05)
    assert sentence.startswith(f"pi: {figure} grew")
    assert "6.0 %" in sentence
    assert regressions(comparison, read_baseline(baseline), 0.07) == []
    with pytest.raises(AssertionError, match=figure):
        assert_no_regression(comparison, baseline)


def test_controller_that_was_not_run_is_named(comparison, baseline):
    content = read_baseline(baseline)
    content["controllers"]["gone"] = content["controllers"]["pi"]
    assert regressions(comparison, content) == ["gone: is in the baseline, but was not run"]


@pytest.mark.parametrize("tolerance", [-0.1, float("nan"), float("inf")])
def test_tolerance_out_of_range(comparison, baseline, tolerance):
    with pytest.raises(ValueError, match="tolerance"):
        regressions(comparison, read_baseline(baseline), tolerance)


@pytest.mark.parametrize("text", ["", "[]", "{}", '{"controllers": {}}', '{"controllers": {"pi": 1}}', "\x00"])
def test_file_that_is_no_result(tmp_path, text):
    path = tmp_path / "baseline.json"
    path.write_text(text)
    with pytest.raises(InputError, match=r"baseline\.json"):
        read_baseline(path)


@pytest.mark.parametrize("value", [None, "1", True, -1.0, float("nan")])
def test_figure_that_is_no_number(baseline, value):
    with pytest.raises(InputError, match=r"controllers\.pi\.rms_error"):
        read_baseline(changed(baseline, rms_error=value))


def test_command_line_passes_and_fails(baseline, tmp_path):
    scenario = write_scenario(tmp_path, SHORT.model_dump(mode="json", exclude_none=True))
    arguments = ("compare", scenario, "--out", tmp_path / "out", "--baseline", baseline)
    assert run_command_line(*arguments).status == 0
    changed(baseline, rms_error_settled=1e-6)
    outcome = run_command_line(*arguments)
    assert outcome.status == 1
    assert "pi: rms_error_settled grew" in outcome.err
    assert run_command_line(*arguments, "--tolerance", "1e9").status == 0


@pytest.mark.parametrize("tolerance", ["", "five", "-1%", "nan", "inf%"])
def test_command_line_refuses_a_tolerance(baseline, tmp_path, tolerance):
    line = refusal("compare", "--out", tmp_path / "out", "--baseline", baseline, f"--tolerance={tolerance}")
    assert "--tolerance" in line


def test_command_line_refuses_a_missing_baseline(tmp_path):
    assert "nowhere.json" in refusal("compare", "--out", tmp_path / "out", "--baseline", tmp_path / "nowhere.json")
