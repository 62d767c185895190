"""Operators in C: arithmetic, comparisons, conditions."""

import ast
import operator
from collections.abc import Callable
from typing import Any

from controllers.kernels.expressions import Expressions
from controllers.kernels.types import BOOLEAN, INTEGER, REAL, Scalar
from controllers.kernels.values import (
    CHOICE,
    CONJUNCTION,
    DISJUNCTION,
    EQUALITY,
    ORDER,
    PRODUCT,
    SUM,
    UNARY,
    Value,
)

ARITHMETIC: dict[type, tuple[str, int, Callable[[Any, Any], Any]]] = {
    ast.Mult: ("*", PRODUCT, operator.mul),
    ast.Div: ("/", PRODUCT, operator.truediv),
    ast.Add: ("+", SUM, operator.add),
    ast.Sub: ("-", SUM, operator.sub),
}
ROUNDED: dict[type, str] = {ast.Mod: "floored_rest", ast.FloorDiv: "floored_quotient"}
COMPARISONS: dict[type, tuple[str, int, Callable[[Any, Any], bool]]] = {
    ast.Lt: ("<", ORDER, operator.lt),
    ast.Gt: (">", ORDER, operator.gt),
    ast.LtE: ("<=", ORDER, operator.le),
    ast.GtE: (">=", ORDER, operator.ge),
    ast.Eq: ("==", EQUALITY, operator.eq),
    ast.NotEq: ("!=", EQUALITY, operator.ne),
}


class Operators(Expressions):
    """Translates operators."""

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
        sign, rank = ("&&", CONJUNCTION) if conjunction else ("||", DISJUNCTION)
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
        inner = [value.within(ORDER - 1 if value.rank in (CONJUNCTION, DISJUNCTION) else rank) for value in values]
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
        rank = COMPARISONS[type(node.ops[0])][1] if len(parts) == 1 else CONJUNCTION
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
        texts = [f"({value.content})" if value.rank <= CHOICE else value.content for value in (first, second)]
        natural = first.natural and second.natural
        return Value(f"{test.within(CHOICE + 1)} ? {texts[0]} : {texts[1]}", first.type, CHOICE, natural=natural)
