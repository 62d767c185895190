"""Scenarios written as TOML files."""

import json
import math
from typing import Any

from adaptive_ff.scenario.scenario import Scenario


def to_toml(scenario: Scenario) -> str:
    """Return a scenario as the text of a scenario file that reads back equal."""
    content = scenario.model_dump(mode="python", exclude_none=True)
    plain = {name: value for name, value in content.items() if not isinstance(value, dict) and name != "change"}
    lines = [f"{name} = {_value(value)}" for name, value in plain.items()]
    for name, table in content.items():
        if isinstance(table, dict):
            lines += ["", f"[{name}]", *(f"{key} = {_value(value)}" for key, value in table.items())]
    for change in content["change"]:
        lines += ["", "[[change]]", *(f"{key} = {_value(value)}" for key, value in change.items())]
    return "\n".join(lines) + "\n"


def _value(value: Any) -> str:
    if isinstance(value, list):
        return "[" + ", ".join(map(_value, value)) + "]"
    if isinstance(value, str):
        return json.dumps(value).replace("\x7f", "\\u007f")
    if isinstance(value, float) and not math.isfinite(value):
        raise ValueError(f"{value} cannot stand in a scenario file")
    return repr(value)
