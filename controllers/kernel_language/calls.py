"""Calls in kernels: of operations, of named tuples, of other kernels."""

import ast
import inspect
from collections.abc import Hashable
from typing import TYPE_CHECKING, Any

from llvmlite import ir

from controllers.kernel_language.dispatch import DISPATCHED
from controllers.kernel_language.kinds import ADDRESS, INTEGER, Array, Record, makes_itself, record_of
from controllers.kernel_language.operations import MATHEMATICS, OPERATIONS, operation
from controllers.kernel_language.sources import INSTEAD
from controllers.kernel_language.values import Value

if TYPE_CHECKING:
    from controllers.kernel_language.expressions import Expressions


def translate_call(expressions: "Expressions", node: ast.Call) -> Value:
    """Return the value of a call; ``NotTranslatable`` where it has none."""
    if not expressions.is_global(node.func):
        if isinstance(node.func, ast.Attribute) and node.func.attr == "_replace":
            return _replaced(expressions, node, node.func.value)
        raise expressions.refusal(node, f"{ast.unparse(node.func)} is no function of a module")
    function = expressions.resolved(node.func)
    if not callable(function) or not isinstance(function, Hashable):
        raise expressions.refusal(node, f"{ast.unparse(node.func)} is no function")
    if function in MATHEMATICS or function in OPERATIONS:
        return operation(expressions, node, function)
    if isinstance(function, type) and issubclass(function, tuple) and hasattr(function, "_fields"):
        return _record(expressions, node, function)
    return _kernel(expressions, node, function)


def _bound(expressions: "Expressions", node: ast.Call, signature: inspect.Signature, given: list[Value]) -> list[Value]:
    """Return the values of all arguments, in order: those given in their place, by name, and defaults, as in Python."""
    shown = ast.unparse(node)
    if any(keyword.arg is None for keyword in node.keywords):
        raise expressions.refusal(node, f"{shown}: name every argument, or give it in its place")
    if any(each.kind in (each.VAR_POSITIONAL, each.VAR_KEYWORD) for each in signature.parameters.values()):
        raise expressions.refusal(node, f"{shown}: a kernel takes its arguments one by one, without *")
    named = {str(keyword.arg): expressions.translate(keyword.value) for keyword in node.keywords}
    try:
        bound = signature.bind(*given, **named).arguments
    except TypeError as error:
        raise expressions.refusal(node, f"{shown}: {error}; name every argument, or give it in its place") from None
    for name, parameter in signature.parameters.items():
        if name not in bound:
            bound[name] = expressions.known(node, parameter.default)
        if bound[name].kind is None:
            raise expressions.refusal(node, f"{shown}: {name} cannot be passed; pass its elements")
    return [bound[name] for name in signature.parameters]


def _record(expressions: "Expressions", node: ast.Call, origin: Any) -> Value:
    if makes_itself(origin):
        problem = f"{origin.__name__} has a __new__ of its own; write a kernel that makes a plain named tuple"
        raise expressions.refusal(node, problem)
    return _made(
        expressions, node, origin, _bound(expressions, node, inspect.signature(origin), expressions.spread(node.args))
    )


def _replaced(expressions: "Expressions", node: ast.Call, owner: ast.expr) -> Value:
    """Return a named tuple with other values of the fields that are named."""
    record, shown = expressions.translate(owner), ast.unparse(node)
    if not isinstance(record.kind, Record) or not record.kind.origin:
        raise expressions.refusal(node, f"{shown}: {ast.unparse(owner)} is no named tuple")
    names = [keyword.arg for keyword in node.keywords]
    if node.args or None in names:
        raise expressions.refusal(node, f"{shown}: name every field that changes")
    if unknown := set(names) - set(record.kind.places):
        raise expressions.refusal(node, f"{shown}: {record.kind.origin.__name__} has no field {min(map(str, unknown))}")
    given = {keyword.arg: expressions.translate(keyword.value) for keyword in node.keywords}
    values = [given.get(name) or expressions.body.member(record, place) for name, place in record.kind.places.items()]
    return _made(expressions, node, record.kind.origin, values)


def _made(expressions: "Expressions", node: ast.Call, origin: Any, values: list[Value]) -> Value:
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
        instead = INSTEAD.get(function, "call mathematics or kernels")
        raise expressions.refusal(node, f"{ast.unparse(node.func)} has no translation; {instead}")
    values = _bound(expressions, node, inspect.signature(function), given)
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
