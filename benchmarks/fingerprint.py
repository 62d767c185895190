"""Digest of the code that a result depends on: syntax trees of the import closure, without docstrings and comments."""

import ast
import hashlib
from collections.abc import Iterable
from functools import cache
from pathlib import Path

ROOT = Path(__file__).resolve().parent.parent
"""Folder that the packages lie in."""

PACKAGES = ("adaptive_ff", "plant", "controllers", "benchmarks")
"""Packages whose files count; versions of others stand in the result itself."""

NOT_FOLLOWED = ("adaptive_ff.report", "adaptive_ff.cli", "adaptive_ff.export")
"""Packages that draw, print and write: no figure depends on them unless it is asked for by a module of theirs."""


def fingerprint(modules: Iterable[str], files: Iterable[Path] = (), text: str = "") -> str:
    """Return the digest of what some modules import within the project, of all bytes of some files, and of a text."""
    digest = hashlib.sha256(text.encode())
    for name in sorted(import_closure(modules)):
        digest.update(f"{name} {_tree_digest(_file_of(name))}".encode())
    for file in sorted(files):
        digest.update(file.name.encode() + file.read_bytes())
    return digest.hexdigest()[:16]


def import_closure(modules: Iterable[str]) -> set[str]:
    """Return the modules of the project that some modules import, directly or through others, themselves included."""
    waiting = list(modules)
    closure: set[str] = set()
    while waiting:
        name = waiting.pop()
        if name not in closure:
            closure.add(name)
            waiting += [found for found in _imports(_file_of(name)) if not found.startswith(NOT_FOLLOWED)]
    return closure


def _file_of(name: str) -> Path | None:
    """Return the file of a module of the project, the stub where a package loads its names lazily; else None."""
    if name.partition(".")[0] not in PACKAGES:
        return None
    place = ROOT.joinpath(*name.split("."))
    for file in (place / "__init__.pyi", place / "__init__.py", place.with_suffix(".py")):
        if file.is_file():
            return file
    return None


@cache
def _imports(file: Path | None) -> tuple[str, ...]:
    """Return the modules of the project that a file imports; through a stub, those that it has the names from."""
    if file is None or file.name == "__init__.pyi":
        return ()
    found = []
    for node in ast.walk(ast.parse(file.read_bytes())):
        if isinstance(node, ast.Import):
            found += [alias.name for alias in node.names]
        elif isinstance(node, ast.ImportFrom) and node.module and not node.level:
            found += [_origin(node.module, alias.name) for alias in node.names]
    return tuple(name for name in dict.fromkeys(found) if _file_of(name) is not None)


def _origin(module: str, name: str) -> str:
    """Return the module that a name is imported from: a submodule, or the one that a stub names."""
    if _file_of(f"{module}.{name}") is not None:
        return f"{module}.{name}"
    file = _file_of(module)
    if file is not None and file.name == "__init__.pyi":
        return _stub(file).get(name, module)
    return module


@cache
def _stub(file: Path) -> dict[str, str]:
    package = ".".join(file.parent.relative_to(ROOT).parts)
    imports = [node for node in ast.parse(file.read_bytes()).body if isinstance(node, ast.ImportFrom)]
    return {
        alias.asname or alias.name: f"{package}.{node.module}" if node.level else node.module or ""
        for node in imports
        for alias in node.names
    }


@cache
def _tree_digest(file: Path | None) -> str:
    """Return the digest of a file's syntax tree without docstrings."""
    if file is None or file.name == "__init__.pyi":
        return ""
    tree = ast.parse(file.read_bytes())
    for node in ast.walk(tree):
        if isinstance(node, ast.Module | ast.ClassDef | ast.FunctionDef | ast.AsyncFunctionDef):
            node.body = [part for part in node.body if not _is_text(part)]
    return hashlib.sha256(ast.dump(tree).encode()).hexdigest()


def _is_text(node: ast.stmt) -> bool:
    return isinstance(node, ast.Expr) and isinstance(node.value, ast.Constant) and isinstance(node.value.value, str)
