"""Translated expressions, with what their use in C depends on."""

from dataclasses import dataclass
from typing import Any

from adaptive_ff.export.names import c_name
from adaptive_ff.export.types import Array, Line, Record, Scalar, Type

PRIMARY, UNARY, PRODUCT, SUM, ORDER, EQUALITY, CONJUNCTION, DISJUNCTION, CHOICE = 99, 14, 12, 11, 9, 8, 4, 3, 2
"""How tightly operators of C bind."""


@dataclass(frozen=True)
class Value:
    """An expression in C.

    Attributes
    ----------
    text : str
        The expression.
    type : Type, optional
        Its type; none for tuples of constants and for shapes, which have no value in C.
    rank : int
        How tightly its outermost operator binds.
    constant : object
        Its value where that is known at translation.
    root : str
        Variable that it is a part of; empty where it is no place in memory.
    pointer : bool
        Whether the text is a pointer to the value.
    """

    text: str
    type: Type | None
    rank: int = PRIMARY
    constant: Any = None
    root: str = ""
    pointer: bool = False

    def within(self, rank: int) -> str:
        """Return the text, in parentheses where an operator around it binds more tightly."""
        return f"({self.text})" if self.rank < rank else self.text

    @property
    def content(self) -> str:
        """Return the text of the value itself."""
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
        if isinstance(kind, Scalar):
            kind, constant = Scalar(kind.kind), kind.value
        text = f"{self.within(PRIMARY)}{'->' if self.pointer else '.'}{c_name(name)}"
        return Value(text, kind, constant=constant, root=self.root)

    def element(self, index: str) -> "Value":
        """Return an element of a tuple, or of an array, whose element may be a row."""
        if isinstance(self.type, Line):
            text = f"{self.within(PRIMARY)}{'->' if self.pointer else '.'}at[{index}]"
            return Value(text, self.type.element, root=self.root)
        rest = self.array.shape[1:]
        kind = Array(self.array.element, rest) if rest else self.array.element
        return Value(f"{self.within(PRIMARY)}[{index}]", kind, root=self.root)
