"""What kernels may call beside mathematics, named tuples and each other, and what is said of those that may not be."""

import ctypes
from collections.abc import Callable, Mapping
from typing import Any


class NotTranslatable(ValueError):
    """A kernel, or what stands in it, has no translation; one line says where it stands and what to write instead."""


DISPATCHED: dict[Callable[..., Any], Mapping[type, Callable[..., Any]]] = {}
"""Kernel for each class of the first argument, by the kernel that chooses."""


def dispatched(kernels: Mapping[type, Callable[..., Any]], function: Callable[..., Any] | None = None) -> Any:
    """Make a generic kernel choose its implementation by the class of its first argument, compiled or not.

    Parameters
    ----------
    kernels : mapping
        Implementation for each ``NamedTuple`` class of parameters; may grow until the first compilation for it.
    function : callable, optional
        The plain function, which looks the implementation up in ``kernels`` by ``type(first argument)``; by default
        one that does nothing else.

    Returns
    -------
    callable
        The same function, now also callable from compiled code.
    """

    def choose(first: Any, *others: Any) -> Any:
        return kernels[type(first)](first, *others)

    chosen = choose if function is None else function
    DISPATCHED[chosen] = kernels
    return chosen


BY_ADDRESS = ctypes.CFUNCTYPE(None, ctypes.c_int64, ctypes.c_int64, ctypes.c_void_p, ctypes.c_int64)
"""A compiled step as a function of C: parameters, state, row, numbers in the row."""


def natural(index: int) -> int:
    """Return an index that is not negative: compiled code then need not test whether it counts from the end."""
    return index


def call(address: int, parameters: int, state: int, row: Any) -> None:
    """Call a compiled function by its address: ``void f(parameters, state, row, count)``."""
    BY_ADDRESS(address)(parameters, state, row.ctypes.data, row.size)
