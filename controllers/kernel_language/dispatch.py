"""Kernels that choose the one that does it by the class of their first argument."""

from collections.abc import Callable, Mapping
from typing import Any

DISPATCHED: dict[Callable[..., Any], Mapping[type, Callable[..., Any]]] = {}
"""Kernel for each class of the first argument, by the kernel that chooses."""
