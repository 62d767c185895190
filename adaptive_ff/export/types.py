"""Types of the values in kernels, inferred from samples of them: parameters, a state, inputs."""

from dataclasses import dataclass
from typing import Any

import numpy as np

from adaptive_ff.export.errors import NotExportable


@dataclass(frozen=True)
class Scalar:
    """A number or a truth value; ``kind`` is ``real``, ``integer`` or ``boolean``.

    Integers and truth values of parameters have their value with them: they decide which branches there are.
    """

    kind: str
    value: int | None = None


REAL, INTEGER, BOOLEAN = Scalar("real"), Scalar("integer"), Scalar("boolean")


@dataclass(frozen=True)
class Array:
    """An array of a fixed shape, held elsewhere: what refers to it is a pointer, as in Python."""

    element: Scalar
    shape: tuple[int, ...]


@dataclass(frozen=True)
class Line:
    """A tuple of values of one type, such as a delay line; a value, not a reference."""

    element: "Type"
    length: int


@dataclass(frozen=True)
class Record:
    """A named tuple, or the several values that a function returns (then without a class)."""

    name: str
    fields: tuple[tuple[str, "Type"], ...]
    origin: type | None = None

    def field(self, name: str) -> "Type":
        """Return the type of a field; ``KeyError`` where there is none."""
        return dict(self.fields)[name]


Type = Scalar | Array | Line | Record

KINDS = {"f": REAL, "i": INTEGER, "b": BOOLEAN}
"""Scalar type of each kind of array elements."""

LARGEST_BY_VALUE = 4
"""Records and tuples of more members than this are passed by ``const`` pointer."""


def type_of(value: Any, where: str, *, fixed: bool = False) -> Type:
    """Return the type of a sample value; where it is fixed, with the values of integers and truth values.

    Raises
    ------
    NotExportable
        The value is neither a number, an array, a named tuple nor a tuple of one type; ``where`` names it.
    """
    if isinstance(value, bool | np.bool_):
        return Scalar(BOOLEAN.kind, bool(value)) if fixed else BOOLEAN
    if isinstance(value, int | np.integer):
        return Scalar(INTEGER.kind, int(value)) if fixed else INTEGER
    if isinstance(value, float):
        return REAL
    if isinstance(value, np.ndarray) and value.dtype.kind in KINDS:
        return Array(KINDS[value.dtype.kind], value.shape)
    if isinstance(value, tuple) and hasattr(value, "_fields"):
        names = type(value)._fields
        fields = tuple(
            (name, type_of(item, f"{where}.{name}", fixed=fixed)) for name, item in zip(names, value, strict=True)
        )
        return Record(type(value).__name__, fields, type(value))
    if isinstance(value, tuple) and value:
        elements = {type_of(item, f"{where}[{place}]") for place, item in enumerate(value)}
        if len(elements) == 1:
            return Line(elements.pop(), len(value))
    raise NotExportable(
        f"{where} = {value!r} cannot be exported: it must be a float, an int, a bool, an array of numbers, "
        "a NamedTuple of such, or a tuple of values of one type"
    )


def members(kind: Type) -> int:
    """Return how many scalars and pointers a value of a type holds."""
    if isinstance(kind, Record):
        return sum(members(field) for _, field in kind.fields)
    if isinstance(kind, Line):
        return kind.length * members(kind.element)
    return 1


def passed_by_pointer(kind: Type) -> bool:
    """Tell whether arguments of a type are passed by ``const`` pointer."""
    return isinstance(kind, Record | Line) and members(kind) > LARGEST_BY_VALUE
