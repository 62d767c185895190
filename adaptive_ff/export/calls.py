"""Calls in kernels: of mathematics, of named tuples, of other kernels."""

import ast
import inspect
import math
from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

import numpy as np

from adaptive_ff.export.types import BOOLEAN, INTEGER, REAL, Record, Type
from adaptive_ff.export.values import UNARY, Value
from controllers.kernel_language.dispatch import DISPATCHED
from controllers.kernel_language.sources import read_kernel, resolve

if TYPE_CHECKING:
    from adaptive_ff.export.expressions import Expressions

LIBRARY: dict[Any, str] = {
    math.exp: "exp",
    math.expm1: "expm1",
    math.asinh: "asinh",
    math.log: "log",
    math.sqrt: "sqrt",
    math.pow: "pow",
    math.sin: "sin",
    math.cos: "cos",
    math.copysign: "copysign",
    math.fabs: "fabs",
    abs: "fabs",
}
"""Functions of ``math.h``; every machine has them, and copysign and fabs are instructions."""

TESTS: dict[Any, str] = {math.isfinite: "isfinite", np.isfinite: "isfinite", math.isnan: "isnan"}

CHOICES: dict[Any, str] = {max: "larger", min: "smaller"}


class Calls:
    """Translates calls; the same for all functions of a unit."""

    def translate(self, expressions: "Expressions", node: ast.Call) -> Value:
        """Return a call in C; ``NotExportable`` where it has no translation."""
        if isinstance(node.func, ast.Attribute) and node.func.attr == "_replace":
            return self._replaced(expressions, node, node.func.value)
        function = resolve(expressions.kernel, node.func)
        if function in LIBRARY and not node.keywords:
            arguments = [expressions.real(argument).text for argument in node.args]
            return Value(expressions.unit.library(LIBRARY[function], *arguments), REAL)
        if function in TESTS:
            return Value(f"{TESTS[function]}({expressions.real(node.args[0]).text})", BOOLEAN)
        if function in CHOICES:
            return self._choice(expressions, node, CHOICES[function])
        if function is int:
            value = expressions.translate(node.args[0])
            converted = Value(f"(int64_t){value.within(UNARY)}", INTEGER, UNARY)
            return value if value.type == INTEGER else converted
        if function is float:
            return expressions.real(node.args[0])
        if isinstance(function, type) and issubclass(function, tuple) and hasattr(function, "_fields"):
            return self._record(expressions, node, function)
        return self._kernel(expressions, node, function)

    def _choice(self, expressions: "Expressions", node: ast.Call, name: str) -> Value:
        """Return the larger or smaller of values; of equal ones, or beside what is no number, the first, as Python."""
        if len(node.args) < 2 or node.keywords:
            raise expressions.kernel.refusal(node, f"{ast.unparse(node)}: give the values one by one")
        values = [expressions.translate(argument) for argument in node.args]
        if all(value.type == INTEGER for value in values):
            name, kind = f"{name}_integer", INTEGER
        else:
            values, kind = [expressions.as_real(node, value) for value in values], REAL
        text = values[0].text
        for value in values[1:]:
            text = expressions.unit.helper(name, text, value.text)
        return Value(text, kind)

    def _record(self, expressions: "Expressions", node: ast.Call, origin: Any) -> Value:
        signature = inspect.signature(origin)
        given = self._arguments(expressions, node, list(signature.parameters))
        for name, parameter in signature.parameters.items():
            if name not in given:
                given[name] = expressions.known(node, parameter.default)
        return self._made(expressions, node, origin, [given[name] for name in signature.parameters])

    def _replaced(self, expressions: "Expressions", node: ast.Call, owner: ast.expr) -> Value:
        """Return a named tuple with other values of the fields that are named."""
        record, shown = expressions.translate(owner), ast.unparse(node)
        kind = record.type
        if not isinstance(kind, Record) or kind.origin is None:
            raise expressions.kernel.refusal(node, f"{shown}: {ast.unparse(owner)} is no named tuple")
        if node.args:
            raise expressions.kernel.refusal(node, f"{shown}: name every field that changes")
        names = [name for name, _ in kind.fields]
        given = self._arguments(expressions, node, names)
        if not record.root:
            root = expressions.hoisted(node, record)
            record = Value(root, kind, root=root)
        values = [given[name] if name in given else record.member(name) for name in names]
        return self._made(expressions, node, kind.origin, values)

    def _made(self, expressions: "Expressions", node: ast.Call, origin: Any, values: list[Value]) -> Value:
        kinds = [value.type for value in values]
        if None in kinds:
            raise expressions.kernel.refusal(node, f"{ast.unparse(node)}: a field has no value")
        fields = tuple((name, kind) for name, kind in zip(origin._fields, kinds, strict=True) if kind is not None)
        declared = expressions.unit.record_like(origin)
        if declared is not None:  # integers given for real fields become real
            for place, (name, kind) in enumerate(declared.fields):
                if kind == REAL and values[place].type == INTEGER:
                    values[place] = expressions.as_real(node, values[place])
                    fields = (*fields[:place], (name, REAL), *fields[place + 1 :])
        record = Record(origin.__name__, fields, origin)
        return Value(expressions.unit.compound(record, values), record)

    def _arguments(self, expressions: "Expressions", node: ast.Call, names: Sequence[str]) -> dict[str, Value]:
        given: list[Value] = []
        for argument in node.args:
            if isinstance(argument, ast.Starred):
                given += expressions._spread(argument.value)
            else:
                given.append(expressions.translate(argument))
        if len(given) > len(names):
            raise expressions.kernel.refusal(node, f"{ast.unparse(node)} gives too many arguments")
        bound = dict(zip(names, given, strict=False))
        for keyword in node.keywords:
            if keyword.arg is None or keyword.arg not in names:
                raise expressions.kernel.refusal(
                    node, f"{ast.unparse(node)}: name every argument, or give it in its place"
                )
            bound[keyword.arg] = expressions.translate(keyword.value)
        return bound

    def _kernel(self, expressions: "Expressions", node: ast.Call, function: Any) -> Value:
        kernel, unit = expressions.kernel, expressions.unit
        if not inspect.isfunction(function):
            allowed = "abs, min, max, int, float, math.exp, expm1, log, sqrt, pow, sin, cos, asinh, copysign, fabs"
            allowed += ", isfinite, isnan"
            raise kernel.refusal(node, f"{ast.unparse(node.func)} has no translation; there are {allowed} and kernels")
        if function in DISPATCHED:
            first = expressions.translate(node.args[0]).type
            chosen = DISPATCHED[function].get(first.origin) if isinstance(first, Record) and first.origin else None
            if chosen is None:
                raise kernel.refusal(node, f"{ast.unparse(node)}: no kernel is registered for its first argument")
            function = chosen
        parameters = read_kernel(function).tree.args
        names = [argument.arg for argument in (*parameters.args, *parameters.kwonlyargs)]
        bound = self._arguments(expressions, node, names)
        defaults = inspect.signature(function).parameters
        for name in names:
            if name not in bound:
                if defaults[name].default is inspect.Parameter.empty:
                    raise kernel.refusal(node, f"{ast.unparse(node)} gives no {name}")
                bound[name] = expressions.known(node, defaults[name].default)
        values = [bound[name] for name in names]
        kinds: list[Type] = []
        for value in values:
            if value.type is None:
                raise kernel.refusal(node, f"{ast.unparse(node)}: {value.text} cannot be passed; pass its elements")
            kinds.append(value.type)
        constants = tuple(value.constant if value.type == INTEGER else None for value in values)
        translated = unit.function(function, tuple(kinds), constants, (kernel, node))
        if translated.writes:
            expressions.scope.writes = True
            expressions.check_order(node, translated.name)
        texts = [expressions.passed(node, value) for value in values]
        text = f"{translated.name}({', '.join(texts)})"
        return Value(text, translated.result, constant=translated.constant)
