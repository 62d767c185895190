"""Translated expressions, with what their use in C depends on."""

from dataclasses import dataclass, replace
from typing import Any

from controllers.kernels.literals import c_name
from controllers.kernels.types import INTEGER, Array, Line, Record, Scalar, Type

PRIMARY, UNARY, PRODUCT, SUM, ORDER, EQUALITY, CONJUNCTION, DISJUNCTION, CHOICE = 99, 14, 12, 11, 9, 8, 4, 3, 2
"""How tightly operators of C bind."""


@dataclass(frozen=True)
class Value:
    """An expression in C."""

    text: str  # the expression; of a part of an array of open sizes, the array
    type: Type | None  # none for tuples of constants and for shapes, which have no value in C
    rank: int = PRIMARY  # how tightly its outermost operator binds
    constant: Any = None  # its value where that is known at translation
    root: str = ""  # variable that it is a part of; empty where it is no place in memory
    pointer: bool = False  # whether the text is a pointer to the value
    natural: bool = False  # whether it is an integer that is known not to be negative
    part: str = ""  # of an array of open sizes: number of the row that it is, of all rows; empty for the whole
    axes: int = 0  # how many axes of the array that row has behind it

    def within(self, rank: int) -> str:
        """Return the text, in parentheses where an operator around it binds more tightly."""
        return f"({self.text})" if self.rank < rank else self.text

    @property
    def content(self) -> str:
        """Return the text of the value itself."""
        if self.part:
            owner, kind = self.within(PRIMARY), self.array
            sizes = [f"{owner}.size{self.axes + axis}" for axis in range(len(kind.shape))]
            start = f"{owner}.data + {' * '.join([self.part, *sizes])}"
            return f"({open_name(kind)}){{{', '.join([start, *sizes])}}}"
        return f"*{self.text}" if self.pointer else self.text

    @property
    def array(self) -> Array:
        """Type of an array."""
        if not isinstance(self.type, Array):
            raise TypeError(f"{self.text} is no array")
        return self.type

    def member(self, name: str) -> "Value":
        """Return a field of a record; ``KeyError`` where there is none."""
        if not isinstance(self.type, Record):
            raise TypeError(f"{self.text} has no fields")
        kind, constant = self.type.field(name), None
        if isinstance(kind, Scalar) and kind.value is not None:
            kind, constant = Scalar(kind.kind), kind.value
        text = f"{self.within(PRIMARY)}{'->' if self.pointer else '.'}{c_name(name)}"
        natural = kind == INTEGER and constant is not None and constant >= 0
        return Value(text, kind, constant=constant, root=self.root, natural=natural)

    def size(self, axis: int) -> "Value":
        """Return how many elements an array has along an axis."""
        extent = self.array.shape[axis]
        if extent is None:
            return Value(f"{self.within(PRIMARY)}.size{self.axes + axis}", INTEGER, natural=True)
        return Value(str(extent), INTEGER, constant=extent, natural=True)

    def element(self, index: str) -> "Value":
        """Return an element of a tuple, or of an array, whose element may be a row."""
        if isinstance(self.type, Line):
            text = f"{self.within(PRIMARY)}{'->' if self.pointer else '.'}at[{index}]"
            return Value(text, self.type.element, root=self.root)
        rest = self.array.shape[1:]
        kind = Array(self.array.element, rest) if rest else self.array.element
        if not self.array.is_open:
            return Value(f"{self.within(PRIMARY)}[{index}]", kind, root=self.root)
        owner = self.within(PRIMARY)
        place = f"{self.part} * {owner}.size{self.axes} + {index}" if self.part else index
        if not rest:
            return Value(f"{owner}.data[{place}]", kind, root=self.root)
        simple = place.isidentifier() or place.isdigit()
        return replace(self, type=kind, part=place if simple else f"({place})", axes=self.axes + 1, constant=None)


def open_name(kind: Array) -> str:
    """Return the name of the struct of arrays whose sizes are known at run time: address and sizes, as in numpy."""
    return f"{kind.element.kind.capitalize()}Array{len(kind.shape)}"
