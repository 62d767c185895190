"""Loops over ranges in C."""

import ast

from adaptive_ff.export.expressions import Expressions
from adaptive_ff.export.names import c_name
from adaptive_ff.export.types import INTEGER
from adaptive_ff.export.values import Value


def loop_header(expressions: Expressions, statement: ast.For) -> tuple[str, bool]:
    """Return the first line of a loop, and whether it runs at all where its length is known.

    Python evaluates the range once, C its end each time: what the end depends on must stay as it is in the loop.
    """
    kernel, call, target = expressions.kernel, statement.iter, statement.target
    over_range = isinstance(call, ast.Call) and ast.unparse(call.func) == "range" and 1 <= len(call.args) <= 3
    if not isinstance(call, ast.Call) or not over_range or not isinstance(target, ast.Name) or statement.orelse:
        shown = ast.unparse(statement).partition("\n")[0]
        raise kernel.refusal(statement, f"{shown!r} has no translation; write for i in range(...), without else")
    values = [expressions.translate(argument) for argument in call.args]
    if any(value.type != INTEGER for value in values):
        raise kernel.refusal(statement, f"{ast.unparse(call)} must be over integers")
    changed = {node.id for part in statement.body for node in ast.walk(part) if _is_stored(node)}  # type: ignore[attr-defined]
    read = {node.id for argument in call.args for node in ast.walk(argument) if isinstance(node, ast.Name)}
    if (read | {target.id}) & changed:
        names = ", ".join(sorted((read | {target.id}) & changed))
        raise kernel.refusal(statement, f"{names} may not change in the loop over {ast.unparse(call)}")
    start = values[0] if len(values) > 1 else Value("0", INTEGER, constant=0)
    end = values[1] if len(values) > 1 else values[0]
    stride = values[2].constant if len(values) == 3 else 1
    if stride not in (1, -1):
        raise kernel.refusal(statement, f"{ast.unparse(call)} must go by 1 or -1")
    known = start.constant is not None and end.constant is not None
    runs = not known or (start.constant < end.constant if stride == 1 else start.constant > end.constant)
    start, end = _literal(start), _literal(end)
    name = c_name(target.id)
    kind = "int" if start.constant is not None or start.root in expressions.scope.counters else "int64_t"
    if kind == "int":
        expressions.scope.counters.add(target.id)
    sign, change = ("<", "++") if stride == 1 else (">", "--")
    return f"for ({kind} {name} = {start.text}; {name} {sign} {end.text}; {name}{change}) {{", runs


def _literal(value: Value) -> Value:
    """Return a known integer as such, but for constants of modules, whose names say more."""
    plain = value.constant is None or value.text == value.text.upper()
    return value if plain else Value(str(value.constant), INTEGER, constant=value.constant)


def _is_stored(node: ast.AST) -> bool:
    return isinstance(node, ast.Name) and isinstance(node.ctx, ast.Store)
