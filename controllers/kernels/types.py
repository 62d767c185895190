"""Types of the values in kernels, inferred from samples of them, and the symbols that the kernels of a unit share."""

import math
from dataclasses import dataclass
from functools import cache, cached_property
from typing import Any

import numpy as np

from controllers.kernels.language import NotTranslatable
from controllers.kernels.sources import Constant, identity


@dataclass(frozen=True)
class Scalar:
    """A number or a truth value; ``kind`` is ``real``, ``integer`` or ``boolean``.

    Numbers and truth values of firmware's parameters have their value with them: they decide which branches there are.
    """

    kind: str
    value: float | None = None


REAL, INTEGER, BOOLEAN = Scalar("real"), Scalar("integer"), Scalar("boolean")


@dataclass(frozen=True)
class Array:
    """An array, held elsewhere: what stands for it refers to its elements, as in Python.

    Its sizes are numbers where they are part of the type, as in firmware; else None, and known at run time.
    """

    element: Scalar
    shape: tuple[int | None, ...]

    @property
    def is_open(self) -> bool:
        """Whether its sizes are known at run time alone."""
        return None in self.shape

    @property
    def row(self) -> "Scalar | Array":
        """Type of what an index takes out of it."""
        return Array(self.element, self.shape[1:]) if len(self.shape) > 1 else self.element


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

    @cached_property
    def _hash(self) -> int:
        return hash((self.name, self.fields, self.origin))

    def __hash__(self) -> int:
        return self._hash

    def __reduce__(self) -> tuple[Any, ...]:
        return Record, (self.name, self.fields, self.origin)  # a hash holds for one process

    @cached_property
    def _by_name(self) -> dict[str, "Type"]:
        return dict(self.fields)

    def field(self, name: str) -> "Type":
        """Return the type of a field; ``KeyError`` where there is none."""
        return self._by_name[name]


Type = Scalar | Array | Line | Record

ELEMENTS = {np.dtype(np.float64): REAL, np.dtype(np.int64): INTEGER, np.dtype(np.bool_): BOOLEAN}
"""Scalar type of the elements of each type of arrays."""

LARGEST_BY_VALUE = 4
"""Records and tuples of more members than this are passed by ``const`` pointer."""


def is_within_word(number: int) -> bool:
    """Tell whether an integer has 64 bits with its sign."""
    return -(2**63) <= number < 2**63


def makes_itself(origin: Any) -> bool:
    """Tell whether a class of named tuples makes something else of its fields by a ``__new__`` of its own."""
    maker = next(each for each in origin.__mro__ if "__new__" in vars(each))
    return "_fields" not in vars(maker)


def type_of(value: Any, where: str = "", *, sizes: bool = False, values: bool = False) -> Type:
    """Return the type of a sample value, with the sizes of its arrays and the values of its numbers where wanted."""
    if isinstance(value, bool | np.bool_):
        return Scalar(BOOLEAN.kind, bool(value) if values else None)
    if isinstance(value, int | np.integer) and is_within_word(int(value)):
        return Scalar(INTEGER.kind, int(value) if values else None)
    if isinstance(value, float):
        return Scalar(REAL.kind, float(value) if values and not math.isnan(value) else None)
    if isinstance(value, np.ndarray) and value.ndim and value.dtype in ELEMENTS:
        if value.flags.c_contiguous and value.flags.aligned:
            return Array(ELEMENTS[value.dtype], value.shape if sizes else (None,) * value.ndim)
    elif isinstance(value, tuple) and hasattr(value, "_fields") and not makes_itself(type(value)):
        places = [(name, f"{where}.{name}" if where else name) for name in value._fields]
        items = zip(places, value, strict=True)
        fields = ((name, type_of(item, place, sizes=sizes, values=values)) for (name, place), item in items)
        return Record(type(value).__name__, tuple(fields), type(value))
    elif isinstance(value, tuple) and not hasattr(value, "_fields"):
        elements = {type_of(item, f"{where}[{k}]", sizes=sizes) for k, item in enumerate(value)}
        if len(elements) == 1:
            return Line(elements.pop(), len(value))
    raise NotTranslatable(_refused(value, where))


def _refused(value: Any, where: str) -> str:
    given = f"{where}: {value!r}" if where else repr(value)
    if isinstance(value, int | np.integer):
        return f"{given} is beyond the 64 bits that integers have in kernels; give a real number"
    if isinstance(value, np.ndarray) and value.ndim == 0:
        return f"{given} is an array without dimensions, which kernels do not take; give the number"
    if isinstance(value, tuple) and hasattr(value, "_fields"):
        return f"{given} is of a class with a __new__ of its own; kernels take plain named tuples"
    allowed = "contiguous arrays of float64, int64 or bool, named tuples, and tuples of values of one type"
    given = f"{where} = {value!r}" if where else repr(value)
    return f"{given} is not allowed in kernels: they take numbers, {allowed}"


@cache
def members(kind: Type) -> int:
    """Return how many scalars and pointers a value of a type holds."""
    if isinstance(kind, Record):
        return sum(members(field) for _, field in kind.fields)
    if isinstance(kind, Line):
        return kind.length * members(kind.element)
    return 1


def passed_by_pointer(kind: Type | None) -> bool:
    """Tell whether arguments of a type are passed by ``const`` pointer."""
    return isinstance(kind, Record | Line) and members(kind) > LARGEST_BY_VALUE


def sample_of(kind: Type | None) -> Any:
    """Return a value of a type; None for nothing."""
    if isinstance(kind, Record):
        items = [sample_of(field) for _, field in kind.fields]
        return kind.origin(*items) if kind.origin else tuple(items)
    if isinstance(kind, Line):
        return (sample_of(kind.element),) * kind.length
    if isinstance(kind, Array):
        known = {element: numbers for numbers, element in ELEMENTS.items()}
        return np.zeros((0,) * len(kind.shape), known[kind.element])
    return None if kind is None else {REAL: 0.0, INTEGER: 0, BOOLEAN: False}[Scalar(kind.kind)]


def text_of(kind: Type | None) -> str:
    """Return a type as a text that is the same in every process."""
    if kind is None:
        return "-"
    if isinstance(kind, Scalar):
        return kind.kind[0]
    if isinstance(kind, Array):
        return f"{kind.element.kind[0]}[{len(kind.shape)}]"
    if isinstance(kind, Line):
        return f"{text_of(kind.element)}x{kind.length}"
    name = identity(kind.origin) if kind.origin else ""
    return f"{name}({','.join(text_of(field) for _, field in kind.fields)})"


class Symbols:
    """Notes the symbols of kernels as these are read, for this machine or ``fixed``, for firmware."""

    def __init__(self, *, fixed: bool) -> None:
        self.fixed = fixed
        self.constants: dict[str, Constant] = {}
        self.types: list[Record | Line | Array] = []  # met since a function was printed

    def note(self, kind: Type) -> None:
        """Note that a type is used: structs stand in the order in which they are met."""
        if not isinstance(kind, Scalar) and (not isinstance(kind, Array) or kind.is_open):
            self.types.append(kind)

    def constant_name(self, constant: Constant) -> str:
        """Return the name of a constant, and note that it is used."""
        name, count = constant.name, 1
        while self.constants.setdefault(name, constant).value != constant.value:
            if self.fixed:
                values = f"{self.constants[name].value} and {constant.value}"
                raise NotTranslatable(f"{name} names two constants, {values}; rename one")
            count += 1
            name = f"{constant.name}_{count}"
        return name
