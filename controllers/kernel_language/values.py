"""Values of expressions while a kernel is translated."""

from dataclasses import dataclass
from typing import Any

from llvmlite import ir

from controllers.kernel_language.kinds import BOOLEAN, INTEGER, REAL, Kind


@dataclass(frozen=True)
class Value:
    """A value.

    Attributes
    ----------
    kind : Kind, optional
        Its kind; none for a shape, for a tuple of constants, and for what a kernel returns that returns nothing.
    content : object
        The register of a number or truth value, the address of a record or tuple, address and sizes of an array, or
        the sizes that make a shape.
    constant : object
        What it is, where that is known at translation: an integer, a truth value, or a tuple of numbers.
    lasting : bool
        Of a record or tuple: whether its memory stays as it is until the kernel returns.
    natural : bool
        Of an integer: whether it is known not to be negative.
    """

    kind: Kind | None
    content: Any = None
    constant: Any = None
    lasting: bool = False
    natural: bool = False


@dataclass
class Variable:
    """A variable with a place of its own in memory, from which LLVM makes a register where it can.

    Attributes
    ----------
    kind : Kind
        Kind of its values.
    place : object
        Where it lies.
    natural : bool
        Of integers: whether they are known not to be negative.
    """

    kind: Kind
    place: Any
    natural: bool = False


def constant(number: bool | int | float) -> Value:
    """Return a number that is known at translation."""
    if isinstance(number, bool):
        return Value(BOOLEAN, ir.Constant(BOOLEAN.register, int(number)), number)
    if isinstance(number, int):
        return Value(INTEGER, ir.Constant(INTEGER.register, int(number)), int(number), natural=number >= 0)
    return Value(REAL, ir.Constant(REAL.register, float(number)))
