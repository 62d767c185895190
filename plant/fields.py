"""Numbers that a joint is made of and stepped with, and the base of a scenario's tables, whose help can be read."""

import inspect
import math
import re
import reprlib
import textwrap
from collections.abc import Callable
from functools import cache
from itertools import groupby
from types import UnionType
from typing import TYPE_CHECKING, Annotated, Any, Literal, Union, get_args, get_origin

from pydantic import BaseModel, ConfigDict, Field

if TYPE_CHECKING:
    from pydantic._internal._model_construction import ModelMetaclass
else:
    ModelMetaclass = type(BaseModel)  # it has no public name

Positive = Annotated[float, Field(gt=0.0, allow_inf_nan=False, strict=True)]
NonNegative = Annotated[float, Field(ge=0.0, allow_inf_nan=False, strict=True)]
Finite = Annotated[float, Field(allow_inf_nan=False, strict=True)]

LINE = re.compile(r"^(?: {4}(?:(\w+): [^#\n]*?)?(?: *# (.*))?|.*)$", re.MULTILINE)
"""A line of a table: name and comment of a field, of which one or both may be missing."""


def check_numbers(**values: Any) -> None:
    """Raise ``TypeError`` for the first value that is no number, ``ValueError`` for one that no ``float`` can hold."""
    for name, value in values.items():
        try:
            math.isfinite(value)
        except TypeError:
            raise TypeError(f"{name} = {reprlib.repr(value)} is not allowed: it must be a number") from None
        except OverflowError:  # a whole number of hundreds of digits
            raise ValueError(f"{name} = {reprlib.repr(value)} is not allowed: its size must be below 1e308") from None


def check_finite(name: str, value: float, unit: str) -> None:
    """Raise ``ValueError`` for a value that is not finite, ``TypeError`` for no number."""
    check_numbers(**{name: value})
    if not math.isfinite(value):
        raise ValueError(f"{name} = {value} is not allowed: it must be a finite number of {unit}")


def check_period(name: str, value: float) -> None:
    """Raise ``ValueError`` for a period that is not positive and finite, ``TypeError`` for no number."""
    check_numbers(**{name: value})
    if not 0.0 < value < math.inf:
        raise ValueError(f"{name} = {value} is not allowed: it must be positive and finite")


class _Shown(str):
    """A text that a signature shows as it is, without quotes."""

    def __repr__(self) -> str:
        return str(self)


class _Quiet(ModelMetaclass):
    """Shows of a table what is its own: pydantic's machinery works as ever, but drowns no ``help()``."""

    @property
    def __doc__(cls) -> str:  # type: ignore[override]
        """What a table is, and its fields: each is described by the comment beside or above it."""
        return _documented(cls)

    def __dir__(cls) -> list[str]:
        hidden = {*dir(BaseModel), "model_config"}
        return [name for name in super().__dir__() if name not in hidden and not name.startswith("_")]


class Table(BaseModel, metaclass=_Quiet):
    """A table of a scenario: its fields are checked when it is made, and cannot be changed afterwards."""

    model_config = ConfigDict(frozen=True, extra="forbid")

    @classmethod
    def __pydantic_init_subclass__(cls, **kwargs: Any) -> None:
        """Give a table a signature with the plain names of types; ranges are stated where a value is refused."""
        cls.__signature__ = _signature(cls)

    def __dir__(self) -> list[str]:
        """Return the names of the fields and of what is computed from them."""
        return sorted({*dir(type(self)), *type(self).model_fields})


@cache
def _documented(table: type[BaseModel]) -> str:
    """Return the docstring of a table, or of its base, with a section of its own fields, or of those of its base."""
    own = next((found for base in table.__mro__ if (found := vars(base).get("__doc__"))), "")
    text, heading, rest = inspect.cleandoc(own).strip().partition("\n\nRaises\n")
    said = next((found for base in table.__mro__ if (found := _described(base))), {})
    lines = ["", "Parameters", "----------"] if said else []
    for meaning, group in groupby(said, said.__getitem__):
        fields = {name: table.model_fields[name] for name in group}
        kinds = ", ".join(dict.fromkeys(_name(field.annotation).removesuffix(" | None") for field in fields.values()))
        optional = "" if any(field.is_required() for field in fields.values()) else ", optional"
        lines += [f"{', '.join(fields)} : {kinds}{optional}", *(f"    {one}" for one in textwrap.wrap(meaning, 108))]
    return "\n".join([text, *lines]) + heading + rest


def _described(table: Any) -> dict[str, str]:
    """Return the comments of a table's fields: each its own, else the one above the group that it stands in."""
    try:
        lines = LINE.findall(inspect.getsource(table)) if issubclass(table, Table) else []
    except (OSError, TypeError):  # its source is not at hand
        return {}
    found: dict[str, str] = {}
    said, is_open = "", False
    for name, note in lines:
        if name:
            meaning, said, is_open = note or said, "" if note else said, False
            if meaning and name in table.model_fields:
                found[name] = f"{meaning[0].upper()}{meaning[1:]}{'' if meaning.endswith('.') else '.'}"
        else:
            said, is_open = f"{said} {note}" if note and is_open else note, bool(note)
    return found


def _signature(table: type[BaseModel]) -> inspect.Signature:
    return inspect.Signature(
        [
            inspect.Parameter(
                name,
                inspect.Parameter.KEYWORD_ONLY,
                default=inspect.Parameter.empty if field.is_required() else _Shown(_default(field.get_default())),
                annotation=_Shown(_name(field.annotation)),
            )
            for name, field in table.model_fields.items()
        ]
    )


def _default(value: Any) -> str:
    return f"{type(value).__name__}()" if isinstance(value, BaseModel) else repr(value)


def _name(kind: Any) -> str:
    """Return a type as people write it: without modules, ranges and discriminators."""
    origin, parts = get_origin(kind), get_args(kind)
    if origin is Annotated:
        return _name(parts[0])
    if origin in (Union, UnionType):
        return " | ".join(dict.fromkeys(map(_name, parts)))
    if origin is Literal:
        return " | ".join(map(repr, parts))
    if origin is not None and origin is not Callable:
        return f"{origin.__name__}[{', '.join(map(_name, parts))}]"
    return "None" if kind is type(None) else getattr(kind, "__name__", str(kind))


class StrictTable(Table):
    """A table whose fields take values of their own types alone."""

    model_config = ConfigDict(strict=True)
