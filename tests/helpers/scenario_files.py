"""Scenario files for tests: the built-in one as plain content, to be changed and written as TOML."""

import copy
import json
import math
import tomllib

import pytest

from adaptive_ff import InputError
from adaptive_ff.scenario.scenario import BUILT_IN

REMOVED = object()
"""Stands for a field that is to be taken away."""


def built_in():
    """Content of the built-in scenario."""
    return tomllib.loads(BUILT_IN.read_text(encoding="utf-8"))


def short():
    """Content of a scenario that runs in no time."""
    return {**built_in(), "duration": 0.5, "controllers": ["pi"]}


def changed(content, path, value):
    """Content with the value at a path such as ``joint.inertia`` or ``change.0.time`` replaced, added or removed."""
    content = copy.deepcopy(content)
    *parents, last = [int(part) if part.isdecimal() else part for part in path.split(".")]
    place = content
    for part in parents:
        place = place.setdefault(part, {}) if isinstance(place, dict) else place[part]
    if value is REMOVED:
        del place[last]
    else:
        place[last] = value
    return content


def to_toml(content):
    """Content as a TOML text, tables inline."""
    return "".join(f"{_text(key)} = {_value(value)}\n" for key, value in content.items())


def refused(prefix, function, *arguments, **named):
    """What a refusal, which is one line, says after a prefix."""
    with pytest.raises(InputError) as caught:
        function(*arguments, **named)
    message = str(caught.value)
    assert message.splitlines() == [message]
    assert message.startswith(prefix)
    return message.removeprefix(prefix)


def write_scenario(folder, content, name="scenario.toml"):
    """Write content as a TOML file and return its path."""
    path = folder / name
    path.write_text(to_toml(content), encoding="utf-8")
    return path


def _value(value):
    if isinstance(value, bool):
        return "true" if value else "false"
    if isinstance(value, dict):
        return "{" + ", ".join(f"{_text(key)} = {_value(item)}" for key, item in value.items()) + "}"
    if isinstance(value, list):
        return "[" + ", ".join(map(_value, value)) + "]"
    if isinstance(value, float) and not math.isfinite(value):
        return {math.inf: "inf", -math.inf: "-inf"}.get(value, "nan")
    return _text(value) if isinstance(value, str) else str(value)


def _text(text):
    return json.dumps(text, ensure_ascii=False).replace("\x7f", "\\u007f")
