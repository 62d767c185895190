"""Calls in kernels: of mathematics, of what reads and writes memory, of named tuples, of other kernels."""

import ast
import inspect
import math
from collections.abc import Callable
from typing import TYPE_CHECKING, Any

import numpy as np
from llvmlite import ir

from controllers.kernel_language.dispatch import DISPATCHED
from controllers.kernel_language.indices import natural
from controllers.kernel_language.kinds import (
    ADDRESS,
    BOOLEAN,
    INTEGER,
    REAL,
    WORD,
    Array,
    Pointer,
    Record,
    array_of,
    record_of,
)
from controllers.kernel_language.sources import resolve
from controllers.kernel_language.values import Value
from controllers.pointers import call, load, row_at, store

if TYPE_CHECKING:
    from controllers.kernel_language.expressions import Expressions

MATHEMATICS: dict[Any, tuple[str, int]] = {
    math.exp: ("llvm.exp.f64", 1),
    math.log: ("llvm.log.f64", 1),
    math.sqrt: ("llvm.sqrt.f64", 1),
    math.sin: ("llvm.sin.f64", 1),
    math.cos: ("llvm.cos.f64", 1),
    math.fabs: ("llvm.fabs.f64", 1),
    math.copysign: ("llvm.copysign.f64", 2),
    math.pow: ("llvm.pow.f64", 2),
    math.expm1: ("expm1", 1),
    math.log1p: ("log1p", 1),
    math.tan: ("tan", 1),
    math.asin: ("asin", 1),
    math.acos: ("acos", 1),
    math.atan: ("atan", 1),
    math.atan2: ("atan2", 2),
    math.sinh: ("sinh", 1),
    math.cosh: ("cosh", 1),
    math.tanh: ("tanh", 1),
    math.asinh: ("asinh", 1),
}
"""Functions of real numbers, which LLVM knows or the library of C has, and how many arguments they take."""

Translation = Callable[["Expressions", ast.Call, list[Value]], Value]


def translate_call(expressions: "Expressions", node: ast.Call) -> Value:
    """Return the value of a call; ``NotTranslatable`` where it has none."""
    if not expressions.is_global(node.func):
        raise expressions.refusal(node, f"{ast.unparse(node.func)} is no function of a module")
    function = resolve(expressions.kernel, node.func)
    if function in MATHEMATICS or function in OPERATIONS:
        values = expressions.spread(node.args)
        if node.keywords:
            raise expressions.refusal(node, f"{ast.unparse(node)}: give the values one by one")
        if function in OPERATIONS:
            return OPERATIONS[function](expressions, node, values)
        return _mathematics(expressions, node, *MATHEMATICS[function], values)
    if isinstance(function, type) and issubclass(function, tuple) and hasattr(function, "_fields"):
        return _record(expressions, node, function)
    return _kernel(expressions, node, function)


def _mathematics(expressions: "Expressions", node: ast.Call, name: str, count: int, values: list[Value]) -> Value:
    if len(values) != count:
        raise expressions.refusal(node, f"{ast.unparse(node)} must have {count} arguments")
    numbers = [expressions.body.real(node, value).content for value in values]
    return Value(REAL, expressions.unit.mathematics(expressions.body, name, *numbers))


def _absolute(expressions: "Expressions", node: ast.Call, values: list[Value]) -> Value:
    (value,) = values
    if value.kind is not INTEGER:
        return _mathematics(expressions, node, "llvm.fabs.f64", 1, values)
    builder = expressions.body.builder
    negative = builder.icmp_signed("<", value.content, ir.Constant(WORD, 0))
    return Value(INTEGER, builder.select(negative, builder.neg(value.content), value.content), natural=True)


def _finite(expressions: "Expressions", node: ast.Call, values: list[Value]) -> Value:
    builder, number = expressions.body.builder, expressions.body.real(node, values[0]).content
    difference = builder.fsub(number, number)  # no number for what is infinite or none
    return Value(BOOLEAN, builder.fcmp_ordered("ord", difference, difference))


def _no_number(expressions: "Expressions", node: ast.Call, values: list[Value]) -> Value:
    number = expressions.body.real(node, values[0]).content
    return Value(BOOLEAN, expressions.body.builder.fcmp_unordered("uno", number, number))


def _choice(sign: str) -> Translation:
    """Return the translation of the largest or smallest of values: of equal ones, or beside no number, the first."""

    def translate(expressions: "Expressions", node: ast.Call, values: list[Value]) -> Value:
        if len(values) < 2:
            raise expressions.refusal(node, f"{ast.unparse(node)}: give the values one by one")
        builder, integers = expressions.body.builder, all(value.kind is INTEGER for value in values)
        chosen, *others = values if integers else [expressions.body.real(node, value) for value in values]
        for other in others:
            compare = builder.icmp_signed if integers else builder.fcmp_ordered
            content = builder.select(compare(sign, other.content, chosen.content), other.content, chosen.content)
            chosen = Value(chosen.kind, content, natural=chosen.natural and other.natural)
        return chosen

    return translate


def _integer(expressions: "Expressions", node: ast.Call, values: list[Value]) -> Value:
    (value,) = values
    if value.kind is REAL:
        return Value(INTEGER, expressions.body.builder.fptosi(value.content, WORD))
    if value.kind is BOOLEAN:
        return Value(INTEGER, expressions.body.builder.zext(value.content, WORD), natural=True)
    if value.kind is not INTEGER:
        raise expressions.refusal(node, f"{ast.unparse(node)} is no number")
    return value


def _rounded(name: str) -> Translation:
    """Return the translation of what makes an integer of a number by rounding down or up."""

    def translate(expressions: "Expressions", node: ast.Call, values: list[Value]) -> Value:
        return _integer(expressions, node, [_mathematics(expressions, node, name, 1, values)])

    return translate


def _real(expressions: "Expressions", node: ast.Call, values: list[Value]) -> Value:
    return expressions.body.real(node, values[0])


def _truth(expressions: "Expressions", node: ast.Call, values: list[Value]) -> Value:
    if values[0].kind is not BOOLEAN:
        raise expressions.refusal(node, f"{ast.unparse(node)} is no truth value; compare it, as in x != 0.0")
    return values[0]


def _natural(expressions: "Expressions", node: ast.Call, values: list[Value]) -> Value:
    (value,) = values
    return Value(INTEGER, _integer(expressions, node, [value]).content, natural=True)


def _load(expressions: "Expressions", node: ast.Call, values: list[Value]) -> Value:
    return values[0]  # an address stands for what lies there


def _store(expressions: "Expressions", node: ast.Call, values: list[Value]) -> Value:
    place, value = values
    assert place.kind is not None
    expressions.body.write(expressions.body.like(node, value, place.kind), place.content)
    return Value(None)


def _row_at(expressions: "Expressions", node: ast.Call, values: list[Value]) -> Value:
    start, count = values
    if not isinstance(start.kind, Pointer):
        raise expressions.refusal(node, f"{ast.unparse(node)} must begin at a pointer")
    return Value(array_of(start.kind.element, 1), (start.content, count.content))


def _call_address(expressions: "Expressions", node: ast.Call, values: list[Value]) -> Value:
    builder = expressions.body.builder
    kind = ir.FunctionType(ir.VoidType(), [ADDRESS, ADDRESS, ADDRESS, WORD])
    address, *pointers, count = [value.content for value in values]
    function = builder.inttoptr(address, kind.as_pointer())
    builder.call(function, [*(builder.inttoptr(pointer, ADDRESS) for pointer in pointers), count])
    return Value(None)


OPERATIONS: dict[Any, Translation] = {
    abs: _absolute,
    max: _choice(">"),
    min: _choice("<"),
    int: _integer,
    float: _real,
    math.floor: _rounded("llvm.floor.f64"),
    math.ceil: _rounded("llvm.ceil.f64"),
    bool: _truth,
    math.isfinite: _finite,
    np.isfinite: _finite,
    math.isnan: _no_number,
    np.isnan: _no_number,
    natural: _natural,
    load: _load,
    store: _store,
    row_at: _row_at,
    call: _call_address,
}
"""What is no function of C: builtins, tests, and operations on memory."""


def _bound(expressions: "Expressions", node: ast.Call, parameters: Any, given: list[Value]) -> list[Value]:
    """Return the values of all arguments, in order: those given in their place, by name, and defaults."""
    names = list(parameters)
    bound = dict(zip(names, given, strict=False))
    for keyword in node.keywords:
        if keyword.arg is None or keyword.arg not in names:
            raise expressions.refusal(node, f"{ast.unparse(node)}: name every argument, or give it in its place")
        bound[keyword.arg] = expressions.translate(keyword.value)
    if len(given) > len(names):
        raise expressions.refusal(node, f"{ast.unparse(node)} gives too many arguments")
    for name in names:
        if name not in bound:
            bound[name] = expressions.known(node, parameters[name].default)
        if bound[name].kind is None:
            raise expressions.refusal(node, f"{ast.unparse(node)}: {name} cannot be passed; pass its elements")
    return [bound[name] for name in names]


def _record(expressions: "Expressions", node: ast.Call, origin: Any) -> Value:
    values = _bound(expressions, node, inspect.signature(origin).parameters, expressions.spread(node.args))
    for place, name in enumerate(origin._fields):  # integers given for real fields become real
        if values[place].kind is INTEGER and origin.__annotations__.get(name) in (float, "float"):
            values[place] = expressions.body.real(node, values[place])
    kinds = tuple(value.kind for value in values)
    return expressions.body.record(record_of(origin, kinds), values)


def _kernel(expressions: "Expressions", node: ast.Call, function: Any) -> Value:
    body, given = expressions.body, expressions.spread(node.args)
    if function in DISPATCHED:
        first = given[0].kind if given else None
        chosen = DISPATCHED[function].get(first.origin) if isinstance(first, Record) else None
        if chosen is None:
            raise expressions.refusal(node, f"{ast.unparse(node)}: no kernel is registered for its first argument")
        function = chosen
    if not inspect.isfunction(function):
        raise expressions.refusal(node, f"{ast.unparse(node.func)} has no translation; call mathematics or kernels")
    values = _bound(expressions, node, inspect.signature(function).parameters, given)
    made = expressions.unit.function(function, tuple(value.kind for value in values), (expressions.kernel, node))
    arguments: list[Any] = []
    for value in values:
        arguments += value.content if isinstance(value.kind, Array) else [value.content]
    if made.direct:
        return Value(made.result, body.builder.call(made.function, arguments))
    if made.result is None:
        body.builder.call(made.function, [ir.Constant(ADDRESS, None), *arguments])
        return Value(None)
    room = body.room(made.result)
    body.builder.call(made.function, [body.builder.bitcast(room, ADDRESS), *arguments])
    return body.read(made.result, room, not body.repeated)
