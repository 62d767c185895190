"""The plug-in of pytest, used as in a user's own test suite."""

import pytest

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
