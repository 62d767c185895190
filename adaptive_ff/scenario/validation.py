"""Pydantic's findings as one line that names every wrong field, its value and what is allowed."""

from collections.abc import Mapping, Sequence
from difflib import get_close_matches
from typing import Any, get_args

from pydantic import BaseModel, ValidationError

MOST_SHOWN = 12  # most wrong fields that one line names


def explain(error: ValidationError, model: type[BaseModel]) -> str:
    """Turn pydantic's findings on a model into one line: what is missing, then what is wrong."""
    findings = error.errors(include_url=False)
    missing = [".".join(_resolve(model, one["loc"])[0]) for one in findings if one["type"] == "missing"]
    wrong = [_sentence(one, model) for one in findings if one["type"] != "missing"]
    if len(missing) == 1:
        wrong.insert(0, f"{missing[0]} is missing; it must be given")
    elif missing:
        wrong.insert(0, f"{_listed(missing)} are missing; they must be given")
    more = len(wrong) - MOST_SHOWN
    shown = wrong if more <= 0 else [*wrong[:MOST_SHOWN], f"and {more} more"]
    return " ".join("; ".join(shown).split())


def explain_option(name: str, error: ValidationError) -> str:
    """Turn what pydantic finds wrong with the value of an option, such as ``--runs``, into one line."""
    finding = error.errors(include_url=False)[0]
    value, message = finding["input"], finding["msg"].removeprefix("Value error, ")
    if finding["type"] == "value_error":  # the message names the value
        return f"{name}: {message.rstrip('.')}"
    message = message.partition(", unable to parse")[0]
    try:
        float(value)
    except (TypeError, ValueError):
        value = _shown(value)
    return f"{name} = {value} is not allowed: {_rule(finding['type'], message)}"


def _sentence(finding: Mapping[str, Any], model: type[BaseModel]) -> str:
    path, table, kinds = _resolve(model, finding["loc"])
    name, value, kind = ".".join(path), _shown(finding["input"]), finding["type"]
    message = finding["msg"].removeprefix("Value error, ")
    if kind == "extra_forbidden":
        near = get_close_matches(path[-1], table.model_fields, 1)
        hint = f"did you mean {near[0]}? " if near else ""
        return f"{name} = {value} is not known; {hint}allowed there: {', '.join(table.model_fields)}"
    if kind == "union_tag_not_found":
        return f"{name}.kind is missing; it must be {_alternatives(kinds)}"
    if kind == "union_tag_invalid":
        return f"{name}.kind = {_shown(finding['ctx']['tag'])} is not allowed: it must be {_alternatives(kinds)}"
    if kind == "value_error":
        return f"{name}: {message}" if name else message
    if kind == "list_type" and kinds:
        return f"{name} = {value} is not allowed: it must be a list of tables; in a file write [[{name}]]"
    return f"{name} = {value} is not allowed: {_rule(kind, message)}"


def _listed(names: Sequence[str]) -> str:
    *others, last = names[:MOST_SHOWN]
    more = f" and {len(names) - MOST_SHOWN} more" if len(names) > MOST_SHOWN else ""
    return f"{', '.join(others)}, {last}{more}" if more else f"{', '.join(others)} and {last}"


def _shown(value: Any) -> str:
    try:
        shown = repr(value)
    except (ValueError, RecursionError):  # thousands of digits or of levels
        return f"(a huge {type(value).__name__})"
    return shown if len(shown) <= 60 else shown[:57] + "..."


def _rule(kind: str, message: str) -> str:
    if kind in ("model_type", "model_attributes_type"):
        return "it must be a table"
    rule = message[0].lower() + message[1:]
    for beginning in ("input should", "list should", "string should"):
        rule = rule.replace(beginning, "it must")
    rule = rule.replace("be a valid number", "be a finite number").partition(" after validation")[0]
    return rule.replace("greater than 0", "positive")


def _alternatives(kinds: list[type[BaseModel]]) -> str:
    *others, last = (repr(tag) for kind in kinds for tag in _tags(kind))
    return f"{', '.join(others)} or {last}" if others else last


def _tags(kind: type[BaseModel]) -> tuple[Any, ...]:
    return get_args(kind.model_fields["kind"].annotation)


def _resolve(
    model: type[BaseModel], location: Sequence[str | int]
) -> tuple[list[str], type[BaseModel], list[type[BaseModel]]]:
    """Return the path of a field, the table that holds it and what it may be, where that is a table itself.

    In a location the kind of a table follows its name; it is no part of the path.
    """
    path: list[str] = []
    table, models = model, [model]
    for part in location:
        if len(models) > 1:
            models = [kind for kind in models if part in _tags(kind)]
            continue
        if not models and isinstance(part, str):  # which kind of a plain field was tried
            continue
        bare = str(part).replace("_", "").replace("-", "").isalnum()
        path.append(str(part) if bare else repr(part))
        if isinstance(part, str) and models:
            table = models[0]
            field = table.model_fields.get(part)
            models = [] if field is None else _models_in(field.annotation)
    return path, table, models


def _models_in(annotation: Any) -> list[type[BaseModel]]:
    if isinstance(annotation, type) and issubclass(annotation, BaseModel):
        return [annotation]
    return [model for part in getattr(annotation, "__args__", ()) for model in _models_in(part)]
