"""Operators and calls in C: arithmetic, comparisons, conditions; mathematics, named tuples, other kernels."""

import ast
import inspect
import math
import operator
from collections.abc import Callable, Hashable
from functools import cache, partial
from typing import Any

import numpy as np

from controllers.kernels import values as c
from controllers.kernels.expressions import Expressions
from controllers.kernels.language import DISPATCHED, call, natural
from controllers.kernels.sources import INSTEAD
from controllers.kernels.types import BOOLEAN, INTEGER, REAL, Array, Record, Scalar, Type, makes_itself
from controllers.kernels.values import UNARY, Value

ARITHMETIC: dict[type, tuple[str, int, Callable[[Any, Any], Any]]] = {
    ast.Mult: ("*", c.PRODUCT, operator.mul),
    ast.Div: ("/", c.PRODUCT, operator.truediv),
    ast.Add: ("+", c.SUM, operator.add),
    ast.Sub: ("-", c.SUM, operator.sub),
}
ROUNDED: dict[type, str] = {ast.Mod: "floored_rest", ast.FloorDiv: "floored_quotient"}
COMPARISONS: dict[type, tuple[str, int, Callable[[Any, Any], bool]]] = {
    ast.Lt: ("<", c.ORDER, operator.lt),
    ast.Gt: (">", c.ORDER, operator.gt),
    ast.LtE: ("<=", c.ORDER, operator.le),
    ast.GtE: (">=", c.ORDER, operator.ge),
    ast.Eq: ("==", c.EQUALITY, operator.eq),
    ast.NotEq: ("!=", c.EQUALITY, operator.ne),
}

ONE = "exp expm1 log log1p sin cos tan asin acos atan sinh cosh tanh asinh"
"""Functions of ``math.h`` of one argument, which every machine has."""

Translation = Callable[["Calls", ast.Call, list[Value]], Value]


def _library(name: str, expressions: "Calls", node: ast.Call, values: list[Value]) -> Value:
    texts = [expressions.as_real(node, value).text for value in values]
    return Value(expressions.unit.library(name, *texts), REAL)


def _test(name: str, expressions: "Calls", node: ast.Call, values: list[Value]) -> Value:
    return Value(f"{name}({expressions.as_real(node, values[0]).text})", BOOLEAN)


def _absolute(expressions: "Calls", node: ast.Call, values: list[Value]) -> Value:
    if values[0].type == INTEGER:  # of the least one, itself
        return Value(expressions.unit.helper("absolute_integer", values[0].text), INTEGER)
    return _library("fabs", expressions, node, values)


def _choice(name: str, expressions: "Calls", node: ast.Call, values: list[Value]) -> Value:
    """Return the largest or smallest of values: of equal ones, or beside no number, the first."""
    if len(values) < 2:
        raise expressions.refusal(node, "{}: give the values one by one")
    integers = all(value.type == INTEGER for value in values)
    chosen, *others = values if integers else [expressions.as_real(node, value) for value in values]
    text = chosen.text
    for other in others:
        text = expressions.unit.helper(f"{name}_integer" if integers else name, text, other.text)
    return Value(text, chosen.type, natural=all(value.natural for value in values))


def _integer(expressions: "Calls", node: ast.Call, values: list[Value]) -> Value:
    (value,) = values
    if value.type == INTEGER:
        return value
    if value.type not in (REAL, BOOLEAN):
        raise expressions.refusal(node, "{} is no number")
    if value.type == BOOLEAN or expressions.unit.fixed:
        return Value(f"(int64_t){value.within(UNARY)}", INTEGER, UNARY, natural=value.type == BOOLEAN)
    return Value(expressions.unit.helper("whole_number", value.text), INTEGER)


def _rounded(name: str, expressions: "Calls", node: ast.Call, values: list[Value]) -> Value:
    """Return the integer that rounding down or up makes of a number."""
    if values[0].type == INTEGER:
        return values[0]
    return _integer(expressions, node, [_library(name, expressions, node, values)])


def _real(expressions: "Calls", node: ast.Call, values: list[Value]) -> Value:
    return expressions.as_real(node, values[0])


def _natural(expressions: "Calls", node: ast.Call, values: list[Value]) -> Value:
    value = _integer(expressions, node, values)
    return Value(value.text, INTEGER, value.rank, value.constant, natural=True)


def _call_address(expressions: "Calls", node: ast.Call, values: list[Value]) -> Value:
    address, parameters, state, row = values
    if row.type != Array(REAL, (None,)):
        raise expressions.refusal(node, "{}: the last argument must be an array of numbers")
    function = f"((void (*)(void *, void *, double *, int64_t))(intptr_t){address.within(UNARY)})"
    places = ", ".join(f"(void *)(intptr_t){place.within(UNARY)}" for place in (parameters, state))
    expressions.scope.writes += 1
    row = expressions.placed(node, row) if row.part or not row.root else row
    return Value(f"{function}({places}, {row.text}.data, {row.text}.size0)", None)


OPERATIONS: dict[Any, tuple[Translation, int | None]] = {
    **{
        getattr(math, name): (partial(_library, name), count)
        for names, count in ((f"{ONE} sqrt fabs", 1), ("pow atan2 copysign", 2))
        for name in names.split()
    },
    **{getattr(module, name): (partial(_test, name), 1) for module in (math, np) for name in ("isfinite", "isnan")},
    math.floor: (partial(_rounded, "floor"), 1),
    math.ceil: (partial(_rounded, "ceil"), 1),
    abs: (_absolute, 1),
    max: (partial(_choice, "larger"), None),
    min: (partial(_choice, "smaller"), None),
    int: (_integer, 1),
    float: (_real, 1),
    natural: (_natural, 1),
    call: (_call_address, 4),
}
"""What kernels call beside each other, and how many arguments it takes, if not several."""


@cache
def signature_of(function: Callable[..., Any]) -> inspect.Signature:
    """Return the signature of a kernel or of a class of named tuples."""
    return inspect.signature(function)


class Calls(Expressions):
    """Translates operators and calls, and so all expressions of a function."""

    def _binop(self, node: ast.BinOp) -> Value:
        return self.combined(node, node.op, self.translate(node.left), self.translate(node.right))

    def combined(self, node: ast.AST, operation: ast.operator, left: Value, right: Value) -> Value:
        """Return a sum, difference, product, quotient or power."""
        if isinstance(operation, ast.Pow):
            return self._power(node, left, right)
        both = left.type == right.type == INTEGER
        if type(operation) in ROUNDED and both:
            if left.natural and (right.constant or 0) > 0:  # C rounds to zero, which is down here
                sign, rank, _ = ARITHMETIC[ast.Div]
                sign = sign if isinstance(operation, ast.FloorDiv) else "%"
                return Value(f"{left.within(rank)} {sign} {right.within(rank + 1)}", INTEGER, rank, natural=True)
            text = self.unit.helper(ROUNDED[type(operation)], left.text, right.text)
            natural = right.natural and (left.natural or isinstance(operation, ast.Mod))
            return Value(text, INTEGER, natural=natural)
        if type(operation) not in ARITHMETIC:
            allowed = "+ - * / and **, and // and % of integers; use math on reals"
            raise self.refusal(node, f"{{}}: there are {allowed}")
        sign, rank, fold = ARITHMETIC[type(operation)]
        if both and sign != "/":
            text = f"{left.within(rank)} {sign} {right.within(rank + 1)}"
            natural = left.natural and right.natural and sign != "-"
            if left.constant is None or right.constant is None:
                return Value(text, INTEGER, rank, natural=natural)
            result = fold(left.constant, right.constant)
            self._check_word(node, result)
            named = not (left.text + right.text).isdigit()
            known = self._literal(node, result)
            return Value(text, INTEGER, rank, result, natural=result >= 0) if named else known
        left, right = self.as_real(node, left), self.as_real(node, right)
        # C and Python both group from the left; parentheses keep the grouping of the tree exactly
        return Value(f"{left.within(rank)} {sign} {right.within(rank + 1)}", REAL, rank)

    def _power(self, node: ast.AST, base: Value, exponent: Value) -> Value:
        if exponent.type == INTEGER:
            if base.type != REAL or exponent.constant != 2:
                raise self.refusal(node, "{}: write out powers other than the second as products")
            return Value(self.unit.helper("square", base.text), REAL)
        base, exponent = self.as_real(node, base), self.as_real(node, exponent)
        return Value(self.unit.library("pow", base.text, exponent.text), REAL)

    def _unaryop(self, node: ast.UnaryOp) -> Value:
        if isinstance(node.op, ast.Not):
            value = self.condition(node.operand)
            known = None if value.constant is None else not value.constant
            return Value(f"!{value.within(UNARY)}", BOOLEAN, UNARY, known)
        if isinstance(node.op, ast.USub) and isinstance(node.operand, ast.Constant) and type(node.operand.value) is int:
            return self._literal(node, -node.operand.value)
        value = self.translate(node.operand)
        if not isinstance(node.op, ast.USub) or value.type not in (REAL, INTEGER):
            raise self.refusal(node, "{} has no translation; write a number or its negative")
        known = None if value.constant is None else -value.constant
        if known is not None and value.type == INTEGER:
            self._check_word(node, known)
        natural = value.type == INTEGER and known is not None and known >= 0
        return Value(f"-{value.within(UNARY + 1)}", value.type, UNARY, known, natural=natural)

    def _boolop(self, node: ast.BoolOp) -> Value:
        conjunction = isinstance(node.op, ast.And)
        sign, rank = ("&&", c.CONJUNCTION) if conjunction else ("||", c.DISJUNCTION)
        values = []
        for place, operand in enumerate(node.values):
            self.scope.conditional += place > 0
            value = self.condition(operand)
            self.scope.conditional -= place > 0
            if value.constant is None:
                values.append(value)
            elif bool(value.constant) != conjunction:  # decides it, whatever stands to the left: that has no effects
                return self._literal(node, bool(value.constant))
        if not values:
            return self._literal(node, conjunction)
        if len(values) == 1:
            return values[0]
        inner = [
            value.within(c.ORDER - 1 if value.rank in (c.CONJUNCTION, c.DISJUNCTION) else rank) for value in values
        ]
        return Value(f" {sign} ".join(inner), BOOLEAN, rank)

    def _compare(self, node: ast.Compare) -> Value:
        if any(type(operation) not in COMPARISONS for operation in node.ops):
            raise self.refusal(node, "{}: there are < > <= >= == and !=")
        parts, known = [], []
        right = self.translate(node.left)
        for place, (operation, item) in enumerate(zip(node.ops, node.comparators, strict=True)):
            left, writes = right, self.scope.writes
            self.scope.conditional += place > 0
            right = self.translate(item)
            if place + 1 < len(node.ops) and self.scope.writes > writes:
                right = self.placed(item, right)  # it is compared twice, and changes something once
            self.scope.conditional -= place > 0
            text, decided = self._comparison(node, operation, left, right)
            parts.append(text)
            known.append(decided)
        if None not in known:
            return self._literal(node, all(known))
        rank = COMPARISONS[type(node.ops[0])][1] if len(parts) == 1 else c.CONJUNCTION
        return Value(" && ".join(parts), BOOLEAN, rank)

    def _comparison(
        self, node: ast.Compare, operation: ast.cmpop, left: Value, right: Value
    ) -> tuple[str, bool | None]:
        """Return two values compared in C, and what comes of it where that is known."""
        sign, rank, compare = COMPARISONS[type(operation)]
        decided = None
        if {left.type, right.type} <= {INTEGER, REAL} and None not in (left.constant, right.constant):
            decided = compare(left.constant, right.constant)
        if left.type != right.type:
            left, right = self.as_real(node, left), self.as_real(node, right)
        if not isinstance(left.type, Scalar):
            raise self.refusal(node, "{} compares what are no numbers")
        return f"{left.within(rank + 1)} {sign} {right.within(rank + 1)}", decided

    def _ifexp(self, node: ast.IfExp) -> Value:
        test = self.condition(node.test)
        if test.constant is not None:
            return self.translate(node.body if test.constant else node.orelse)
        self.scope.conditional += 1
        first, second = self.translate(node.body), self.translate(node.orelse)
        self.scope.conditional -= 1
        if first.type != second.type:
            first, second = self.as_real(node.body, first), self.as_real(node.orelse, second)
        texts = [f"({value.content})" if value.rank <= c.CHOICE else value.content for value in (first, second)]
        natural = first.natural and second.natural
        return Value(f"{test.within(c.CHOICE + 1)} ? {texts[0]} : {texts[1]}", first.type, c.CHOICE, natural=natural)

    def _call(self, node: ast.Call) -> Value:
        if not self.is_global(node.func):
            if isinstance(node.func, ast.Attribute) and node.func.attr == "_replace":
                return self._replaced(node, node.func.value)
            raise self.refusal(node, f"{ast.unparse(node.func)} is no function of a module")
        function = self.unit.resolved(self.kernel, node.func)
        if not callable(function) or not isinstance(function, Hashable):
            raise self.refusal(node, f"{ast.unparse(node.func)} is no function")
        if function in OPERATIONS:
            return self._operation(node, *OPERATIONS[function])
        if isinstance(function, type) and issubclass(function, tuple) and hasattr(function, "_fields"):
            return self._record(node, function)
        return self._call_of(node, function)

    def _operation(self, node: ast.Call, translate: Translation, count: int | None) -> Value:
        values = self.spread(node.args)
        if node.keywords:
            raise self.refusal(node, "{}: give the values one by one")
        if count is not None and len(values) != count:
            raise self.refusal(node, f"{{}} must have {count} arguments")
        return translate(self, node, values)

    def _bound(self, node: ast.Call, function: Callable[..., Any], given: list[Value]) -> list[Value]:
        """Return values of all arguments, in order: given in their place, by name, and defaults, as in Python."""
        signature = signature_of(function)
        if any(keyword.arg is None for keyword in node.keywords):
            raise self.refusal(node, "{}: name every argument, or give it in its place")
        if any(each.kind in (each.VAR_POSITIONAL, each.VAR_KEYWORD) for each in signature.parameters.values()):
            raise self.refusal(node, "{}: a kernel takes its arguments one by one, without *")
        named = {str(keyword.arg): self.translate(keyword.value) for keyword in node.keywords}
        try:
            bound = signature.bind(*given, **named).arguments
        except TypeError as error:
            raise self.refusal(node, f"{{}}: {error}; name every argument, or give it in its place") from None
        for name, parameter in signature.parameters.items():
            if name not in bound:
                bound[name] = self.known(node, parameter.default)
            if bound[name].type is None:
                raise self.refusal(node, f"{{}}: {name} cannot be passed; pass its elements")
        return [bound[name] for name in signature.parameters]

    def _record(self, node: ast.Call, origin: Any) -> Value:
        if makes_itself(origin):
            raise self.refusal(
                node, f"{origin.__name__} has a __new__ of its own; write a kernel that makes a plain named tuple"
            )
        values = self._bound(node, origin, self.spread(node.args))
        return self._made(node, origin, values)

    def _replaced(self, node: ast.Call, owner: ast.expr) -> Value:
        """Return a named tuple with other values of the fields that are named."""
        record = self.translate(owner)
        kind = record.type
        if not isinstance(kind, Record) or kind.origin is None:
            raise self.refusal(node, f"{{}}: {ast.unparse(owner)} is no named tuple")
        names = [keyword.arg for keyword in node.keywords]
        if node.args or None in names:
            raise self.refusal(node, "{}: name every field that changes")
        if unknown := {str(name) for name in names} - {name for name, _ in kind.fields}:
            raise self.refusal(node, f"{{}}: {kind.name} has no field {min(unknown)}")
        given = {keyword.arg: self.translate(keyword.value) for keyword in node.keywords}
        record = self.placed(node, record)
        values = [given.get(name) or record.member(name) for name, _ in kind.fields]
        return self._made(node, kind.origin, values)

    def _made(self, node: ast.Call, origin: Any, values: list[Value]) -> Value:
        fields: list[tuple[str, Type]] = []
        for place, name in enumerate(origin._fields):  # integers given for real fields become real
            if values[place].type == INTEGER and origin.__annotations__.get(name) in (float, "float"):
                values[place] = self.as_real(node, values[place])
            kind = values[place].type
            if kind is None:
                raise self.refusal(node, "{}: a field has no value")
            fields.append((name, kind))
        record = Record(origin.__name__, tuple(fields), origin)
        return Value(self.unit.compound(record, values), record)

    def _call_of(self, node: ast.Call, function: Any) -> Value:
        unit, given = self.unit, self.spread(node.args)
        if function in DISPATCHED:
            first = given[0].type if given else None
            chosen = DISPATCHED[function].get(first.origin) if isinstance(first, Record) and first.origin else None
            if chosen is None:
                raise self.refusal(node, "{}: no kernel is registered for its first argument")
            function = chosen
        if not inspect.isfunction(function):
            instead = INSTEAD.get(function, "call mathematics or kernels")
            raise self.refusal(node, f"{ast.unparse(node.func)} has no translation; {instead}")
        values = self._bound(node, function, given)
        kinds = tuple(value.type for value in values if value.type is not None)
        constants = tuple(_known(value, unit.fixed) for value in values)
        translated = unit.function(function, kinds, constants, (self.kernel, node))
        if translated.writes:
            self.scope.writes += 1
            self.check_order(node, translated.name)
        texts = [self.passed(node, value) for value in values]
        text = f"{translated.name}({', '.join(texts)})"
        return Value(text, translated.result, constant=translated.constant, natural=translated.natural)


def _known(value: Value, fixed: bool) -> float | str | None:
    """Return what a kernel may rely on of an argument."""
    if value.type == REAL and fixed and value.root and value.constant is not None:  # a parameter
        return float(value.constant)
    if value.type != INTEGER:
        return None
    if fixed and value.constant is not None:
        return int(value.constant)
    return "natural" if value.natural else None
