"""Scenarios written as TOML files."""

import json
import math
from collections.abc import Iterator, Mapping, Sequence
from pathlib import Path
from typing import Any

from adaptive_ff.scenario.scenario import Scenario

COMMENTS_FROM = 34  # column in which comments begin


def to_toml(scenario: Scenario) -> str:
    """Return a scenario as the text of a file that reads back equal, wherever it lies: paths in it are absolute."""
    content = scenario.model_dump(mode="python", exclude_none=True)
    if "path" in content["reference"]:
        content["reference"]["path"] = str(Path(content["reference"]["path"]).resolve())
    return toml_text(content)


def toml_text(content: Mapping[str, Any], comments: Mapping[str, str] | None = None, head: Sequence[str] = ()) -> str:
    """Return the content of a scenario as the text of a scenario file, below a comment of some lines.

    A comment stands beside the field, or the table, whose path it has, such as ``joint.inertia``.
    """
    said = comments or {}
    paragraphs = [[f"# {line}" for line in head]]
    paragraphs.append(list(_fields({key: value for key, value in content.items() if not _is_table(value)}, "", said)))
    for name, value in content.items():
        if isinstance(value, Mapping):
            paragraphs.append([with_comment(f"[{name}]", said.get(name)), *_fields(value, f"{name}.", said)])
        elif _is_table(value):
            paragraphs += [[f"[[{name}]]", *_fields(row, f"{name}.", said)] for row in value]
    return "\n\n".join("\n".join(paragraph) for paragraph in paragraphs if paragraph) + "\n"


def _is_table(value: Any) -> bool:
    """Whether a value is a table, or a list of tables, which in TOML must come after all plain fields."""
    if isinstance(value, list):
        return all(isinstance(item, Mapping) for item in value)
    return isinstance(value, Mapping)


def _fields(table: Mapping[str, Any], path: str, comments: Mapping[str, str]) -> Iterator[str]:
    for key, value in table.items():
        yield with_comment(f"{key} = {toml_value(value)}", comments.get(path + key))


def with_comment(text: str, comment: str | None) -> str:
    """Return a line of a scenario file with a comment in its column, or without one."""
    return f"{text:<{COMMENTS_FROM}}# {comment}" if comment else text


def toml_value(value: Any) -> str:
    """Return a value as it stands in a scenario file."""
    if isinstance(value, bool):
        return "true" if value else "false"
    if isinstance(value, list):
        return "[" + ", ".join(map(toml_value, value)) + "]"
    if isinstance(value, str):
        return json.dumps(value).replace("\x7f", "\\u007f")
    if isinstance(value, float) and not math.isfinite(value):
        raise ValueError(f"{value} cannot stand in a scenario file")
    return repr(value)
