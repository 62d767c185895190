"""Nested named tuples of numbers and arrays: as flat lists, and in memory as compiled code lays them out.

A controller's parameters and state are read and written by its compiled kernels at fixed addresses, so that neither
has to be made anew at each call. The layout is that of a struct in C: numbers at their natural alignment, a named tuple
as a struct within the struct, an array as a pointer to the memory that the numpy array owns, and its shape.
"""

import struct
from collections.abc import Hashable, Iterator
from dataclasses import dataclass
from typing import Any

import numpy as np

from controllers.kernels.text import c_name
from controllers.kernels.types import Array, Line, Record, Scalar, Type

NUMBERS = {"d": np.dtype(np.float64), "q": np.dtype(np.int64), "?": np.dtype(np.bool_)}
"""Types of numbers, by the names that the module ``struct`` has for them."""

POINTER = np.dtype(np.intp)


class Memory:
    """One nested named tuple in memory."""

    def __init__(self, value: Any, kind: Hashable = None) -> None:
        self._allocate(value, structure(value) if kind is None else kind)
        self.value = value

    @classmethod
    def like(cls, sample: Any, kind: Hashable) -> "Memory":
        """Return memory for a value like a sample, of a known :func:`structure`; it holds zeros."""
        memory = cls.__new__(cls)
        memory._allocate(sample, kind)
        memory._template, memory._arrays = sample, {}
        return memory

    def _allocate(self, value: Any, kind: Hashable) -> None:
        size, self._format = _form(value, kind)
        self._buffer: Any = np.zeros(max(size, 1) // 8 + 1)
        self.address = int(self._buffer.ctypes.data)

    @property
    def value(self) -> Any:
        """What it holds now; its arrays are those that it was given."""
        return _rebuilt(self._template, iter(self._format.unpack_from(self._buffer)), self._arrays)

    @value.setter
    def value(self, value: Any) -> None:
        self._template = value  # keeps the arrays alive, too
        words: list[Any] = []
        self._arrays: dict[tuple[int, ...], np.ndarray[Any, Any]] = {}
        _spread(value if isinstance(value, tuple) else (value,), words, self._arrays)
        try:
            self._format.pack_into(self._buffer, 0, *words)
        except struct.error:
            beyond = [word for word in words if isinstance(word, int) and not -(2**63) <= word < 2**63]
            raise TypeError(f"{beyond} are beyond the 64 bits of integers in compiled code") from None

    def value_with_arrays_of(self, other: "Memory") -> Any:
        """Return what it holds now, whose arrays are those of another memory."""
        return _rebuilt(self._template, iter(self._format.unpack_from(self._buffer)), other._arrays)


NESTED = (tuple, np.ndarray)
"""What is no number; a number is not worth a call of its own."""


def structure(value: Any) -> Hashable:
    """Return what the layout of a value and its types in compiled code depend on, not its numbers."""
    if isinstance(value, tuple):
        return (type(value), *[structure(item) if isinstance(item, NESTED) else type(item) for item in value])
    if isinstance(value, np.ndarray):
        return (value.dtype, value.ndim, value.flags.num)
    return (type(value),)


_FORMS: dict[Hashable, tuple[int, struct.Struct]] = {}


def _form(value: Any, kind: Hashable) -> tuple[int, struct.Struct]:
    """Return size (bytes) and format of a value, found once for a structure."""
    if kind not in _FORMS:
        layout = struct.Struct("@" + _format(value))
        _FORMS[kind] = layout.size, layout
    return _FORMS[kind]


def record_type(value: Any) -> np.dtype[Any]:
    """Return the layout of a value as the type of a numpy record."""
    if isinstance(value, tuple):
        fields = [(f"f{place}", record_type(item)) for place, item in enumerate(value)]
        return np.dtype(fields, align=True)
    if isinstance(value, np.ndarray):
        return np.dtype([("array", POINTER, (1 + value.ndim,))], align=True)
    return NUMBERS[_number(value)]


def _number(value: Any) -> str:
    for name, kind in NUMBERS.items():
        if np.ndim(value) == 0 and np.asarray(value).dtype == kind:
            return name
    raise TypeError(f"{value!r} of {type(value).__name__} is not allowed: compiled code takes numbers and arrays")


def _format(value: Any) -> str:
    """Return the format of a value for the module ``struct``; a tuple begins and ends where its widest number may."""
    if isinstance(value, tuple):
        inner = "".join(map(_format, value))
        edge = "0q" if inner.strip("?") else ""
        return edge + inner + edge
    return "q" * (1 + value.ndim) if isinstance(value, np.ndarray) else _number(value)


def _spread(values: tuple[Any, ...], words: list[Any], arrays: dict[tuple[int, ...], np.ndarray[Any, Any]]) -> None:
    """Append numbers, and places and shapes of arrays, in order; collect the arrays by these."""
    for item in values:
        if isinstance(item, tuple):
            _spread(item, words, arrays)
        elif isinstance(item, np.ndarray):
            place = (item.ctypes.data, *item.shape)
            words += place
            arrays[place] = item
        else:
            words.append(item)


def _rebuilt(template: Any, words: Iterator[Any], arrays: dict[tuple[int, ...], Any]) -> Any:
    if isinstance(template, tuple):
        items = [_rebuilt(item, words, arrays) if isinstance(item, NESTED) else next(words) for item in template]
        return type(template)(*items) if hasattr(template, "_fields") else tuple(items)
    if isinstance(template, np.ndarray):
        return arrays[tuple(next(words) for _ in range(1 + template.ndim))]
    return next(words)


@dataclass(frozen=True)
class Leaf:
    """A number, or an array of numbers, in a nested named tuple."""

    path: tuple[str | int, ...]  # names of the fields, and places in tuples, that lead to it
    kind: Scalar  # what it holds
    shape: tuple[int, ...] = ()  # shape of the array; empty for a number
    is_array: bool = False  # whether it is an array

    @property
    def count(self) -> int:
        """How many numbers it holds."""
        return int(np.prod(self.shape, dtype=int))

    @property
    def member(self) -> str:
        """Its place within a struct in C."""
        text = "".join(f".at[{step}]" if isinstance(step, int) else f".{c_name(step)}" for step in self.path)
        return text.removeprefix(".")

    @property
    def storage(self) -> str:
        """Name of the array that holds its numbers."""
        return "_".join(str(step) for step in self.path)


def leaves(kind: Type, path: tuple[str | int, ...] = ()) -> Iterator[Leaf]:
    """Yield all numbers and arrays of a type in their order."""
    if isinstance(kind, Record):
        for name, field in kind.fields:
            yield from leaves(field, (*path, name))
    elif isinstance(kind, Line):
        for place in range(kind.length):
            yield from leaves(kind.element, (*path, place))
    elif isinstance(kind, Array):
        yield Leaf(path, kind.element, tuple(extent for extent in kind.shape if extent is not None), True)
    else:
        yield Leaf(path, Scalar(kind.kind))


def value_at(value: Any, path: tuple[str | int, ...]) -> Any:
    """Return what stands at a place in a nested named tuple."""
    for step in path:
        value = value[step] if isinstance(step, int) else getattr(value, step)
    return value


def rebuilt(template: Any, values: Iterator[Any]) -> Any:
    """Return a nested named tuple like a template with other numbers, in the order of its leaves."""
    if isinstance(template, tuple):
        items = [rebuilt(item, values) for item in template]
        return type(template)(*items) if hasattr(template, "_fields") else tuple(items)
    value = next(values)
    if isinstance(template, np.ndarray):
        return np.array(value, dtype=template.dtype).reshape(template.shape)
    return type(template)(value)
