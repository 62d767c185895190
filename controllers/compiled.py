"""Compilation of entry points, cached on disk by the content of the sources.

Numba's own cache looks only at the file of the compiled function: after an edit of a kernel in another file it
would go on running the old one. Here every entry point is cached in a directory named after a hash of all sources
on which compiled code depends, so stale code cannot be found; where the packages lie plays no part, so that a second
clone or an installed copy of the same sources compiles nothing.

Kernels themselves are plain functions: called from Python they run as Python, called from an entry point they are
compiled. Marked ``numba.extending.register_jitable``, they can be called by functions that numba compiles, too.
"""

from collections.abc import Callable
from typing import Any, TypeVar

import numba
from numba.core import config
from numba.extending import overload

from controllers.cache_directory import cache_directory
from controllers.kernel_cache import EntryCache
from controllers.kernel_language.dispatch import DISPATCHED
from controllers.kernel_language.machine_code import Translated

Function = TypeVar("Function", bound=Callable[..., Any])


def compiled(function: Function, *, allocates: bool = True) -> Function:
    """Let numba compile a function at its first call, once a machine and once a version of the sources.

    That is for what is called often for little work, and for what makes arrays; all else is quicker to compile by
    :func:`compiled_in_place`.

    Parameters
    ----------
    function : callable
        An entry point; everything that it calls must be compilable.
    allocates : bool, optional
        Whether it makes arrays. Where it does not, numba need not count references to those that it is given, which
        would double the time of a step (``python -m benchmarks.speed`` measures it).

    Returns
    -------
    numba dispatcher
        The plain function stays available as its attribute ``py_func``.
    """
    options = {"error_model": "numpy"} if allocates else {"error_model": "numpy", "_nrt": False}
    entry: Any = numba.njit(**options)(function)
    if compiles():
        entry._cache = EntryCache(function, cache_directory())
    return entry  # type: ignore[no-any-return]


def compiled_in_place(function: Function) -> Function:
    """Compile a function that makes no arrays at its first call, once a machine and once a version of the sources.

    Parameters
    ----------
    function : callable
        An entry point; it and everything that it calls are kernels (:mod:`controllers.kernel_language`).

    Returns
    -------
    Translated
        The plain function stays available as its attribute ``py_func``.
    """
    return Translated(function) if compiles() else function  # type: ignore[return-value]


def compiles() -> bool:
    """Tell whether numba compiles: ``NUMBA_DISABLE_JIT=1`` makes all kernels run as plain Python, to be debugged."""
    return not config.DISABLE_JIT  # type: ignore[attr-defined]


def is_cached(entry: Any) -> bool:
    """Tell whether an entry point has been compiled for any arguments, in this process or an earlier one."""
    if not compiles():
        return True  # there is nothing to wait for
    return entry.is_made() if isinstance(entry, Translated) else bool(entry.signatures) or entry._cache.is_filled()


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

    overload(function, strict=False)(choose)
    DISPATCHED[function] = kernels
    return function
