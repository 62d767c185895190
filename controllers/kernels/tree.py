"""A kernel as a typed tree: what is computed of what, which variables hold it, in which order.

Names are those of C; how operators bind, what is a pointer and how numbers look is left to the printer.
"""

from collections.abc import Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any, NamedTuple

from controllers.kernels.sources import Kernel
from controllers.kernels.types import BOOLEAN, INTEGER, REAL, Array, Line, Record, Scalar, Type


@dataclass(eq=False)
class Variable:
    """A local variable or an argument."""

    name: str  # its name in C
    type: Type | None  # none before its first value is met
    constant: float | None = None  # its value, where that is a number that is known at translation
    natural: bool = False  # whether it is an integer that is known not to be negative
    is_pointer: bool = False  # whether it is a pointer to a record that stays as it is
    is_int: bool = False  # whether it counts a loop of firmware, in the machine's own integers

    @property
    def value(self) -> "Node":
        """The variable as an expression."""
        return Node("variable", self.type, (), "", self.constant, self.natural, self)


@dataclass(frozen=True, eq=False)
class Node:
    """An expression: a number, constant, variable, field, element, size, operator, cast, call, choice, or a tuple."""

    kind: str
    type: Type | None  # none for shapes, which have no value in C, and for calls that give nothing
    parts: tuple["Node", ...] = ()
    name: str = ""  # of the constant, field, axis, operator or function; beside a number, where it stands
    constant: Any = None  # its value where that is known at translation
    natural: bool = False  # whether it is an integer that is known not to be negative
    variable: Variable | None = None

    @property
    def root(self) -> Variable | None:
        """The variable that it is, or is a part of; none where it is no place in memory."""
        return self.parts[0].root if self.kind in ("field", "element") else self.variable

    @property
    def array(self) -> Array:
        """Type of an array."""
        assert isinstance(self.type, Array)
        return self.type

    def member(self, name: str) -> "Node":
        """Return a field of a record; ``KeyError`` where there is none."""
        if not isinstance(self.type, Record):
            raise KeyError(name)
        kind, constant = self.type.field(name), None
        if isinstance(kind, Scalar) and kind.value is not None:
            kind, constant = Scalar(kind.kind), kind.value
        natural = kind == INTEGER and constant is not None and constant >= 0
        return Node("field", kind, (self,), name, constant, natural)

    @property
    def items(self) -> list["Node"]:
        """Fields of a record, elements of a tuple, sizes of a shape."""
        if isinstance(self.type, Record):
            return [self.member(name) for name, _ in self.type.fields]
        if isinstance(self.type, Line):
            return [self.element(number(place)) for place in range(self.type.length)]
        return list(self.parts)

    def size(self, axis: int) -> "Node":
        """Return how many elements an array has along an axis."""
        extent = self.array.shape[axis]
        return Node("size", INTEGER, (self,), str(axis), natural=True) if extent is None else number(extent)

    def element(self, index: "Node") -> "Node":
        """Return an element of a tuple, or of an array, whose element may be a row."""
        kind = self.type.element if isinstance(self.type, Line) else self.array.row
        return Node("element", kind, (self, index))


def number(value: bool | int | float, where: str = "") -> Node:
    """Return a number that is known."""
    if isinstance(value, bool):
        return Node("number", BOOLEAN, constant=value)
    if isinstance(value, int):
        return Node("number", INTEGER, constant=int(value), natural=value >= 0)
    return Node("number", REAL, name=where, constant=float(value))


class Let(NamedTuple):
    """A variable, and its first value where that is known when it is declared."""

    variable: Variable
    value: Node | None = None
    is_constant: bool = False  # whether that is its only value


class Give(NamedTuple):
    """Another value for a variable or an element."""

    place: Node
    value: Node
    sign: str = ""  # operator before the sign of equality


class Do(NamedTuple):
    """A call, or the end of the function and what that gives."""

    value: Node
    word: str = ""


class If(NamedTuple):
    """A branch."""

    test: Node
    body: list["Statement"]
    orelse: list["Statement"]


class For(NamedTuple):
    """A loop over a range by 1 or -1."""

    counter: Variable
    start: Node
    end: Node
    stride: int
    body: list["Statement"]


class While(NamedTuple):
    """A loop as long as something holds."""

    test: Node
    body: list["Statement"]


Statement = Let | Give | Do | If | For | While | str
"""What a function does; a text is a line of C as it is: a comment, ``break``, ``continue``."""


@dataclass(frozen=True)
class Function:
    """A kernel for arguments of some types."""

    name: str  # its name in C
    kernel: Kernel  # what it was read from
    arguments: list[Variable]
    result: Type | None  # what it returns; none for one that changes arrays in place only
    body: list[Statement]
    writes: bool  # whether it changes arrays in place
    constant: int | None = None  # what it returns, where that is an integer or truth value that is known at translation
    natural: bool = False  # whether what it returns is known to be not negative
    text: str = ""  # its definition in C with its comment
    files: frozenset[Path] = frozenset()  # files of it and of what it calls
    meanings: Mapping[tuple[str, str], str] = field(default_factory=dict)  # what the global names in these stand for
