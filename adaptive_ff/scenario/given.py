"""What is given where a scenario is asked for."""

from typing import Any

from adaptive_ff.errors import check_kind
from adaptive_ff.scenario.scenario import Scenario


def check_scenario(scenario: Any) -> None:
    """Raise a TypeError for what is no scenario, such as the path of one."""
    rule = "a Scenario: load_scenario(path) reads a file, parse_scenario(tables, name) takes tables"
    check_kind("scenario", scenario, Scenario, rule)
