"""Mutations of a kernel: each changes one place of its syntax tree.

What is mutated is arithmetic, comparisons, numbers, ``min``/``max``/``abs``, boolean operators, branches, statements
that do something in place, and what is returned. Tuning constants at the head of a module stay: they are chosen by
benchmarks, and a test of their value would only repeat it.
"""

import __future__

import ast
import copy
import inspect
import textwrap
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from types import CodeType, FunctionType
from typing import Any

ARITHMETIC: dict[type, type] = {ast.Add: ast.Sub, ast.Sub: ast.Add, ast.Mult: ast.Div, ast.Div: ast.Mult}
ARITHMETIC[ast.Pow] = ast.Mult

COMPARISONS: dict[type, tuple[type, ...]] = {
    ast.Lt: (ast.LtE, ast.GtE),
    ast.LtE: (ast.Lt, ast.Gt),
    ast.Gt: (ast.GtE, ast.LtE),
    ast.GtE: (ast.Gt, ast.Lt),
    ast.Eq: (ast.NotEq,),
    ast.NotEq: (ast.Eq,),
}
"""What stands in for a comparison: its boundary moved, and its opposite."""

BOUNDING = ("min", "max", "abs")

Place = tuple[str | int, ...]


@dataclass(frozen=True)
class Mutant:
    """One change of one kernel.

    Attributes
    ----------
    module, function : str
        Where it is.
    line : int
        Line in the file.
    before, after : str
        The statement that holds the change, without and with it.
    place : tuple
        Way to the node from the root of the function's syntax tree.
    changed : ast.AST
        What is put there.
    """

    module: str
    function: str
    line: int
    before: str
    after: str
    place: Place
    changed: ast.AST

    @property
    def key(self) -> tuple[str, str, str]:
        """What it is known by, whatever stands above it in the file."""
        return f"{self.module}.{self.function}", self.before, self.after

    def code(self, function: FunctionType) -> CodeType:
        """Return the code of the mutated function."""
        tree = copy.deepcopy(syntax(function))
        _put(tree, self.place, self.changed)
        return compiled_code(tree, function)


def syntax(function: FunctionType) -> ast.FunctionDef:
    """Return the syntax tree of a function, without decorators, with the line numbers of its file."""
    lines, first = inspect.getsourcelines(function)
    tree = ast.parse(textwrap.dedent("".join(lines))).body[0]
    assert isinstance(tree, ast.FunctionDef)
    ast.increment_lineno(tree, first - 1)
    tree.decorator_list = []
    return tree


def compiled_code(tree: ast.FunctionDef, function: FunctionType) -> CodeType:
    """Return the code of a syntax tree that stands in for a function."""
    module = ast.fix_missing_locations(ast.Module([tree], []))
    names = dict(function.__globals__)
    flags = __future__.annotations.compiler_flag
    exec(compile(module, function.__code__.co_filename, "exec", flags), names)
    code: CodeType = names[function.__name__].__code__
    return code


def mutants(function: FunctionType) -> Iterator[Mutant]:
    """Yield every mutant of a function."""
    tree = syntax(function)
    for place, node in _nodes(tree.body, ("body",)):
        for changed in _changes(node, tree):
            mutated = copy.deepcopy(tree)
            _put(mutated, place, changed)
            line, before = _statement(tree, place)
            yield Mutant(
                function.__module__, function.__name__, line, before, _statement(mutated, place)[1], place, changed
            )


def _statement(tree: ast.AST, place: Place) -> tuple[int, str]:
    """Return line and text, the first line of it, of the innermost statement on the way to a place."""
    found: Any = tree
    node: Any = tree
    for step in place:
        node = node[step] if isinstance(step, int) else getattr(node, step, None)
        if isinstance(node, ast.stmt):
            found = node
    return getattr(found, "lineno", 0), ast.unparse(ast.fix_missing_locations(found)).splitlines()[0]


def _nodes(node: Any, place: Place) -> Iterator[tuple[Place, ast.AST]]:
    """Yield all nodes with the way to them; annotations and docstrings hold nothing to mutate."""
    if isinstance(node, list):
        for index, item in enumerate(node):
            yield from _nodes(item, (*place, index))
    elif isinstance(node, ast.AST) and not _is_docstring(node):
        yield place, node
        for field, item in ast.iter_fields(node):
            if field != "annotation":
                yield from _nodes(item, (*place, field))


def _is_docstring(node: ast.AST) -> bool:
    return isinstance(node, ast.Expr) and isinstance(node.value, ast.Constant)


def _put(tree: ast.AST, place: Place, node: ast.AST) -> None:
    target: Any = tree
    for step in place[:-1]:
        target = target[step] if isinstance(step, int) else getattr(target, step)
    last = place[-1]
    if isinstance(last, int):
        target[last] = node
    else:
        setattr(target, last, node)


def _changes(node: ast.AST, function: ast.FunctionDef) -> Iterator[ast.AST]:
    for kind, change in CHANGES.items():
        if isinstance(node, kind):
            yield from change(node, function)


def _with(node: ast.AST, **fields: Any) -> ast.AST:
    changed = copy.deepcopy(node)
    for name, value in fields.items():
        setattr(changed, name, value)
    return changed


def _arithmetic(node: Any, function: ast.FunctionDef) -> Iterator[ast.AST]:
    if type(node.op) in ARITHMETIC:
        yield _with(node, op=ARITHMETIC[type(node.op)]())


def _comparison(node: ast.Compare, function: ast.FunctionDef) -> Iterator[ast.AST]:
    for index, operator in enumerate(node.ops):
        for other in COMPARISONS.get(type(operator), ()):
            yield _with(node, ops=[*node.ops[:index], other(), *node.ops[index + 1 :]])


def _number(node: ast.Constant, function: ast.FunctionDef) -> Iterator[ast.AST]:
    value = node.value
    if isinstance(value, bool):
        yield ast.Constant(not value)
    elif isinstance(value, int):
        yield ast.Constant(value + 1)
    elif isinstance(value, float):
        yield ast.Constant(2.0 * value if value not in (0.0, 1.0) else 1.0 - value)


def _sign(node: ast.UnaryOp, function: ast.FunctionDef) -> Iterator[ast.AST]:
    if isinstance(node.op, ast.USub | ast.Not):
        yield node.operand


def _bounding(node: ast.Call, function: ast.FunctionDef) -> Iterator[ast.AST]:
    if isinstance(node.func, ast.Name) and node.func.id in BOUNDING:
        yield from node.args


def _boolean(node: ast.BoolOp, function: ast.FunctionDef) -> Iterator[ast.AST]:
    yield _with(node, op=ast.Or() if isinstance(node.op, ast.And) else ast.And())


def _branch(node: Any, function: ast.FunctionDef) -> Iterator[ast.AST]:
    yield _with(node, test=ast.Constant(True))
    yield _with(node, test=ast.Constant(False))


def _in_place(node: ast.Expr, function: ast.FunctionDef) -> Iterator[ast.AST]:
    if isinstance(node.value, ast.Call):
        yield ast.Pass()


def _returned(node: ast.Return, function: ast.FunctionDef) -> Iterator[ast.AST]:
    """Yield what stands in for what is returned: its opposite, or for a state the one that came in."""
    kind = ast.unparse(function.returns) if function.returns is not None else "None"
    zero = isinstance(node.value, ast.Constant) and node.value.value == 0.0  # has no opposite
    if kind == "float" and not zero:
        yield ast.Return(ast.UnaryOp(ast.USub(), node.value))  # type: ignore[arg-type]
    elif kind == "bool" and not isinstance(node.value, ast.Constant):
        yield ast.Return(ast.UnaryOp(ast.Not(), node.value))  # type: ignore[arg-type]
    for argument in function.args.args:
        name = ast.Name(argument.arg, ast.Load())
        alike = argument.annotation is not None and ast.unparse(argument.annotation) == kind
        if alike and kind[0].isupper() and ast.unparse(name) != ast.unparse(node.value or name):
            yield ast.Return(name)


CHANGES: dict[Any, Callable[[Any, ast.FunctionDef], Iterator[ast.AST]]] = {
    (ast.BinOp, ast.AugAssign): _arithmetic,
    ast.Compare: _comparison,
    ast.Constant: _number,
    ast.UnaryOp: _sign,
    ast.Call: _bounding,
    ast.BoolOp: _boolean,
    (ast.If, ast.IfExp): _branch,
    ast.Expr: _in_place,
    ast.Return: _returned,
}
"""Mutations by kind of node."""
