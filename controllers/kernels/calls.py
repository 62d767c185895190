"""Calls in kernels, read into a typed tree: mathematics, named tuples, other kernels."""

import ast
import inspect
import math
from collections.abc import Callable, Hashable
from dataclasses import replace
from functools import cache
from typing import Any

import numpy as np

from controllers.kernels.expressions import Expressions
from controllers.kernels.language import DISPATCHED, call, natural
from controllers.kernels.sources import INSTEAD
from controllers.kernels.tree import Node
from controllers.kernels.types import BOOLEAN, INTEGER, REAL, Array, Record, makes_itself, passed_by_pointer


class Calls(Expressions):
    """Reads calls beside the other expressions of one function."""

    def _check_order(self, node: ast.Call, name: str) -> None:
        """Refuse a call that changes arrays in the midst of an expression that reads elements or calls others.

        C leaves open in which order the parts of an expression are computed, but for what and, or and not join.
        """
        whole, own = self.statement, set(ast.walk(node))
        in_place = isinstance(whole, ast.AugAssign) and isinstance(whole.target, ast.Subscript)
        ordered = [] if in_place else [getattr(whole, "value", None)]
        for part in ordered:
            ordered += part.values if isinstance(part, ast.BoolOp) else []
            ordered += [part.operand] if isinstance(part, ast.UnaryOp) else []
        reading = (part for part in ast.walk(whole) if isinstance(part, ast.Call | ast.Subscript) and part not in own)
        if node not in ordered and any(node not in ast.walk(part) for part in reading):
            raise self.refusal(node, f"{name} changes arrays in place; give its result a name in a line before")

    def _call(self, node: ast.Call) -> Node:
        if not self.is_global(node.func):
            if isinstance(node.func, ast.Attribute) and node.func.attr == "_replace":
                return self._replaced(node, node.func.value)
            raise self.refusal(node, f"{ast.unparse(node.func)} is no function of a module")
        function = self.resolved(node.func)
        if not callable(function) or not isinstance(function, Hashable):
            raise self.refusal(node, f"{ast.unparse(node.func)} is no function")
        given = self.spread(node.args)
        if function in OPERATIONS:
            return self._operation(node, *OPERATIONS[function], given)
        if isinstance(function, type) and issubclass(function, tuple) and hasattr(function, "_fields"):
            if makes_itself(function):
                remedy = "write a kernel that makes a plain named tuple"
                raise self.refusal(node, f"{function.__name__} has a __new__ of its own; {remedy}")
            return self._named_tuple(node, function, self._bound(node, function, given))
        return self._call_of(node, function, given)

    def _operation(self, node: ast.Call, name: str, count: int | None, values: list[Node]) -> Node:
        """Return what mathematics gives, or one of the functions beside it."""
        if node.keywords or (count is None and len(values) < 2):
            raise self.refusal(node, "{}: give the values one by one")
        if count not in (None, len(values)):
            raise self.refusal(node, f"{{}} must have {count} arguments")
        if name == "by address":
            return self._call_address(node, values)
        if name in ("integer", "natural"):
            value = self._integer(node, values[0])
            return replace(value, natural=value.natural or name == "natural")
        integers = all(value.type == INTEGER for value in values)
        if integers and name in ("floor", "ceil"):
            return values[0]
        if name == "absolute" and integers:  # of the least one, itself
            return Node("call", INTEGER, (values[0],), "absolute_integer")
        if name in ("larger", "smaller"):  # of equal ones, or beside no number, the first
            chosen, *others = values if integers else [self.as_real(node, value) for value in values]
            for other in others:
                chosen = Node("call", chosen.type, (chosen, other), f"{name}_integer" if integers else name)
            return replace(chosen, natural=all(value.natural for value in values))
        reals = tuple(self.as_real(node, value) for value in values)
        if name in ("isfinite", "isnan"):
            return Node("call", BOOLEAN, reals, name)
        found = reals[0] if name == "real" else Node("math", REAL, reals, "fabs" if name == "absolute" else name)
        return self._integer(node, found) if name in ("floor", "ceil") else found

    def _integer(self, node: ast.Call, value: Node) -> Node:
        """Return the integer that is next to a number towards zero."""
        if value.type == INTEGER:
            return value
        if value.type not in (REAL, BOOLEAN):
            raise self.refusal(node, "{} is no number")
        if value.type == BOOLEAN or self.symbols.fixed:
            return Node("integer", INTEGER, (value,), natural=value.type == BOOLEAN)
        return Node("call", INTEGER, (value,), "whole_number")

    def _call_address(self, node: ast.Call, values: list[Node]) -> Node:
        *places, row = values
        if row.type != Array(REAL, (None,)):
            raise self.refusal(node, "{}: the last argument must be an array of numbers")
        self.writes += 1
        row = self.named(node, row) if row.kind == "element" else self.placed(node, row)
        return Node("by address", None, (*places, row))

    def _bound(self, node: ast.Call, function: Callable[..., Any], given: list[Node]) -> list[Node]:
        """Return values of all arguments, in order: given in their place, by name, and defaults, as in Python."""
        signature = signature_of(function)
        if any(keyword.arg is None for keyword in node.keywords):
            raise self.refusal(node, "{}: name every argument, or give it in its place")
        if any(each.kind in (each.VAR_POSITIONAL, each.VAR_KEYWORD) for each in signature.parameters.values()):
            raise self.refusal(node, "{}: a kernel takes its arguments one by one, without *")
        named = {str(keyword.arg): self.read(keyword.value) for keyword in node.keywords}
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

    def _replaced(self, node: ast.Call, owner: ast.expr) -> Node:
        """Return a named tuple with other values of the fields that are named."""
        record = self.read(owner)
        kind = record.type
        if not isinstance(kind, Record) or kind.origin is None:
            raise self.refusal(node, f"{{}}: {ast.unparse(owner)} is no named tuple")
        names = [keyword.arg for keyword in node.keywords]
        if node.args or None in names:
            raise self.refusal(node, "{}: name every field that changes")
        if unknown := {str(name) for name in names} - {name for name, _ in kind.fields}:
            raise self.refusal(node, f"{{}}: {kind.name} has no field {min(unknown)}")
        given = {keyword.arg: self.read(keyword.value) for keyword in node.keywords}
        record = self.placed(node, record)
        values = [given.get(name) or record.member(name) for name, _ in kind.fields]
        return self._named_tuple(node, kind.origin, values)

    def _named_tuple(self, node: ast.Call, origin: Any, values: list[Node]) -> Node:
        for place, name in enumerate(origin._fields):  # integers given for real fields become real
            if values[place].type == INTEGER and origin.__annotations__.get(name) in (float, "float"):
                values[place] = self.as_real(node, values[place])
        return self.record(node, origin.__name__, origin._fields, values, origin)

    def _call_of(self, node: ast.Call, function: Any, given: list[Node]) -> Node:
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
        constants = tuple(map(self._relied_on, values))
        made = self.translate(function, kinds, constants, (self.kernel, node))
        self.files |= made.files
        self.meanings |= made.meanings
        if made.writes:
            self.writes += 1
            self._check_order(node, made.name)
        passed = [self.placed(node, value) if passed_by_pointer(value.type) else value for value in values]
        return Node("call", made.result, tuple(passed), made.name, made.constant, made.natural)

    def _relied_on(self, value: Node) -> float | str | None:
        """Return what a kernel may rely on of an argument."""
        is_known = self.symbols.fixed and value.constant is not None
        if value.type == REAL:
            return float(value.constant) if is_known and value.root is not None else None  # a parameter
        if value.type == INTEGER:
            return int(value.constant) if is_known else "natural" if value.natural else None
        return None


signature_of = cache(inspect.signature)
"""Signature of a kernel or of a class of named tuples."""

MATHEMATICS = "exp expm1 log log1p sin cos tan asin acos atan sinh cosh tanh asinh sqrt fabs floor ceil isfinite isnan"
"""Functions of ``math.h`` of one argument, which every machine has."""

OPERATIONS: dict[Any, tuple[str, int | None]] = {
    **{getattr(math, name): (name, 1) for name in MATHEMATICS.split()},
    **{getattr(math, name): (name, 2) for name in ("pow", "atan2", "copysign")},
    **{getattr(np, name): (name, 1) for name in ("isfinite", "isnan")},
    **{abs: ("absolute", 1), max: ("larger", None), min: ("smaller", None)},
    **{int: ("integer", 1), float: ("real", 1), natural: ("natural", 1), call: ("by address", 4)},
}
"""What kernels call beside each other, and how many arguments it takes, if not several."""
