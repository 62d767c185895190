"""Calls in kernels: of operations, of named tuples, of other kernels."""

import ast
import inspect
from collections.abc import Callable, Hashable
from functools import cache
from typing import TYPE_CHECKING, Any

from controllers.kernels.language import DISPATCHED
from controllers.kernels.operations import MATHEMATICS, OPERATIONS, operation
from controllers.kernels.sources import INSTEAD
from controllers.kernels.types import INTEGER, REAL, Record, Type, makes_itself
from controllers.kernels.values import Value

if TYPE_CHECKING:
    from controllers.kernels.expressions import Expressions


@cache
def signature_of(function: Callable[..., Any]) -> inspect.Signature:
    """Return the signature of a kernel or of a class of named tuples."""
    return inspect.signature(function)


class Calls:
    """Translates calls; the same for all functions of a unit."""

    def translate(self, expressions: "Expressions", node: ast.Call) -> Value:
        """Return a call in C; ``NotTranslatable`` where it has no translation."""
        if not expressions.is_global(node.func):
            if isinstance(node.func, ast.Attribute) and node.func.attr == "_replace":
                return self._replaced(expressions, node, node.func.value)
            raise expressions.kernel.refusal(node, f"{ast.unparse(node.func)} is no function of a module")
        function = expressions.unit.resolved(expressions.kernel, node.func)
        if not callable(function) or not isinstance(function, Hashable):
            raise expressions.kernel.refusal(node, f"{ast.unparse(node.func)} is no function")
        if function in MATHEMATICS or function in OPERATIONS:
            return operation(expressions, node, function)
        if isinstance(function, type) and issubclass(function, tuple) and hasattr(function, "_fields"):
            return self._record(expressions, node, function)
        return self._kernel(expressions, node, function)

    def _bound(
        self, expressions: "Expressions", node: ast.Call, function: Callable[..., Any], given: list[Value]
    ) -> list[Value]:
        """Return values of all arguments, in order: given in their place, by name, and defaults, as in Python."""
        kernel, shown, signature = expressions.kernel, ast.unparse(node), signature_of(function)
        if any(keyword.arg is None for keyword in node.keywords):
            raise kernel.refusal(node, f"{shown}: name every argument, or give it in its place")
        if any(each.kind in (each.VAR_POSITIONAL, each.VAR_KEYWORD) for each in signature.parameters.values()):
            raise kernel.refusal(node, f"{shown}: a kernel takes its arguments one by one, without *")
        named = {str(keyword.arg): expressions.translate(keyword.value) for keyword in node.keywords}
        try:
            bound = signature.bind(*given, **named).arguments
        except TypeError as error:
            problem = f"{shown}: {error}; name every argument, or give it in its place"
            raise kernel.refusal(node, problem) from None
        for name, parameter in signature.parameters.items():
            if name not in bound:
                bound[name] = expressions.known(node, parameter.default)
            if bound[name].type is None:
                raise kernel.refusal(node, f"{shown}: {name} cannot be passed; pass its elements")
        return [bound[name] for name in signature.parameters]

    def _record(self, expressions: "Expressions", node: ast.Call, origin: Any) -> Value:
        if makes_itself(origin):
            problem = f"{origin.__name__} has a __new__ of its own; write a kernel that makes a plain named tuple"
            raise expressions.kernel.refusal(node, problem)
        values = self._bound(expressions, node, origin, expressions.spread(node.args))
        return self._made(expressions, node, origin, values)

    def _replaced(self, expressions: "Expressions", node: ast.Call, owner: ast.expr) -> Value:
        """Return a named tuple with other values of the fields that are named."""
        record, shown, kernel = expressions.translate(owner), ast.unparse(node), expressions.kernel
        kind = record.type
        if not isinstance(kind, Record) or kind.origin is None:
            raise kernel.refusal(node, f"{shown}: {ast.unparse(owner)} is no named tuple")
        names = [keyword.arg for keyword in node.keywords]
        if node.args or None in names:
            raise kernel.refusal(node, f"{shown}: name every field that changes")
        if unknown := {str(name) for name in names} - {name for name, _ in kind.fields}:
            raise kernel.refusal(node, f"{shown}: {kind.name} has no field {min(unknown)}")
        given = {keyword.arg: expressions.translate(keyword.value) for keyword in node.keywords}
        record = expressions.placed(node, record)
        values = [given.get(name) or record.member(name) for name, _ in kind.fields]
        return self._made(expressions, node, kind.origin, values)

    def _made(self, expressions: "Expressions", node: ast.Call, origin: Any, values: list[Value]) -> Value:
        fields: list[tuple[str, Type]] = []
        for place, name in enumerate(origin._fields):  # integers given for real fields become real
            if values[place].type == INTEGER and origin.__annotations__.get(name) in (float, "float"):
                values[place] = expressions.as_real(node, values[place])
            kind = values[place].type
            if kind is None:
                raise expressions.kernel.refusal(node, f"{ast.unparse(node)}: a field has no value")
            fields.append((name, kind))
        record = Record(origin.__name__, tuple(fields), origin)
        return Value(expressions.unit.compound(record, values), record)

    def _kernel(self, expressions: "Expressions", node: ast.Call, function: Any) -> Value:
        kernel, unit, given = expressions.kernel, expressions.unit, expressions.spread(node.args)
        if function in DISPATCHED:
            first = given[0].type if given else None
            chosen = DISPATCHED[function].get(first.origin) if isinstance(first, Record) and first.origin else None
            if chosen is None:
                raise kernel.refusal(node, f"{ast.unparse(node)}: no kernel is registered for its first argument")
            function = chosen
        if not inspect.isfunction(function):
            instead = INSTEAD.get(function, "call mathematics or kernels")
            raise kernel.refusal(node, f"{ast.unparse(node.func)} has no translation; {instead}")
        values = self._bound(expressions, node, function, given)
        kinds = tuple(value.type for value in values if value.type is not None)
        constants = tuple(_known(value, unit.fixed) for value in values)
        translated = unit.function(function, kinds, constants, (kernel, node))
        if translated.writes:
            expressions.scope.writes += 1
            expressions.check_order(node, translated.name)
        texts = [expressions.passed(node, value) for value in values]
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
