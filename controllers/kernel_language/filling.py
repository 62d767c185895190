"""Assignment to all elements of an array, ``row[:] = value``."""

import ast
from collections.abc import Iterator
from contextlib import ExitStack, contextmanager
from functools import reduce
from typing import Any, cast

from llvmlite import ir
from numba.core import cgutils

from controllers.kernel_language.body import Body
from controllers.kernel_language.kinds import INTEGER, WORD, Array
from controllers.kernel_language.values import Value, constant


def fill(body: Body, target: ast.Subscript, array: Value, node: ast.expr, value: Value) -> None:
    """Assign a number, or the elements of another array, to all elements of an array.

    Arrays of one shape may overlap. On an axis on which the other array has one element, that is repeated, as numpy
    does. Where sizes differ otherwise, which numpy refuses, the elements that both have are copied: machine code
    cannot refuse anything, and must not read beyond an end.

    Parameters
    ----------
    body : Body
        The function that does it.
    target, node : ast.expr
        What is filled and with what, for errors.
    array, value : Value
        Their values.

    Raises
    ------
    NotTranslatable
        There is no array to be filled, or the other one is of another kind.
    """
    shown = ast.unparse(target)
    if not isinstance(array.kind, Array) or (isinstance(value.kind, Array) and value.kind is not array.kind):
        raise body.kernel.refusal(target, f"{shown} must be given a number or an array like it")
    if isinstance(target.slice, ast.Tuple) and len(target.slice.elts) > array.kind.ndim:
        raise body.kernel.refusal(target, f"{shown} has more places than the array has dimensions; write [:]")
    if isinstance(value.kind, Array):
        _copy(body, array, value)
        return
    number = body.like(node, value, array.kind.element)
    with _repeated(body, _count(body, array)) as place:
        body.write(number, body.builder.gep(array.content[0], [place]))


def _copy(body: Body, array: Value, other: Value) -> None:
    assert isinstance(array.kind, Array)
    builder, move = body.builder, cast(Any, cgutils.raw_memmove)
    pairs = list(zip(array.content[1:], other.content[1:], strict=True))
    alike = reduce(builder.and_, [builder.icmp_signed("==", *pair) for pair in pairs])
    with builder.if_else(alike) as (then, otherwise):
        with then:
            move(builder, array.content[0], other.content[0], _count(body, array), array.kind.element.size)
        with otherwise:
            _copy_what_both_have(body, array, other, pairs)


def _copy_what_both_have(body: Body, array: Value, other: Value, pairs: list[tuple[Any, Any]]) -> None:
    assert isinstance(array.kind, Array)
    builder, zero, one = body.builder, ir.Constant(WORD, 0), ir.Constant(WORD, 1)
    to, source = zero, zero
    with ExitStack() as loops:
        for size, given in pairs:
            is_one = builder.icmp_signed("==", given, one)
            least = builder.select(builder.icmp_signed("<", given, size), given, size)
            place = loops.enter_context(_repeated(body, builder.select(is_one, size, least)))
            to = builder.add(builder.mul(to, size), place)
            source = builder.add(builder.mul(source, given), builder.select(is_one, zero, place))
        element = body.read(array.kind.element, builder.gep(other.content[0], [source]))
        body.write(element, builder.gep(array.content[0], [to]))


def _count(body: Body, array: Value) -> Any:
    return reduce(body.builder.mul, array.content[1:])


@contextmanager
def _repeated(body: Body, count: Any) -> Iterator[Any]:
    """Repeat what is added to a body, for each place up to a count."""
    builder, counter = body.builder, body.room(INTEGER)
    head, inner, end = (body.block() for _ in range(3))
    body.write(constant(0), counter)
    builder.branch(head)
    body.continue_in(head)
    place = builder.load(counter)
    builder.cbranch(builder.icmp_signed("<", place, count), inner, end)
    body.continue_in(inner)
    yield place
    builder.store(builder.add(place, ir.Constant(WORD, 1), flags=["nsw"]), counter)
    builder.branch(head)
    body.continue_in(end)
