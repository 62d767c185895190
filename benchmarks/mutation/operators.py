"""Mutations of a function: each changes one place of its syntax tree.

What is mutated is arithmetic, comparisons, numbers, ``min``/``max``/``abs``, boolean operators, branches, statements
that do something in place, and what is returned. Tuning constants at the head of a module stay: they are chosen by
benchmarks, and a test of their value would only repeat it. ``strict`` of ``zip`` stays as well: it says of lengths that
are equal by construction that they are.
"""

import __future__

import ast
import copy
import inspect
import textwrap
import tomllib
from collections.abc import Iterator
from dataclasses import dataclass
from functools import cache
from pathlib import Path
from types import CodeType, FunctionType
from typing import Any, NamedTuple

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

LISTED = tomllib.loads(Path(__file__).with_name("equivalent.toml").read_text(encoding="utf-8"))["mutants"]
EQUIVALENT = {(one["function"], one["before"], one["after"]): one["reason"] for one in LISTED}
"""Mutants that change nothing anybody could see, by key, each with the reason."""

BOUNDING = ("min", "max", "abs")


class Spot(NamedTuple):
    """A node of a syntax tree, and where it is."""

    node: ast.AST
    owner: Any  # owner, slot: the list or node that it is part of, and the index or field there
    slot: int | str
    body: list[Any]  # body, index: the innermost statement that holds it: the list that this stands in, and where
    index: int

    @property
    def line(self) -> str:
        """First line of that statement."""
        return ast.unparse(ast.fix_missing_locations(self.body[self.index])).splitlines()[0]


def spots(owner: Any, slot: int | str, body: list[Any], index: int) -> Iterator[Spot]:
    """Yield all nodes from a place on; annotations and docstrings hold nothing to mutate."""
    node = owner[slot] if isinstance(slot, int) else getattr(owner, slot)
    if isinstance(node, list):
        for place, item in enumerate(node):
            yield from spots(node, place, *((node, place) if isinstance(item, ast.stmt) else (body, index)))
    elif isinstance(node, ast.AST) and not (isinstance(node, ast.Expr) and isinstance(node.value, ast.Constant)):
        yield Spot(node, owner, slot, body, index)
        for field, _ in ast.iter_fields(node):
            if field != "annotation" and not (isinstance(node, ast.keyword) and node.arg == "strict"):
                yield from spots(node, field, body, index)


def spots_in(tree: ast.FunctionDef) -> list[Spot]:
    """Return all nodes of the body of a function."""
    return list(spots(tree, "body", [tree], 0))


@dataclass(frozen=True)
class Mutant:
    """One change of one function."""

    name: str  # full name of the function
    function: FunctionType  # the function
    place: int  # number of the node in its body
    changed: ast.AST  # what is put there

    @property
    def before(self) -> str:
        """Line of the statement that holds the change, without it."""
        return self._spot().line

    @property
    def after(self) -> str:
        """The same line with the change."""
        return self._changed()[1].line

    @property
    def line(self) -> int:
        """Line in the file."""
        spot = self._spot()
        return int(spot.body[spot.index].lineno)

    @property
    def key(self) -> tuple[str, str, str]:
        """What it is known by, whatever stands above it in the file."""
        return self.name, self.before, self.after

    def _spot(self) -> Spot:
        return _original_spots(self.function)[self.place]

    def _changed(self) -> tuple[ast.FunctionDef, Spot]:
        tree = syntax(self.function)
        spot = spots_in(tree)[self.place]
        if isinstance(spot.slot, int):
            spot.owner[spot.slot] = self.changed
        else:
            setattr(spot.owner, spot.slot, self.changed)
        return tree, spot

    def code(self) -> CodeType:
        """Return the code of the mutated function."""
        return compiled_code(self._changed()[0], self.function)

    def written(self) -> str:
        """Return the text of its file with the mutated function in it."""
        lines, first = inspect.getsourcelines(self.function)
        tree, _ = self._changed()
        tree.decorator_list = _parsed(self.function).decorator_list
        indent = lines[0][: len(lines[0]) - len(lines[0].lstrip())]
        every = Path(self.function.__code__.co_filename).read_text(encoding="utf-8").splitlines(keepends=True)
        every[first - 1 : first - 1 + len(lines)] = [textwrap.indent(ast.unparse(tree), indent) + "\n"]
        return "".join(every)


@cache
def _source(function: FunctionType) -> tuple[str, int]:
    """Return the text of a function and the line that it begins in."""
    lines, first = inspect.getsourcelines(function)
    return textwrap.dedent("".join(lines)), first


@cache
def _original_spots(function: FunctionType) -> list[Spot]:
    """Return all nodes of the body of a function, not to be changed."""
    return spots_in(syntax(function))


def _parsed(function: FunctionType) -> ast.FunctionDef:
    tree = ast.parse(_source(function)[0]).body[0]
    assert isinstance(tree, ast.FunctionDef)
    return tree


def syntax(function: FunctionType) -> ast.FunctionDef:
    """Return the syntax tree of a function, without decorators, with the line numbers of its file."""
    tree = _parsed(function)
    ast.increment_lineno(tree, _source(function)[1] - 1)
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
    for place, spot in enumerate(spots_in(tree)):
        for changed in _changes(spot.node, tree):
            yield Mutant(name, function, place, changed)


def marked_code(mutants: dict[int, Mutant], mark: str) -> CodeType:
    """Return the code of their function that calls what ``mark`` names with the number of each mutant on its line."""
    function = next(iter(mutants.values())).function
    tree = syntax(function)
    found = spots_in(tree)
    for number, mutant in sorted(mutants.items(), key=lambda one: -found[one[1].place].index):
        spot = found[mutant.place]
        spot.body.insert(spot.index, ast.parse(f"{mark}({number})").body[0])
    return compiled_code(tree, function)


def _with(node: ast.AST, **fields: Any) -> ast.AST:
    changed = copy.deepcopy(node)
    for name, value in fields.items():
        setattr(changed, name, value)
    return changed


def _changes(node: Any, function: ast.FunctionDef) -> Iterator[ast.AST]:
    """Yield what may stand in for a node."""
    match node:
        case ast.BinOp() | ast.AugAssign():
            if type(node.op) in ARITHMETIC:
                yield _with(node, op=ARITHMETIC[type(node.op)]())
        case ast.Compare():
            for index, operator in enumerate(node.ops):
                for other in COMPARISONS.get(type(operator), ()):
                    yield _with(node, ops=[*node.ops[:index], other(), *node.ops[index + 1 :]])
        case ast.Constant(value=bool(value)):
            yield ast.Constant(not value)
        case ast.Constant(value=int(value)):
            yield ast.Constant(value + 1)
        case ast.Constant(value=float(value)):
            yield ast.Constant(2.0 * value if value not in (0.0, 1.0) else 1.0 - value)
        case ast.UnaryOp(op=ast.USub() | ast.Not()):
            yield node.operand
        case ast.Call(func=ast.Name(id=name)) if name in BOUNDING:
            yield from node.args
        case ast.BoolOp():
            yield _with(node, op=ast.Or() if isinstance(node.op, ast.And) else ast.And())
        case ast.If() | ast.IfExp():
            yield _with(node, test=ast.Constant(True))
            yield _with(node, test=ast.Constant(False))
        case ast.Expr(value=ast.Call()):
            yield ast.Pass()
        case ast.Return():
            yield from _returned(node, function)


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
