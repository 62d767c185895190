"""Operations in kernels that are called like functions: mathematics, builtins, what reads and writes memory."""

import ast
import math
from collections.abc import Callable
from typing import TYPE_CHECKING, Any

import numpy as np
from llvmlite import ir

from controllers.kernel_language.indices import natural
from controllers.kernel_language.kinds import ADDRESS, BOOLEAN, DOUBLE, INTEGER, REAL, WORD, Pointer, array_of
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
    math.pow: ("pow", 2),
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


def operation(expressions: "Expressions", node: ast.Call, function: Any) -> Value:
    """Return what one of ``MATHEMATICS`` or ``OPERATIONS`` gives."""
    values = expressions.spread(node.args)
    if node.keywords:
        raise expressions.refusal(node, f"{ast.unparse(node)}: give the values one by one")
    count = (MATHEMATICS if function in MATHEMATICS else OPERATIONS)[function][1]
    if count is not None and len(values) != count:
        raise expressions.refusal(node, f"{ast.unparse(node)} must have {count} arguments")
    if function in MATHEMATICS:
        return _mathematics(expressions, node, MATHEMATICS[function][0], values)
    return OPERATIONS[function][0](expressions, node, values)


def _mathematics(expressions: "Expressions", node: ast.Call, name: str, values: list[Value]) -> Value:
    numbers = [expressions.body.real(node, value).content for value in values]
    return Value(REAL, expressions.unit.mathematics(expressions.body, name, *numbers))


def _absolute(expressions: "Expressions", node: ast.Call, values: list[Value]) -> Value:
    (value,) = values
    if value.kind is not INTEGER:
        return _mathematics(expressions, node, "llvm.fabs.f64", values)
    builder = expressions.body.builder
    negative = builder.icmp_signed("<", value.content, ir.Constant(WORD, 0))
    return Value(INTEGER, builder.select(negative, builder.neg(value.content), value.content))  # least stays negative


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
        to_integer = expressions.unit.module.declare_intrinsic(
            "llvm.fptosi.sat", [WORD, DOUBLE], ir.FunctionType(WORD, [DOUBLE])
        )  # the nearest integer that there is, and zero for no number
        return Value(INTEGER, expressions.body.builder.call(to_integer, [value.content]))
    if value.kind is BOOLEAN:
        return Value(INTEGER, expressions.body.builder.zext(value.content, WORD), natural=True)
    if value.kind is not INTEGER:
        raise expressions.refusal(node, f"{ast.unparse(node)} is no number")
    return value


def _rounded(name: str) -> Translation:
    """Return the translation of what makes an integer of a number by rounding down or up."""

    def translate(expressions: "Expressions", node: ast.Call, values: list[Value]) -> Value:
        if values[0].kind is INTEGER:
            return values[0]
        return _integer(expressions, node, [_mathematics(expressions, node, name, values)])

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


OPERATIONS: dict[Any, tuple[Translation, int | None]] = {
    abs: (_absolute, 1),
    max: (_choice(">"), None),
    min: (_choice("<"), None),
    int: (_integer, 1),
    float: (_real, 1),
    math.floor: (_rounded("llvm.floor.f64"), 1),
    math.ceil: (_rounded("llvm.ceil.f64"), 1),
    bool: (_truth, 1),
    math.isfinite: (_finite, 1),
    np.isfinite: (_finite, 1),
    math.isnan: (_no_number, 1),
    np.isnan: (_no_number, 1),
    natural: (_natural, 1),
    load: (_load, 1),
    store: (_store, 2),
    row_at: (_row_at, 2),
    call: (_call_address, 5),
}
"""What is no function of C: builtins, tests, operations on memory; and how many arguments it takes, if not several."""
