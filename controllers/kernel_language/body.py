"""The function of LLVM that a kernel becomes: its blocks, its memory, and what is read from and written to memory.

Numbers are in registers. Named tuples and tuples never change, so an expression stands for one by an address; where
its memory may be used again, as that of a variable that gets another value, it is copied.
"""

import ast
from typing import Any

from llvmlite import ir
from numba.core import cgutils

from controllers.kernel_language.kinds import (
    BIT,
    BOOLEAN,
    BYTE,
    DOUBLE,
    INTEGER,
    REAL,
    WORD,
    Array,
    Kind,
    Line,
    Pointer,
    Record,
    Scalar,
)
from controllers.kernel_language.sources import Kernel
from controllers.kernel_language.values import Value, constant

PLACE = ir.IntType(32)
"""Type of the places of fields."""


class Body:
    """The body of one function, to whose end instructions are added.

    Parameters
    ----------
    function : llvmlite function
        The function, without a body.
    kernel : Kernel
        What it is translated from; names the line of what has no translation.

    Attributes
    ----------
    builder : llvmlite builder
        Adds instructions to the present block.
    repeated : int
        How many loops are around what is translated now.
    """

    def __init__(self, function: Any, kernel: Kernel) -> None:
        self.function, self.kernel = function, kernel
        self._rooms = ir.IRBuilder(function.append_basic_block())
        self._first = function.append_basic_block()
        self.builder: Any = ir.IRBuilder(self._first)
        self.repeated = 0

    def close(self) -> None:
        """End the function."""
        self._rooms.branch(self._first)

    def room(self, kind: Kind) -> Any:
        """Return the address of memory for a value, which holds while the function runs."""
        return self._rooms.alloca(kind.memory)

    def block(self) -> Any:
        """Return a new block."""
        return self.function.append_basic_block()

    @property
    def ended(self) -> bool:
        """Whether nothing can follow in the present block."""
        return bool(self.builder.block.is_terminated)

    def go_on_to(self, block: Any) -> None:
        """Jump to a block, if nothing else was jumped to."""
        if not self.ended:
            self.builder.branch(block)

    def continue_in(self, block: Any) -> None:
        """Add what follows to the end of a block."""
        self.builder.position_at_end(block)

    def part(self, address: Any, *places: Any) -> Any:
        """Return the address of a field or an element of what lies at an address."""
        path = [ir.Constant(PLACE, place) if isinstance(place, int) else place for place in (0, *places)]
        return self.builder.gep(address, path, inbounds=True)

    def read(self, kind: Kind, address: Any, lasting: bool = False) -> Value:
        """Return what lies at an address."""
        if isinstance(kind, Scalar):
            content = self.builder.load(address)
            return Value(kind, self.builder.trunc(content, BIT) if kind is BOOLEAN else content)
        if isinstance(kind, Array):
            return Value(kind, tuple(self.builder.load(self.part(address, k)) for k in range(1 + kind.ndim)))
        return Value(kind, address, lasting=lasting)

    def write(self, value: Value, address: Any) -> None:
        """Write a value to an address."""
        kind = value.kind
        if isinstance(kind, Scalar):
            content = self.builder.zext(value.content, BYTE) if kind is BOOLEAN else value.content
            self.builder.store(content, address)
        elif isinstance(kind, Array):
            for place, content in enumerate(value.content):
                self.builder.store(content, self.part(address, place))
        elif isinstance(kind, Record | Line):
            copy: Any = cgutils.raw_memcpy
            copy(self.builder, address, value.content, ir.Constant(WORD, kind.size), 1, align=kind.alignment)

    def copy(self, value: Value) -> Value:
        """Return a value whose memory stays as it is for a statement; of one that lasts anyway, itself."""
        if value.lasting or not isinstance(value.kind, Record | Line):
            return value
        room = self.room(value.kind)
        self.write(value, room)
        return Value(value.kind, room)

    def record(self, kind: Kind, items: list[Value]) -> Value:
        """Return a record or tuple of items, which have the kinds of its fields."""
        room = self.room(kind)
        for place, item in enumerate(items):
            self.write(item, self.part(room, place))
        return Value(kind, room, lasting=not self.repeated)

    def member(self, value: Value, place: int) -> Value:
        """Return a field of a record or an element of a tuple."""
        kind = value.kind.element if isinstance(value.kind, Line) else value.kind.kinds[place]  # type: ignore[union-attr]
        return self.read(kind, self.part(value.content, place), value.lasting)

    def element(self, node: ast.AST, owner: Value, index: Value) -> Value:
        """Return an element of a tuple of one kind, at any place."""
        assert isinstance(owner.kind, Line)
        length = owner.kind.length
        if index.constant is not None and not -length <= index.constant < length:
            raise self.kernel.refusal(node, f"{ast.unparse(node)} is beyond the {length} items that there are")
        if owner.kind.length == 1:
            return self.member(owner, 0)  # a computed place would keep LLVM from making registers of all around it
        place = self._from_start(index, ir.Constant(WORD, owner.kind.length))
        return self.read(owner.kind.element, self.part(owner.content, place), owner.lasting)

    def address(self, owner: Value, indices: list[Value]) -> Any:
        """Return where an element of an array, or the first one of a row of it, lies."""
        if isinstance(owner.kind, Pointer):
            return self.builder.gep(owner.content, [indices[0].content])
        address, *sizes = owner.content
        place = None
        for axis, size in enumerate(sizes):
            inner = self._from_start(indices[axis], size) if axis < len(indices) else None
            scaled = None if place is None else self.builder.mul(place, size)
            place = scaled if inner is None else inner if scaled is None else self.builder.add(scaled, inner)
        return self.builder.gep(address, [place], inbounds=True)

    def _from_start(self, index: Value, size: Any) -> Any:
        """Return an index, which counts from the end where it is negative, from the start."""
        if index.natural:
            return index.content
        from_end = self.builder.add(index.content, size)
        if index.constant is not None:
            return from_end
        negative = self.builder.icmp_signed("<", index.content, ir.Constant(WORD, 0))
        return self.builder.select(negative, from_end, index.content)

    def real(self, node: ast.AST, value: Value) -> Value:
        """Return a number as a real one."""
        if value.kind is REAL:
            return value
        if value.kind is not INTEGER:
            raise self.kernel.refusal(node, f"{ast.unparse(node)} is no number")
        if value.constant is not None:
            return constant(float(value.constant))
        return Value(REAL, self.builder.sitofp(value.content, DOUBLE))

    def like(self, node: ast.AST, value: Value, kind: Kind) -> Value:
        """Return a value as one of a kind: integers, also in records, become real numbers where these are asked for."""
        if value.kind is kind:
            return value
        if kind is REAL:
            return self.real(node, value)
        found = value.kind
        if isinstance(kind, Record) and isinstance(found, Record | Line) and _same_form(kind, found):
            items = [self.like(node, self.member(value, k), each) for k, each in enumerate(kind.kinds)]
            return self.record(kind, items)
        raise self.kernel.refusal(node, f"{ast.unparse(node)} is {found or 'nothing'}, and must be {kind}")


def _same_form(kind: Record, found: Record | Line) -> bool:
    if isinstance(found, Line):
        return kind.origin is None and len(kind.kinds) == found.length
    return kind.origin is found.origin and len(kind.kinds) == len(found.kinds)
