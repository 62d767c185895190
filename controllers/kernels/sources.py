"""Sources of kernels: syntax tree, comments, where it stands, and what its global names stand for."""

import ast
import builtins
import importlib
import importlib.util
import inspect
import io
import math
import os
import sys
import tokenize
from collections.abc import Callable
from contextlib import suppress
from dataclasses import dataclass
from enum import Enum
from functools import cache, cached_property
from pathlib import Path
from types import ModuleType
from typing import Any

from controllers.kernels.language import NotTranslatable

KERNEL_PACKAGES = ("plant", "controllers", "adaptive_ff")
"""Packages of one folder, whose kernels are known by their names."""

INSTEAD: dict[Any, str] = {
    len: "write .size or .shape of an array",
    round: "write math.floor(x + 0.5)",
    sum: "write a loop over a range",
    math.hypot: "write math.sqrt(x * x + y * y)",
}
"""What to write instead of functions that have no translation."""


@dataclass(frozen=True)
class Kernel:
    """One function to translate."""

    function: Callable[..., Any]  # the function
    tree: ast.FunctionDef  # its syntax; line numbers are those of the file
    path: str  # its file, relative to the folder that holds the package
    file: Path  # its file

    @property
    def name(self) -> str:
        """Name of the function."""
        return self.tree.name

    @cached_property
    def nodes(self) -> list[ast.AST]:
        """All nodes of its syntax."""
        return list(ast.walk(self.tree))

    @property
    def comments(self) -> dict[int, tuple[str, bool]]:
        """``#`` comments in its file by line; whether each has its line for itself."""
        return _comments(self.file)

    def refusal(self, node: ast.AST, problem: str) -> NotTranslatable:
        """Return the error for a node, shown in place of {}, that has no translation; it says what to write instead."""
        line = getattr(node, "lineno", self.tree.lineno)
        text = problem.replace("{}", ast.unparse(node)) if "{}" in problem else problem
        return NotTranslatable(f"{self.path}:{line}: {self.name}: {text}")


@dataclass(frozen=True)
class Constant:
    """A named number of a module, or a member of an enumeration."""

    name: str
    value: Any
    doc: str


def identity(thing: Any) -> str:
    """Return what tells a function or class from others: its name and, as scripts may share names, a foreign file."""
    module, name = getattr(thing, "__module__", None) or "", getattr(thing, "__qualname__", "")
    file = getattr(sys.modules.get(module), "__file__", None) if isinstance(thing, type) else None
    file = getattr(getattr(thing, "__code__", None), "co_filename", file)  # of what is compiled there is none
    is_ours = not file or module.partition(".")[0] in KERNEL_PACKAGES
    return f"{module}.{name}" if is_ours else f"{module}.{name} {os.path.realpath(str(file))}"


def package_root() -> Path:
    """Return the folder that holds the running packages."""
    return Path(__file__).resolve().parents[2]


def module_tree(name: str) -> ast.Module:
    """Return the syntax of a module."""
    return _parsed(inspect.getsource(importlib.import_module(name)))


@cache
def _parsed(source: str) -> ast.Module:
    return ast.parse(source)


@cache
def _comments(path: Path) -> dict[int, tuple[str, bool]]:
    source = path.read_text(encoding="utf-8")
    found = {}
    for token in tokenize.generate_tokens(io.StringIO(source).readline):
        text = token.string.lstrip("#").strip()
        if token.type == tokenize.COMMENT and not text.startswith(("type:", "noqa")):
            found[token.start[0]] = (text.partition("  # ")[0], token.line.lstrip().startswith("#"))
    return found


@cache
def read_kernel(function: Callable[..., Any]) -> Kernel:
    """Return the source of a kernel."""
    try:
        path, first = inspect.getsourcefile(function), inspect.unwrap(function).__code__.co_firstlineno
        body = module_tree(function.__module__).body
    except (AttributeError, OSError, TypeError) as error:
        raise NotTranslatable(f"{function!r} cannot be translated: its source is not at hand") from error
    found = [node for node in body if isinstance(node, ast.FunctionDef) and node.name == function.__name__]
    if path is None or not any(_first_line(node) == first for node in found):
        raise NotTranslatable(f"{function!r} cannot be translated: it must be a function of a module, written with def")
    file = Path(path).resolve()
    root = file.parents[function.__module__.count(".")]
    kernel = Kernel(function, found[0], file.relative_to(root).as_posix(), file)
    if len(found) > 1:
        raise kernel.refusal(found[1], "is a second function of this name; give each a name of its own")
    if hasattr(function, "__wrapped__"):
        raise kernel.refusal(kernel.tree, "a decorator has put another function around it; write what both do in one")
    if inspect.isgeneratorfunction(function):
        raise kernel.refusal(kernel.tree, "yields; return the values instead")
    return kernel


def _first_line(node: ast.FunctionDef) -> int:
    return min([node.lineno, *(decorator.lineno for decorator in node.decorator_list)])


def resolve(kernel: Kernel, node: ast.expr) -> Any:
    """Return what a name outside of a kernel, or a member of it, stands for: a function, a class, a constant."""
    scope = kernel.function.__globals__
    if isinstance(node, ast.Name) and node.id in scope:
        value = scope[node.id]
        if isinstance(value, bool | int | float) and not isinstance(value, Enum):
            return _constant(kernel.function.__module__, node.id, value)
        return value
    if isinstance(node, ast.Name) and node.id in ("abs", "max", "min", "int", "float", "range"):
        return getattr(builtins, node.id)
    if isinstance(node, ast.Attribute):
        owner = resolve(kernel, node.value)
        value = getattr(owner, node.attr, None)
        if isinstance(owner, type) and issubclass(owner, Enum) and isinstance(value, int):
            return Constant(f"{owner.__name__}_{node.attr}".upper(), int(value), "")
        if isinstance(owner, ModuleType) and value is not None:
            return value
    remedy = "pass it as an argument or make it a module constant"
    if isinstance(node, ast.Name) and hasattr(builtins, node.id):
        remedy = INSTEAD.get(getattr(builtins, node.id), "call mathematics or kernels")
    raise kernel.refusal(node, f"{{}} is not known; {remedy}")


def _constant(module: str, name: str, value: Any) -> Constant:
    """Return a constant under the name of the module that defines it: two modules may use one name."""
    home, original = _definition(module, name)
    return Constant(f"{home.rpartition('.')[2]}_{original}".upper(), value, _documented(home, original))


@cache
def _documented(module: str, name: str) -> str:
    body, doc = module_tree(module).body, ""
    for node, following in zip(body, [*body[1:], None], strict=True):
        says = isinstance(following, ast.Expr) and isinstance(following.value, ast.Constant)
        if name in _assigned(node) and says:
            doc = inspect.cleandoc(str(following.value.value))  # type: ignore[union-attr]
    return doc


def _assigned(node: ast.stmt) -> set[str]:
    targets = node.targets if isinstance(node, ast.Assign) else [node.target] if isinstance(node, ast.AnnAssign) else []
    return {leaf.id for target in targets for leaf in ast.walk(target) if isinstance(leaf, ast.Name)}


@cache
def _definition(module: str, name: str) -> tuple[str, str]:
    """Return the module that defines a name, and its name there."""
    for node in module_tree(module).body:
        if name in _assigned(node):
            return module, name
        if isinstance(node, ast.ImportFrom):
            home = "." * node.level + (node.module or "")
            for alias in node.names:
                if name == (alias.asname or alias.name):
                    package = sys.modules[module].__package__
                    with suppress(OSError, TypeError):  # a module of C, as math is
                        return _definition(importlib.util.resolve_name(home, package), alias.name)
    return module, name
