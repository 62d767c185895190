"""What a translation was made of: the files of its kernels, and what their global names stood for.

A name may get another meaning without any source of a kernel being edited: a constant that is computed, or read from a
file that holds no kernels, or replaced by a test; another function under the same name; a kernel more for a class.
Machine code on disk is kept together with what the names stood for, and is made anew where one stands for something
else.
"""

import builtins
import hashlib
import importlib
from collections.abc import Hashable, Mapping
from functools import cache
from pathlib import Path
from typing import Any, NamedTuple

from controllers.kernels.language import DISPATCHED
from controllers.kernels.sources import identity, package_root
from controllers.kernels.types import Type


class Translation(NamedTuple):
    """A kernel translated once, of which machine code is kept."""

    # each file that a kernel stands in, relative to the packages' folder where it is one of theirs, and a hash of it
    files: tuple[tuple[str, str], ...]
    meanings: dict[tuple[str, str], str]  # what each global name stood for, by module and name
    result: Type | None  # what the kernel gives
    library: str = ""  # name of the library's file

    def holds(self) -> bool:
        """Tell whether all that it was made of is as it was."""
        return all(_content(path) == known for path, known in self.files) and stands(self.meanings)


def translation(unit: Any, result: Type | None) -> Translation:
    """Return what was translated last in a unit."""
    names = sorted(_relative(path) for path in unit.files)
    return Translation(tuple((name, _content(name)) for name in names), dict(unit.meanings), result)


def _relative(path: Path) -> str:
    root = package_root()
    return path.relative_to(root).as_posix() if path.is_relative_to(root) else str(path)


def _content(path: str) -> str:
    """Return a hash of a file's content; of one that is not there, nothing."""
    place = package_root() / path
    try:
        found = place.stat()
    except OSError:
        return ""
    return _hash(place, found.st_mtime_ns, found.st_size)


@cache
def _hash(path: Path, time: int, size: int) -> str:
    del time, size  # which stand for the content within a process
    return hashlib.sha256(path.read_bytes()).hexdigest()[:20]


def meaning(scope: Mapping[str, Any], name: str) -> str:
    """Return what a name, which may have dots, stands for now."""
    first, *fields = name.split(".")
    found = scope[first] if first in scope else vars(builtins)[first]
    for field in fields:
        found = getattr(found, field)
    if isinstance(found, type) and hasattr(found, "_fields"):
        return repr((identity(found), found._fields, vars(found).get("_field_defaults"), found.__annotations__))
    if isinstance(found, bool | int | float | tuple):
        return repr(found)
    known: Mapping[Any, Mapping[type, Any]] = DISPATCHED
    chosen = known.get(found, {}) if isinstance(found, Hashable) else {}
    return repr((_function(found), sorted((identity(kind), _function(kernel)) for kind, kernel in chosen.items())))


def stands(meanings: Mapping[tuple[str, str], str]) -> bool:
    """Tell whether all names, which have their module beside them, stand for what they stood for."""
    try:
        found = ((vars(importlib.import_module(module)), name, known) for (module, name), known in meanings.items())
        return all(meaning(scope, name) == known for scope, name, known in found)
    except (ImportError, KeyError, AttributeError):
        return False


def _function(found: Any) -> tuple[str, str]:
    """Return what a function is, with its defaults."""
    return identity(found), repr((getattr(found, "__defaults__", None), getattr(found, "__kwdefaults__", None)))
