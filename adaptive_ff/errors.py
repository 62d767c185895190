"""The error that a user's input causes, as one sentence."""

from collections.abc import Mapping
from typing import Any

from pydantic import BaseModel, ValidationError


class InputError(ValueError):
    """A scenario, a file or an option is wrong; the message is one line that names what and what is allowed."""


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
    path = [part for part in first["loc"] if part not in ("multisine", "csv")]
    name = ".".join(str(part) for part in path)
    message = first["msg"].removeprefix("Value error, ")
    shown = repr(first["input"])
    value = shown if len(shown) <= 60 else shown[:57] + "..."
    if first["type"] == "missing":
        text = f"{name} is missing; it must be given"
    elif first["type"] == "extra_forbidden":
        known = ", ".join(_known_fields(model, path[:-1]))
        text = f"{name} = {value} is not known; allowed there: {known}"
    elif first["type"] == "value_error":
        text = f"{name}: {message}" if name else message
    else:
        text = f"{name} = {value} is not allowed: {_rule(message, first.get('ctx'))}"
    more = len(findings) - 1
    return " ".join(text.split()) + (f" (and {more} more)" if more else "")


def _rule(message: str, context: Mapping[str, Any] | None) -> str:
    rule = message[0].lower() + message[1:]
    rule = rule.replace("input should", "it must").replace("be a valid number", "be a number")
    return rule if context is None else rule.replace("greater than 0", "positive")


def _known_fields(model: type[BaseModel], path: list[Any]) -> list[str]:
    for part in path:
        if isinstance(part, int):
            continue
        field = model.model_fields.get(part)
        found = _models_in(field.annotation) if field is not None else []
        if not found:
            return []
        if len(found) > 1:
            return sorted({name for kind in found for name in kind.model_fields})
        model = found[0]
    return list(model.model_fields)


def _models_in(annotation: Any) -> list[type[BaseModel]]:
    if isinstance(annotation, type) and issubclass(annotation, BaseModel):
        return [annotation]
    return [model for part in getattr(annotation, "__args__", ()) for model in _models_in(part)]
