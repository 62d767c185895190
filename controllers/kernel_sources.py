"""Which source files compiled code depends on, and one key for their content.

Compiled code depends on the files that define kernels and on every file that these import, directly or not: the
classes of parameters and the constants that a kernel reads stand there. Imports inside functions do not count, for a
kernel cannot import; neither do a package's lazy names that nobody asks for. What is left out (command line, plots,
logs) can be edited without compiling anything anew.
"""

import hashlib
import re
import sys
from functools import cache
from pathlib import Path

import numba

KERNEL_PACKAGES = ("plant", "controllers", "adaptive_ff")

MARK = re.compile(r"\bregister_jitable\b|\b(?:compiled|compiled_in_place|dispatched)\(")
"""What a file that defines kernels or entry points contains."""

IMPORT = re.compile(r"^(?:from\s+([\w.]+)\s+import\s+(\([^)]*\)|[^\n#]*)|import\s+([^\n#]*))", re.MULTILINE)
"""An import at the left margin: the module and the names of ``from``, or the modules of ``import``."""

LAZY_NAME = re.compile(r"^from\s+\.([\w.]*)\s+import\s+(\w+)\s+as\s+\w+", re.MULTILINE)
"""A line of the stub of a package whose names are loaded lazily."""


def source_key(root: Path | None = None) -> str:
    """Return a key that changes with every source file on which compiled code depends, with numba and with Python.

    Parameters
    ----------
    root : Path, optional
        Folder that holds the packages; by default that of the running ones.
    """
    digest = hashlib.sha256(f"{numba.__version__} {sys.version}".encode())
    for path, source in kernel_sources(root).items():
        digest.update(f"{path.as_posix()} {len(source)} ".encode())
        digest.update(source)
    return digest.hexdigest()[:16]


def kernel_sources(root: Path | None = None) -> dict[Path, bytes]:
    """Return the content of each file on which compiled code depends, by its path below the root, in order."""
    base = package_root() if root is None else root
    modules = {
        _module_name(path.relative_to(base)): path
        for package in KERNEL_PACKAGES
        for path in sorted((base / package).rglob("*.py"))
    }
    contents = {name: path.read_bytes() for name, path in modules.items()}
    texts = {name: content.decode() for name, content in contents.items()}
    needed: set[str] = set()
    left = [name for name, text in texts.items() if MARK.search(text)]
    while left:
        name = left.pop()
        if name not in needed:
            needed.add(name)
            left += _imported(name, texts[name], modules)
    return {modules[name].relative_to(base): contents[name] for name in sorted(needed)}


def package_root() -> Path:
    """Return the folder that holds the running packages."""
    return Path(__file__).resolve().parent.parent


def _module_name(path: Path) -> str:
    parts = path.with_suffix("").parts
    return ".".join(parts[:-1] if parts[-1] == "__init__" else parts)


def _imported(importer: str, text: str, modules: dict[str, Path]) -> set[str]:
    """Return the modules of the packages that a file imports when it is loaded, the packages around them included."""
    found = set()
    for package, names, plain in _import_statements(text):
        if package:
            package = _absolute(package, importer, modules)
            asked = {_defining_module(package, name, modules) for name in _names(names)}
        else:
            asked = set(_names(plain))
        for module in asked:
            while module:
                if module in modules:
                    found.add(module)
                module = module.rpartition(".")[0]
    return found


@cache
def _import_statements(text: str) -> list[tuple[str, str, str]]:
    return IMPORT.findall(text)


@cache
def _lazy_names(stub: str) -> dict[str, str]:
    """Return the module that each lazy name of a stub stands in."""
    return {name: module for module, name in LAZY_NAME.findall(stub)}


def _absolute(package: str, importer: str, modules: dict[str, Path]) -> str:
    """Return the full name of a package or module that may be written with leading dots."""
    name = package.lstrip(".")
    parts = importer.split(".")
    up = len(package) - len(name) - (modules[importer].name == "__init__.py")
    around = parts[: len(parts) - up] if package.startswith(".") else []
    return ".".join([*around, *([name] if name else [])])


def _names(listed: str) -> list[str]:
    lines = (line.partition("#")[0] for line in listed.strip("()").splitlines())
    return [words[0] for name in ",".join(lines).split(",") if (words := name.split())]


def _defining_module(package: str, name: str, modules: dict[str, Path]) -> str:
    """Return the module behind a name imported from a package: a submodule, a lazy name's module, else the package."""
    if f"{package}.{name}" in modules:
        return f"{package}.{name}"
    if package in modules:
        stub = modules[package].with_suffix(".pyi")
        if modules[package].name == "__init__.py" and stub.exists():
            module = _lazy_names(stub.read_text()).get(name)
            if module is not None:
                return f"{package}.{module}" if module else f"{package}.{name}"
    return package
