"""Entry points: kernels that are called from Python, compiled.

Kernels themselves are plain functions: called from Python they run as Python, called from an entry point they are
compiled. An entry point is compiled once a machine and once a version of the sources (:mod:`controllers.kernels`).
"""

import ctypes
import inspect
import os
import warnings
from collections.abc import Callable, Hashable
from functools import cache
from typing import Any, NamedTuple, TypeVar

from controllers.kernels.compiler import NoCompiler, compiler
from controllers.kernels.entry import entry_text, symbol_of
from controllers.kernels.language import NotTranslatable
from controllers.kernels.library import is_kept, loaded
from controllers.kernels.memory import Memory, structure
from controllers.kernels.sources import read_kernel
from controllers.kernels.types import sample_of, type_of

Function = TypeVar("Function", bound=Callable[..., Any])


def compiled(function: Function) -> Function:
    """Compile a function at its first call for kinds of arguments, once a machine and once a version of the sources.

    Parameters
    ----------
    function : callable
        An entry point; it and everything that it calls are kernels (:mod:`controllers.kernels`).

    Returns
    -------
    Compiled
        The plain function stays available as its attribute ``py_func``.
    """
    return Compiled(function) if compiles() else function  # type: ignore[return-value]


@cache
def compiles() -> bool:
    """Tell whether kernels are compiled: not with ``ADAPTIVE_FF_COMPILE=0`` nor where there is nothing to do it.

    Then they all run as plain Python, which can be debugged.
    """
    if os.environ.get("ADAPTIVE_FF_COMPILE", "") == "0":
        return False
    if is_kept() or compiler() is not None:  # where some are compiled already nothing needs to try a compiler
        return True
    remedy = "there is no C compiler: install one, or pip install ziglang"
    warnings.warn(f"{remedy}; kernels run as plain Python, some hundred times slower", stacklevel=2)
    return False


def is_cached(entry: Any) -> bool:
    """Tell whether an entry point has been compiled for any arguments, in this process or an earlier one."""
    made = not isinstance(entry, Compiled) or entry._known  # of what is not compiled there is nothing to wait for
    return bool(made) or is_kept(entry.py_func.__name__)


class _Made(NamedTuple):
    """A compiled kernel for kinds of arguments: the function of C, a sample of what it gives, and its structure."""

    function: Any
    sample: Any
    form: Hashable


class Compiled:
    """A kernel that is called from Python compiled; that is made at the first call for kinds of arguments."""

    def __init__(self, kernel: Callable[..., Any]) -> None:
        self.py_func = kernel
        self._known: dict[Hashable, _Made | None] = {}

    def __call__(self, *arguments: Any) -> Any:
        """Return what the kernel returns; its arrays are those of the arguments."""
        form = structure(arguments)
        if form not in self._known:
            self._known[form] = self._made(arguments)
        made = self._known[form]
        if made is None:
            return self.py_func(*arguments)
        try:
            taken = Memory(arguments, form)
        except TypeError as error:
            raise self._error(str(error)) from None
        if made.sample is None:
            made.function(taken.address, None)
            return None
        given = Memory.like(made.sample, made.form)
        made.function(taken.address, given.address)
        try:
            return given.value_with_arrays_of(taken)
        except KeyError:
            raise self._error("gives back an array that is no argument; return its elements or the whole one") from None

    def _made(self, arguments: tuple[Any, ...]) -> _Made | None:
        """Return the compiled kernel for kinds of arguments; none where it cannot be compiled on this machine."""
        expected = len(inspect.signature(self.py_func).parameters)
        if len(arguments) != expected:
            raise self._error(f"compiled it takes {expected} arguments, was given {len(arguments)}")
        try:
            kinds = tuple(map(type_of, arguments))
        except NotTranslatable as error:
            raise self._error(str(error)) from None
        kernel = self.py_func
        symbol = symbol_of((kernel,), kinds)
        try:
            found = loaded((kernel, kinds), symbol, lambda unit: entry_text(unit, kernel, kinds, symbol))
        except NoCompiler as error:
            warnings.warn(f"{kernel.__name__} runs as plain Python: {error}", stacklevel=3)
            return None
        function = ctypes.CFUNCTYPE(None, ctypes.c_void_p, ctypes.c_void_p)(found.address(symbol))
        sample = sample_of(found.result)
        return _Made(function, sample, structure(sample))

    def _error(self, problem: str) -> TypeError:
        kernel = read_kernel(self.py_func)
        return TypeError(str(kernel.refusal(kernel.tree, problem)))
