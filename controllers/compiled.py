"""Compilation of entry points, cached on disk by the content of the sources.

Numba's own cache looks only at the file of the compiled function: after an edit of a kernel in another file it
would go on running the old one. Here every entry point is cached in a directory named after a hash of all sources
on which compiled code depends, so stale code cannot be found; where the packages lie plays no part, so that a second
clone or an installed copy of the same sources compiles nothing.

Kernels themselves are plain functions marked ``numba.extending.register_jitable``: called from Python they
run as Python, called from an entry point they are compiled.
"""

from collections.abc import Callable
from typing import Any, TypeVar

import numba
from numba.core import config
from numba.extending import overload

import controllers.whole_tuples  # noqa: F401 (tells numba how parameters and states are handed over)
from controllers.cache_directory import cache_directory
from controllers.kernel_cache import EntryCache
from controllers.kernel_compiler import EntryCompiler
from controllers.kernel_language.dispatch import DISPATCHED

Function = TypeVar("Function", bound=Callable[..., Any])


def compiled(function: Function) -> Function:
    """Compile a function at its first call, once a machine and once a version of the sources.

    Parameters
    ----------
    function : callable
        An entry point; everything that it calls must be compilable.

    Returns
    -------
    numba dispatcher
        The plain function stays available as its attribute ``py_func``.
    """
    entry: Function = cached(numba.njit(error_model="numpy", pipeline_class=EntryCompiler)(function))
    return entry


def compiled_in_place(function: Function) -> Function:
    """Compile a function that allocates no arrays; see :func:`compiled`.

    Numba then need not count references to the arrays in parameters and states, which would double the time of a step
    (``python -m benchmarks.speed`` measures it). What a step needs is held as scratch by its state.
    """
    options: dict[str, Any] = {"error_model": "numpy", "_nrt": False, "pipeline_class": EntryCompiler}
    entry: Function = cached(numba.njit(**options)(function))
    return entry


def cached(dispatcher: Any) -> Any:
    """Make a dispatcher, or a function for C, keep its machine code on disk; return it."""
    if not compiles():
        return dispatcher  # the plain function: numba was told to compile nothing
    plain = dispatcher.py_func if hasattr(dispatcher, "py_func") else dispatcher._pyfunc
    dispatcher._cache = EntryCache(plain, cache_directory())
    return dispatcher


def compiles() -> bool:
    """Tell whether numba compiles: ``NUMBA_DISABLE_JIT=1`` makes all kernels run as plain Python, to be debugged."""
    return not config.DISABLE_JIT  # type: ignore[attr-defined]


def is_cached(dispatcher: Any) -> bool:
    """Tell whether an entry point has been compiled, in this process or an earlier one."""
    if not compiles():
        return True  # there is nothing to wait for
    return bool(dispatcher.signatures) or any(cache_directory().rglob(f"*{dispatcher.__name__}-*.nbi"))


def dispatched(kernels: dict[type, Callable[..., Any]], function: Function) -> Function:
    """Make a generic kernel choose its implementation by the class of its first argument, compiled or not.

    Parameters
    ----------
    kernels : dict
        Implementation for each ``NamedTuple`` class of parameters; may grow until the first compilation for it.
    function : callable
        The plain function, which looks the implementation up in ``kernels`` by ``type(first argument)``.

    Returns
    -------
    callable
        The same function, now also callable from compiled code.
    """

    def choose(block: Any, *_: Any) -> Callable[..., Any] | None:
        return kernels.get(getattr(block, "instance_class", None))  # type: ignore[arg-type]

    # Inlined, and so are all kernels that it calls, to which numba hands the option on: else parameters and state, a
    # hundred numbers, go over the stack at each call, which can double the time.
    overload(function, strict=False, jit_options={"forceinline": True})(choose)
    DISPATCHED[function] = kernels
    return function
