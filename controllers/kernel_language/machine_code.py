"""Machine code of translated kernels: made by LLVM, kept on disk, and called.

Numba's code generator is used as a library, so that the code is for the same processor, is optimised by the same passes
and finds the same mathematics as what numba compiles.
"""

import ctypes
import gc
import hashlib
import inspect
import pickle
import sys
from collections import Counter
from collections.abc import Callable, Hashable, Iterable, Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import numpy as np
from numba.core.caching import IndexDataCacheFile
from numba.core.codegen import JITCodeLibrary
from numba.core.compiler_lock import global_compiler_lock
from numba.core.registry import cpu_target

from controllers.cache_directory import cache_directory
from controllers.kernel_language.kinds import (
    BOOLEAN,
    ELEMENTS,
    INTEGER,
    REAL,
    Array,
    Kind,
    Line,
    Record,
    kind_of,
)
from controllers.kernel_language.meanings import stands
from controllers.kernel_language.sources import read_kernel
from controllers.kernel_language.unit import Unit
from controllers.kernel_sources import KERNEL_PACKAGES, kernel_sources, package_root
from controllers.memory_layout import Memory, structure

SAMPLES: dict[Any, Any] = {REAL: 0.0, INTEGER: 0, BOOLEAN: False}
TYPES = {element: kind for kind, element in ELEMENTS.items()}

_KEPT: dict[tuple[Any, ...], tuple[Any, int, Any]] = {}
"""Library, address and sample of what has been made; code goes with its library, and none goes while a process runs."""

_NAMES: Counter[str] = Counter()
"""How often each name has been used: after a module is loaded anew, its functions are others of the same name."""


class CodeLibrary(JITCodeLibrary):
    """Machine code of one entry point, into which nothing is linked and which is linked into nothing."""

    def _optimize_functions(self, module: Any) -> None:
        """Leave it to the optimisation of the whole."""

    def _optimize_final_module(self) -> None:
        """Optimise once, and leave loops as they are.

        Numba's first, cheaper round serves to prune counted references, which kernels do not have. Loops of kernels go
        over a dozen numbers or end early: made for several at once, they are as slow and more to compile.
        """
        found = self._codegen._module_pass_manager(loop_vectorize=False)  # type: ignore[no-untyped-call]
        manager, *builder = found if isinstance(found, tuple) else (found,)  # older versions of numba have no builder
        manager.run(self._final_module, *builder)

    @classmethod
    def loaded(cls, generator: Any, name: str, code: bytes) -> Any:
        """Return what was kept on disk."""
        library: Any = cls(generator, name)
        library.enable_object_caching()
        library._set_compiled_object(code)
        library._finalize_final_module()
        return library

    @classmethod
    def made(cls, generator: Any, name: str, module: Any) -> Any:
        """Return what LLVM makes of a module."""
        library: Any = cls(generator, name)
        library.enable_object_caching()
        library.add_ir_module(module)
        library.finalize()
        return library


@contextmanager
def _without_collection() -> Iterator[None]:
    """Look for no garbage in cycles: what the translation makes is kept until it ends, and is gone through in vain."""
    collects = gc.isenabled()
    gc.disable()
    try:
        yield
    finally:
        if collects:
            gc.enable()


def address_of(kernel: Callable[..., Any], kinds: tuple[Kind, ...]) -> int:
    """Return where the machine code of a kernel that returns nothing lies; it is made, or loaded.

    As a function of C it takes records and tuples by their address, an array as its address and its sizes. Memory of
    one argument must be no other's, and no array's that stands in a record.

    Parameters
    ----------
    kernel : callable
        The kernel; it stands in a module, and so do all that it calls.
    kinds : tuple of Kind
        Kinds of its arguments.

    Raises
    ------
    NotTranslatable
        The kernel, or one that it calls, has no translation.
    """
    return _machine_code(kernel, kinds, Unit.exported)[0]


def _machine_code(kernel: Callable[..., Any], kinds: tuple[Kind, ...], form: Any) -> tuple[int, Any]:
    """Return where the machine code of a kernel lies, as a function of C, and a sample of what that gives."""
    if (form, kernel, *kinds) in _KEPT:
        return _KEPT[form, kernel, *kinds][1:]
    generator = cpu_target.target_context.codegen()
    places = sorted(_foreign_files(kernel, kinds))
    key = f"{kernel.__module__}.{kernel.__qualname__} {form.__name__} {kinds} {places} {generator.magic_tuple()}"
    name = f"entry_{hashlib.sha256(key.encode()).hexdigest()[:24]}"
    with global_compiler_lock, _without_collection():
        used, file = _NAMES[name], _File(_folder(kernel), f"{kernel.__name__}-{name}")
        _NAMES[name] += 1
        found = None if used else file.load()
        if found is None:
            name = f"{name}_{used}"
            unit = Unit(name)
            sample = _sample(form(unit, kernel, kinds, name))
            library = CodeLibrary.made(generator, name, unit.module)
            if not used:
                file.save(library._get_compiled_object(), sample, unit)
        else:
            name, (code, sample) = f"{name}_0", found
            library = CodeLibrary.loaded(generator, name, code)
        address = int(generator._engine.get_function_address(name))
        _KEPT[form, kernel, *kinds] = library, address, sample
        return address, sample


def _foreign_files(kernel: Any, kinds: Iterable[Kind]) -> set[str]:
    """Return the files, outside of the packages, of a kernel and of classes in the kinds of its arguments.

    Two scripts may use the same names.
    """
    found = set() if _is_ours(kernel) else {str(read_kernel(kernel).file)}
    for kind in kinds:
        if isinstance(kind, Line):
            found |= _foreign_files(kernel, [kind.element])
        if isinstance(kind, Record):
            found |= _foreign_files(kernel, kind.kinds)
            if kind.origin is not None and not _is_ours(kind.origin):
                found.add(str(getattr(sys.modules[kind.origin.__module__], "__file__", "")))
    return found


def _is_ours(thing: Any) -> bool:
    return thing.__module__.partition(".")[0] in KERNEL_PACKAGES


def _folder(kernel: Callable[..., Any]) -> Path:
    return cache_directory() / kernel.__module__


def _sample(kind: Kind | None) -> Any:
    """Return a value of a kind."""
    if isinstance(kind, Record):
        items = [_sample(each) for each in kind.kinds]
        return kind.origin(*items) if kind.origin else tuple(items)
    if isinstance(kind, Line):
        return (_sample(kind.element),) * kind.length
    if isinstance(kind, Array):
        return np.zeros((0,) * kind.ndim, TYPES[kind.element])
    return SAMPLES.get(kind)


class _File:
    """Machine code of one kernel on disk.

    It lies in a directory that is named after the content of the sources on which compiled code is known to depend. Of
    other files that kernels stand in, the content is noted beside the code; and so is what global names stand for.
    """

    def __init__(self, folder: Path, base: str) -> None:
        folder.mkdir(parents=True, exist_ok=True)
        self._file: Any = IndexDataCacheFile(str(folder), base, "content")  # type: ignore[no-untyped-call]

    def load(self) -> tuple[bytes, Any] | None:
        """Return the code and a sample of its result; none where there is none, or what it depends on changed."""
        try:
            found = self._file.load("code")
        except (AttributeError, ImportError, EOFError, pickle.UnpicklingError):
            return None  # cut off, or of a class that is no longer there
        if found is None or any(_content(path) != content for path, content in found[2].items()):
            return None
        return (found[0], found[1]) if stands(found[3]) else None

    def save(self, code: bytes, sample: Any, unit: Unit) -> None:
        """Keep the code of a unit."""
        known = {package_root() / path for path in kernel_sources()}
        sources = {str(path): _content(str(path)) for path in unit.files - known}
        self._file.save("code", (code, sample, sources, unit.meanings))


def _content(path: str) -> str | None:
    try:
        return hashlib.sha256(Path(path).read_bytes()).hexdigest()
    except OSError:
        return None


class Translated:
    """A kernel that is called from Python as machine code; that is made at the first call for kinds of arguments.

    Parameters
    ----------
    kernel : callable
        The kernel.

    Attributes
    ----------
    py_func : callable
        The kernel, as numba calls it.
    """

    def __init__(self, kernel: Callable[..., Any]) -> None:
        self.py_func = kernel
        self._known: dict[Hashable, tuple[Any, Any, Hashable]] = {}

    def __call__(self, *arguments: Any) -> Any:
        """Return what the kernel returns; its arrays are those of the arguments.

        Raises
        ------
        NotTranslatable
            The kernel, or one that it calls, has no translation.
        TypeError
            An argument is of a kind that kernels do not take; or what is given back is an array that is no argument.
        """
        form = structure(arguments)
        if form not in self._known:
            self._known[form] = self._made(arguments)
        function, sample, form_of_sample = self._known[form]
        try:
            taken = Memory(arguments, form)
        except TypeError as error:
            raise self._error(str(error)) from None
        if sample is None:
            function(taken.address, None)
            return None
        given = Memory.like(sample, form_of_sample)
        function(taken.address, given.address)
        try:
            return given.value_with_arrays_of(taken)
        except KeyError:
            raise self._error("gives back an array that is no argument; return its elements or the whole one") from None

    def is_made(self) -> bool:
        """Tell whether there is machine code, for any kinds of arguments, in this process or on disk."""
        return bool(self._known) or any(_folder(self.py_func).glob(f"{self.py_func.__name__}-*.nbi"))

    def _made(self, arguments: tuple[Any, ...]) -> tuple[Any, Any, Hashable]:
        expected = len(inspect.signature(self.py_func).parameters)
        if len(arguments) != expected:
            raise self._error(f"as machine code it takes {expected} arguments, was given {len(arguments)}")
        try:
            kinds = tuple(map(kind_of, arguments))
        except TypeError as error:
            raise self._error(str(error)) from None
        address, sample = _machine_code(self.py_func, kinds, Unit.entry)
        function = ctypes.CFUNCTYPE(None, ctypes.c_void_p, ctypes.c_void_p)(address)
        return function, sample, structure(sample)

    def _error(self, problem: str) -> TypeError:
        kernel = read_kernel(self.py_func)
        return TypeError(str(kernel.refusal(kernel.tree, problem)))
