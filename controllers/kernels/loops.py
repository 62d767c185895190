"""Loops over ranges in C."""

import ast

from controllers.kernels.calls import Calls
from controllers.kernels.names import c_name
from controllers.kernels.types import INTEGER
from controllers.kernels.values import Value


def loop_header(expressions: Calls, statement: ast.For) -> tuple[str, str, bool, bool | None]:
    """Return the first line of a loop, its counter in C, whether that is natural, and whether it runs if that is known.

    Python evaluates the range once, C its end each time: what the end depends on must stay as it is in the loop.
    """
    kernel, scope = expressions.kernel, expressions.scope
    start, end, stride, read = _range(expressions, statement)
    assert isinstance(statement.target, ast.Name)
    target = statement.target.id
    changed = {node.id for part in statement.body for node in ast.walk(part) if _is_stored(node)}  # type: ignore[attr-defined]
    if fixed := (read | {target}) & changed - {"_"}:
        names = ", ".join(sorted(fixed))
        raise kernel.refusal(statement, f"{names} may not change in the loop over {ast.unparse(statement.iter)}")
    runs: bool | None = None
    if start.constant is not None and end.constant is not None:
        runs = start.constant < end.constant if stride == 1 else start.constant > end.constant
    first, last = _literal(start), _literal(end)
    name = scope.fresh("turn") if target == "_" and target in scope.variables else c_name(target)
    kind = "int" if start.constant is not None or start.root in scope.counters else "int64_t"
    if not expressions.unit.fixed:
        kind = "int64_t"
    if kind == "int":
        scope.counters.add(target)
    natural = start.natural if stride == 1 else end.natural or end.constant == -1
    sign, change = ("<", "++") if stride == 1 else (">", "--")
    return f"for ({kind} {name} = {first.text}; {name} {sign} {last.text}; {name}{change}) {{", name, natural, runs


def _range(expressions: Calls, statement: ast.For) -> tuple[Value, Value, int, set[str]]:
    """Return start, end and stride of a range, and the names that these depend on."""
    kernel, call = expressions.kernel, statement.iter
    shown = ast.unparse(statement).partition("\n")[0]
    if not isinstance(call, ast.Call) or not _is_range(expressions, call) or not isinstance(statement.target, ast.Name):
        raise kernel.refusal(statement, f"{shown!r} has no translation; write for i in range(...)")
    ends = expressions.spread(call.args)
    stride = ends[2].constant if len(ends) == 3 else 1
    are_integers = 1 <= len(ends) <= 3 and all(end.type == INTEGER for end in ends)
    if not are_integers or stride not in (1, -1) or statement.orelse:
        raise kernel.refusal(
            statement, f"{shown!r} has no translation; a range must be of integers, by 1 or -1, without else"
        )
    read = {node.id for argument in call.args for node in ast.walk(argument) if isinstance(node, ast.Name)}
    start = ends[0] if len(ends) > 1 else Value("0", INTEGER, constant=0, natural=True)
    return start, ends[min(len(ends) - 1, 1)], stride, read


def _is_range(expressions: Calls, call: ast.Call) -> bool:
    is_global = not call.keywords and expressions.is_global(call.func)
    return is_global and expressions.unit.resolved(expressions.kernel, call.func) is range


def _literal(value: Value) -> Value:
    """Return a known integer as such, but for constants of modules, whose names say more."""
    plain = value.constant is None or value.text == value.text.upper()
    return value if plain else Value(str(value.constant), INTEGER, constant=value.constant)


def _is_stored(node: ast.AST) -> bool:
    return isinstance(node, ast.Name) and isinstance(node.ctx, ast.Store)
