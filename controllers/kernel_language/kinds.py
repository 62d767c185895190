"""Types of the values in kernels, and how they lie in memory: as a struct of C would."""

from functools import cache
from typing import Any

import numpy as np
from llvmlite import ir

BIT, BYTE, WORD, DOUBLE = ir.IntType(1), ir.IntType(8), ir.IntType(64), ir.DoubleType()
ADDRESS = BYTE.as_pointer()


class Kind:
    """A type. There is one object for each, so that types are compared by identity.

    Attributes
    ----------
    memory : llvmlite type
        What it is in memory.
    size, alignment : int
        Bytes that it takes, and of which its place is a multiple.
    """

    memory: Any
    size: int
    alignment: int


class Scalar(Kind):
    """A number or a truth value.

    Parameters
    ----------
    name : str
        What errors call it.
    register, memory : llvmlite type
        What it is in a register and in memory.
    size : int
        Bytes that it takes in memory.
    """

    def __init__(self, name: str, register: Any, memory: Any, size: int) -> None:
        self.name, self.register, self.memory, self.size, self.alignment = name, register, memory, size, size

    def __repr__(self) -> str:
        return self.name


REAL = Scalar("a real number", DOUBLE, DOUBLE, 8)
INTEGER = Scalar("an integer", WORD, WORD, 8)
BOOLEAN = Scalar("a truth value", BIT, BYTE, 1)

ELEMENTS = {np.dtype(np.float64): REAL, np.dtype(np.int64): INTEGER, np.dtype(np.bool_): BOOLEAN}
"""Kinds of the elements of arrays."""


class Pointer(Kind):
    """An address at which numbers lie, how many is known elsewhere."""

    def __init__(self, element: Scalar) -> None:
        self.element = element
        self.memory = element.memory.as_pointer()
        self.size = self.alignment = 8

    def __repr__(self) -> str:
        return f"a pointer to {self.element}"


class Array(Kind):
    """An array that lies elsewhere: its address and its shape, in the order of C."""

    def __init__(self, element: Scalar, ndim: int) -> None:
        self.element, self.ndim = element, ndim
        self.parts = (element.memory.as_pointer(), *[WORD] * ndim)
        self.memory = ir.LiteralStructType(self.parts)
        self.size, self.alignment = 8 * (1 + ndim), 8

    def __repr__(self) -> str:
        return f"an array of {self.element} with {self.ndim} dimensions"


class Line(Kind):
    """A tuple of values of one kind."""

    def __init__(self, element: Kind, length: int) -> None:
        self.element, self.length = element, length
        self.memory = ir.ArrayType(element.memory, length)
        self.size, self.alignment = element.size * length, element.alignment

    def __repr__(self) -> str:
        return f"a tuple of {self.length} times {self.element}"


class Record(Kind):
    """A named tuple, or the several values that a function returns (then without a class).

    Attributes
    ----------
    origin : type, optional
        The class.
    kinds : tuple of Kind
        Kinds of its fields.
    places : dict
        Place of each field by its name.
    """

    def __init__(self, origin: Any, kinds: tuple[Kind, ...]) -> None:
        self.origin, self.kinds = origin, kinds
        self.places = {name: place for place, name in enumerate(origin._fields)} if origin else {}
        end, self.alignment = 0, 1
        for kind in kinds:
            end += -end % kind.alignment + kind.size
            self.alignment = max(self.alignment, kind.alignment)
        self.size = end + -end % self.alignment
        self.memory = ir.LiteralStructType([kind.memory for kind in kinds])

    def __repr__(self) -> str:
        if not self.origin:
            return f"({', '.join(map(repr, self.kinds))})"
        fields = ", ".join(f"{name}: {kind!r}" for name, kind in zip(self.origin._fields, self.kinds, strict=True))
        return f"{self.origin.__module__}.{self.origin.__qualname__}({fields})"


pointer_to = cache(Pointer)
array_of = cache(Array)
line_of = cache(Line)
record_of = cache(Record)


def tuple_of(kinds: tuple[Kind, ...]) -> Kind:
    """Return the kind of a tuple without a class."""
    return line_of(kinds[0], len(kinds)) if len(set(kinds)) == 1 else record_of(None, kinds)


def is_within_word(number: int) -> bool:
    """Tell whether an integer has 64 bits with its sign."""
    return -(2**63) <= number < 2**63


def makes_itself(origin: Any) -> bool:
    """Tell whether a class of named tuples makes something else of its fields by a ``__new__`` of its own."""
    maker = next(each for each in origin.__mro__ if "__new__" in vars(each))
    return "_fields" not in vars(maker)


def kind_of(value: Any) -> Kind:
    """Return the kind of a sample value.

    Raises
    ------
    TypeError
        It is neither a number, a contiguous array of double precision, int64 or bool, nor a tuple of such; or it is an
        integer beyond 64 bits, an array without dimensions, or of a class that makes something else of its fields.
    """
    if isinstance(value, bool | np.bool_):
        return BOOLEAN
    if isinstance(value, int | np.integer):
        if not is_within_word(int(value)):
            raise TypeError(f"{value} is beyond the 64 bits that integers have in kernels; give a real number")
        return INTEGER
    if isinstance(value, float):
        return REAL
    if isinstance(value, np.ndarray) and value.ndim == 0:
        raise TypeError(f"{value!r} is an array without dimensions, which kernels do not take; give the number")
    if isinstance(value, np.ndarray) and value.dtype in ELEMENTS and value.flags.c_contiguous and value.flags.aligned:
        return array_of(ELEMENTS[value.dtype], value.ndim)
    if isinstance(value, tuple):
        if hasattr(value, "_fields") and makes_itself(type(value)):
            raise TypeError(f"{value!r} is of a class with a __new__ of its own; kernels take plain named tuples")
        kinds = tuple(map(kind_of, value))
        return record_of(type(value), kinds) if hasattr(value, "_fields") else tuple_of(kinds)
    raise TypeError(f"{value!r} is not allowed in kernels: they take numbers, arrays of numbers and tuples of them")
