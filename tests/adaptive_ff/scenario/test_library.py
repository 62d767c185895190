"""Scenarios of the package by name."""

import pytest
from command_line import refusal, run_command_line

from adaptive_ff import InputError, load_scenario
from adaptive_ff.scenario.library import SCENARIOS, scenario_names, scenario_title


def test_a_scenario_is_found_by_its_name():
    assert load_scenario("encoder") == load_scenario(SCENARIOS / "encoder.toml")
    assert load_scenario("triangle").reference_velocity().size > 0  # its recorded reference lies beside it


def test_a_file_of_that_name_comes_first(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    (tmp_path / "encoder").write_text((SCENARIOS / "delay.toml").read_text())
    assert load_scenario("encoder") == load_scenario("delay")
    with pytest.raises(InputError, match="no_such"):
        load_scenario("no_such")


def test_every_scenario_says_in_a_line_what_it_is():
    assert [name for name in scenario_names() if not 10 < len(scenario_title(name)) < 130] == []


def test_command_lists_them_and_every_command_takes_their_names():
    outcome = run_command_line("scenarios")
    assert outcome.status == 0
    listed = [line for line in outcome.out.splitlines() if line.startswith("  ")]
    assert sorted(name for line in listed for name in line.strip().rstrip(",").split(", ")) == scenario_names()
    described = run_command_line("scenarios", "steep_2").out.splitlines()
    assert described == [f"{name:8}  {scenario_title(name)}" for name in ("steep_2", "steep_20")]
    assert "TEXT = 'nothing' is in no scenario" in refusal("scenarios", "nothing")
