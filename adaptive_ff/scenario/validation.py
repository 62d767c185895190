"""Pydantic's findings as one sentence that names the field, its value and what is allowed."""

from collections.abc import Sequence
from typing import Any, get_args

from pydantic import BaseModel, ValidationError


def explain(error: ValidationError, model: type[BaseModel]) -> str:
    """Turn the first of pydantic's findings into one line.

    Parameters
    ----------
    error : pydantic.ValidationError
        What was found.
    model : type
        The model that was validated; for an unknown key its known ones are listed.
    """
    findings = error.errors(include_url=False)
    first = findings[0]
    path, table, kinds = _resolve(model, first["loc"])
    name, value = ".".join(path), _shown(first["input"])
    message = first["msg"].removeprefix("Value error, ")
    if first["type"] == "missing":
        text = f"{name} is missing; it must be given"
    elif first["type"] == "extra_forbidden":
        text = f"{name} = {value} is not known; allowed there: {', '.join(table.model_fields)}"
    elif first["type"] == "union_tag_not_found":
        text = f"{name}.kind is missing; it must be {_alternatives(kinds)}"
    elif first["type"] == "union_tag_invalid":
        text = f"{name}.kind = {_shown(first['ctx']['tag'])} is not allowed: it must be {_alternatives(kinds)}"
    elif first["type"] == "value_error":
        text = f"{name}: {message}" if name else message
    else:
        text = f"{name} = {value} is not allowed: {_rule(first['type'], message)}"
    more = len(findings) - 1
    return " ".join(text.split()) + (f" (and {more} more)" if more else "")


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
