"""Calls in kernels: of operations, of named tuples, of other kernels."""

import ast
import inspect
from collections.abc import Callable, Hashable
from functools import cache
from typing import Any

from controllers.kernels.language import DISPATCHED
from controllers.kernels.operations import MATHEMATICS, OPERATIONS, operation
from controllers.kernels.operators import Operators
from controllers.kernels.sources import INSTEAD
from controllers.kernels.types import INTEGER, REAL, Record, Type, makes_itself
from controllers.kernels.values import Value


@cache
def signature_of(function: Callable[..., Any]) -> inspect.Signature:
    """Return the signature of a kernel or of a class of named tuples."""
    return inspect.signature(function)


class Calls(Operators):
    """Translates calls, and so all expressions of a function."""

    def _call(self, node: ast.Call) -> Value:
        if not self.is_global(node.func):
            if isinstance(node.func, ast.Attribute) and node.func.attr == "_replace":
                return self._replaced(node, node.func.value)
            raise self.refusal(node, f"{ast.unparse(node.func)} is no function of a module")
        function = self.unit.resolved(self.kernel, node.func)
        if not callable(function) or not isinstance(function, Hashable):
            raise self.refusal(node, f"{ast.unparse(node.func)} is no function")
        if function in MATHEMATICS or function in OPERATIONS:
            return operation(self, node, function)
        if isinstance(function, type) and issubclass(function, tuple) and hasattr(function, "_fields"):
            return self._record(node, function)
        return self._call_of(node, function)

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
