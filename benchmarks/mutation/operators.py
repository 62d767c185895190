"""Mutations of a function: each changes one place of its syntax tree.

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
from pathlib import Path
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
    """One change of one function."""

    name: str  # full name of the function
    function: FunctionType  # the function
    place: Place  # way to the node from the root of the function's syntax tree
    changed: ast.AST  # what is put there

    @property
    def before(self) -> str:
        """Line of the statement that holds the change, without it."""
        return first_line(syntax(self.function), self.place)

    @property
    def after(self) -> str:
        """The same line with the change."""
        return first_line(self._tree(), self.place)

    @property
    def line(self) -> int:
        """Line in the file."""
        body, index = statement(syntax(self.function), self.place)
        return int(body[index].lineno)

    @property
    def key(self) -> tuple[str, str, str]:
        """What it is known by, whatever stands above it in the file."""
        return self.name, self.before, self.after

    def _tree(self) -> ast.FunctionDef:
        tree = syntax(self.function)
        _put(tree, self.place, self.changed)
        return tree

    def code(self) -> CodeType:
        """Return the code of the mutated function."""
        return compiled_code(self._tree(), self.function)

    def written(self) -> str:
        """Return the text of its file with the mutated function in it."""
        lines, first = inspect.getsourcelines(self.function)
        tree = self._tree()
        tree.decorator_list = _parsed(self.function).decorator_list
        indent = lines[0][: len(lines[0]) - len(lines[0].lstrip())]
        every = Path(self.function.__code__.co_filename).read_text(encoding="utf-8").splitlines(keepends=True)
        every[first - 1 : first - 1 + len(lines)] = [textwrap.indent(ast.unparse(tree), indent) + "\n"]
        return "".join(every)


def _parsed(function: FunctionType) -> ast.FunctionDef:
    tree = ast.parse(textwrap.dedent("".join(inspect.getsourcelines(function)[0]))).body[0]
    assert isinstance(tree, ast.FunctionDef)
    return tree


def syntax(function: FunctionType) -> ast.FunctionDef:
    """Return the syntax tree of a function, without decorators, with the line numbers of its file."""
    tree = _parsed(function)
    ast.increment_lineno(tree, inspect.getsourcelines(function)[1] - 1)
    tree.decorator_list = []
    return tree


def compiled_code(tree: ast.FunctionDef, function: FunctionType) -> CodeType:
    """Return the code of a syntax tree that stands in for a function."""
    tree.args.defaults = [ast.Constant(None) for _ in tree.args.defaults]  # they stay those of the function
    tree.args.kw_defaults = [node and ast.Constant(None) for node in tree.args.kw_defaults]
    module = ast.fix_missing_locations(ast.Module([tree], []))
    names = dict(function.__globals__)
    flags = __future__.annotations.compiler_flag
    exec(compile(module, function.__code__.co_filename, "exec", flags), names)
    code: CodeType = names[function.__name__].__code__
    return code


def mutants(name: str, function: FunctionType) -> Iterator[Mutant]:
    """Yield every mutant of a function."""
    tree = syntax(function)
    for place, node in _nodes(tree.body, ("body",)):
        for changed in _changes(node, tree):
            yield Mutant(name, function, place, changed)


def statement(tree: ast.AST, place: Place) -> tuple[list[Any], int]:
    """Return the innermost statement on the way to a place: the list that it stands in, and where."""
    node: Any = tree
    found: tuple[list[Any], int] = ([tree], 0)
    for step in place:
        following = node[step] if isinstance(step, int) else getattr(node, step, None)
        if isinstance(step, int) and isinstance(following, ast.stmt):
            found = node, step
        node = following
    return found


def first_line(tree: ast.AST, place: Place) -> str:
    """Return the first line of that statement."""
    body, index = statement(tree, place)
    return ast.unparse(ast.fix_missing_locations(body[index])).splitlines()[0]


def marked_code(mutants: dict[int, Mutant], mark: str) -> CodeType:
    """Return the code of their function that calls what ``mark`` names with the number of each mutant on its line."""
    function = next(iter(mutants.values())).function
    tree = syntax(function)
    places = [(*statement(tree, mutant.place), number) for number, mutant in mutants.items()]
    for body, index, number in sorted(places, key=lambda place: -place[1]):
        body.insert(index, ast.parse(f"{mark}({number})").body[0])
    return compiled_code(tree, function)


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
