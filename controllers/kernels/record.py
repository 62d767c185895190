"""What a translation was made of: the files of its kernels, and what their global names stood for."""

import hashlib
import os
import sys
from collections.abc import Iterable
from functools import cache
from pathlib import Path
from typing import Any, NamedTuple

from controllers.kernels.meanings import stands
from controllers.kernels.sources import KERNEL_PACKAGES, package_root
from controllers.kernels.types import Array, Line, Record, Type
from controllers.kernels.unit import Unit


class Translation(NamedTuple):
    """A kernel translated once, of which machine code is kept."""

    # each file that a kernel stands in, relative to the packages' folder where it is one of theirs, and a hash of it
    files: tuple[tuple[str, str], ...]
    meanings: dict[tuple[str, str], str]  # what each global name stood for, by module and name
    result: Type | None  # what the kernel gives
    library: str  # name of the library's file

    def holds(self) -> bool:
        """Tell whether all that it was made of is as it was."""
        return all(_content(path) == known for path, known in self.files) and stands(self.meanings)


def translation(unit: Unit, result: Type | None, library: str) -> Translation:
    """Return what a unit was made of."""
    names = sorted(_relative(path) for path in unit.files)
    return Translation(tuple((name, _content(name)) for name in names), dict(unit.meanings), result, library)


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


def is_ours(thing: Any) -> bool:
    """Tell whether a function or class is one of the packages."""
    return thing.__module__.partition(".")[0] in KERNEL_PACKAGES


def foreign_files(things: Iterable[Any], kinds: Iterable[Type]) -> set[str]:
    """Return the files, outside of the packages, of functions and of classes in types: scripts may share names."""
    found = {_file(thing) for thing in things if not is_ours(thing)}
    for kind in kinds:
        if isinstance(kind, Line | Array):
            found |= foreign_files((), [kind.element])
        if isinstance(kind, Record):
            origins = [] if kind.origin is None else [kind.origin]
            found |= foreign_files(origins, [field for _, field in kind.fields])
    return found


def _file(thing: Any) -> str:
    file = getattr(sys.modules.get(thing.__module__), "__file__", None)
    file = getattr(getattr(thing, "__code__", None), "co_filename", file)
    return os.path.realpath(file) if file else ""
