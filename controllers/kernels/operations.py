"""Operations in kernels that are called like functions: mathematics, tests, builtins."""

import ast
import math
from collections.abc import Callable
from typing import Any

import numpy as np

from controllers.kernels.language import call, natural
from controllers.kernels.subscripts import Subscripts
from controllers.kernels.types import BOOLEAN, INTEGER, REAL, Array
from controllers.kernels.values import UNARY, Value

MATHEMATICS: dict[Any, tuple[str, int]] = {
    math.exp: ("exp", 1),
    math.expm1: ("expm1", 1),
    math.log: ("log", 1),
    math.log1p: ("log1p", 1),
    math.sqrt: ("sqrt", 1),
    math.pow: ("pow", 2),
    math.sin: ("sin", 1),
    math.cos: ("cos", 1),
    math.tan: ("tan", 1),
    math.asin: ("asin", 1),
    math.acos: ("acos", 1),
    math.atan: ("atan", 1),
    math.atan2: ("atan2", 2),
    math.sinh: ("sinh", 1),
    math.cosh: ("cosh", 1),
    math.tanh: ("tanh", 1),
    math.asinh: ("asinh", 1),
    math.copysign: ("copysign", 2),
    math.fabs: ("fabs", 1),
}
"""Functions of ``math.h``, which every machine has, and how many arguments they take."""

Translation = Callable[[Subscripts, ast.Call, list[Value]], Value]


def operation(expressions: Subscripts, node: ast.Call, function: Any) -> Value:
    """Return what one of ``MATHEMATICS`` or ``OPERATIONS`` gives."""
    values = expressions.spread(node.args)
    if node.keywords:
        raise expressions.refusal(node, "{}: give the values one by one")
    count = (MATHEMATICS if function in MATHEMATICS else OPERATIONS)[function][1]
    if count is not None and len(values) != count:
        raise expressions.refusal(node, f"{{}} must have {count} arguments")
    if function in MATHEMATICS:
        texts = [expressions.as_real(node, value).text for value in values]
        return Value(expressions.unit.library(MATHEMATICS[function][0], *texts), REAL)
    return OPERATIONS[function][0](expressions, node, values)


def _absolute(expressions: Subscripts, node: ast.Call, values: list[Value]) -> Value:
    if values[0].type == INTEGER:  # of the least one, itself
        return Value(expressions.unit.helper("absolute_integer", values[0].text), INTEGER)
    return Value(expressions.unit.library("fabs", expressions.as_real(node, values[0]).text), REAL)


def _test(name: str) -> Translation:
    """Return the translation of a test of a real number."""

    def translate(expressions: Subscripts, node: ast.Call, values: list[Value]) -> Value:
        return Value(f"{name}({expressions.as_real(node, values[0]).text})", BOOLEAN)

    return translate


def _choice(name: str) -> Translation:
    """Return the translation of the largest or smallest of values: of equal ones, or beside no number, the first."""

    def translate(expressions: Subscripts, node: ast.Call, values: list[Value]) -> Value:
        if len(values) < 2:
            raise expressions.refusal(node, "{}: give the values one by one")
        integers = all(value.type == INTEGER for value in values)
        chosen, *others = values if integers else [expressions.as_real(node, value) for value in values]
        text = chosen.text
        for other in others:
            text = expressions.unit.helper(f"{name}_integer" if integers else name, text, other.text)
        return Value(text, chosen.type, natural=all(value.natural for value in values))

    return translate


def _integer(expressions: Subscripts, node: ast.Call, values: list[Value]) -> Value:
    (value,) = values
    if value.type == INTEGER:
        return value
    if value.type not in (REAL, BOOLEAN):
        raise expressions.refusal(node, "{} is no number")
    if value.type == BOOLEAN or expressions.unit.fixed:
        return Value(f"(int64_t){value.within(UNARY)}", INTEGER, UNARY, natural=value.type == BOOLEAN)
    return Value(expressions.unit.helper("whole_number", value.text), INTEGER)


def _rounded(name: str) -> Translation:
    """Return the translation of what makes an integer of a number by rounding down or up."""

    def translate(expressions: Subscripts, node: ast.Call, values: list[Value]) -> Value:
        if values[0].type == INTEGER:
            return values[0]
        text = expressions.unit.library(name, expressions.as_real(node, values[0]).text)
        return _integer(expressions, node, [Value(text, REAL)])

    return translate


def _real(expressions: Subscripts, node: ast.Call, values: list[Value]) -> Value:
    return expressions.as_real(node, values[0])


def _truth(expressions: Subscripts, node: ast.Call, values: list[Value]) -> Value:
    if values[0].type != BOOLEAN:
        raise expressions.refusal(node, "{} is no truth value; compare it, as in x != 0.0")
    return values[0]


def _natural(expressions: Subscripts, node: ast.Call, values: list[Value]) -> Value:
    value = _integer(expressions, node, values)
    return Value(value.text, INTEGER, value.rank, value.constant, natural=True)


def _call_address(expressions: Subscripts, node: ast.Call, values: list[Value]) -> Value:
    address, parameters, state, row = values
    if row.type != Array(REAL, (None,)):
        raise expressions.refusal(node, "{}: the last argument must be an array of numbers")
    function = f"((void (*)(void *, void *, double *, int64_t))(intptr_t){address.within(UNARY)})"
    places = ", ".join(f"(void *)(intptr_t){place.within(UNARY)}" for place in (parameters, state))
    expressions.scope.writes += 1
    row = expressions.placed(node, row) if row.part or not row.root else row
    return Value(f"{function}({places}, {row.text}.data, {row.text}.size0)", None)


OPERATIONS: dict[Any, tuple[Translation, int | None]] = {
    abs: (_absolute, 1),
    max: (_choice("larger"), None),
    min: (_choice("smaller"), None),
    int: (_integer, 1),
    float: (_real, 1),
    bool: (_truth, 1),
    math.floor: (_rounded("floor"), 1),
    math.ceil: (_rounded("ceil"), 1),
    math.isfinite: (_test("isfinite"), 1),
    np.isfinite: (_test("isfinite"), 1),
    math.isnan: (_test("isnan"), 1),
    np.isnan: (_test("isnan"), 1),
    natural: (_natural, 1),
    call: (_call_address, 4),
}
"""What is no function of C: builtins, tests, calls by address; and how many arguments it takes, if not several."""
