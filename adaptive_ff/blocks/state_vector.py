"""States of kernels, nested named tuples of numbers and arrays, as one vector of floats and back.

A solver may evaluate a block at a state as often as it likes. Kernels of learning controllers change the arrays of
their state in place; a state that is rebuilt from a vector has arrays of its own, so nothing is ever learnt twice.
"""

from collections.abc import Iterator
from typing import Any

import numpy as np
from numpy.typing import NDArray

Vector = NDArray[np.float64]


def state_names(state: Any, path: str = "") -> list[str]:
    """Return a name for each number of a state, in the order of the vector: its fields, joined by underscores."""
    if hasattr(state, "_asdict"):
        fields = state._asdict().items()
        return [name for key, item in fields for name in state_names(item, f"{path}_{key}" if path else key)]
    if isinstance(state, (tuple, np.ndarray)):
        return [f"{path}_{place}" for place in range(np.size(state))]
    return [path]


def state_vector(state: Any) -> Vector:
    """Return all numbers of a state, shape (n,); counts and truth values as floats, which hold them exactly."""
    parts = [np.ravel(np.asarray(leaf, dtype=np.float64)) for leaf in _leaves(state)]
    return np.concatenate(parts) if parts else np.zeros(0)


def rebuilt(template: Any, vector: Vector) -> Any:
    """Return a state like the template, with arrays of its own and the numbers of a vector, shape (n,)."""
    state, used = _rebuilt(template, np.asarray(vector, dtype=np.float64), 0)
    if used != np.size(vector):
        raise ValueError(f"the vector has {np.size(vector)} numbers; the state has {used}")
    return state


def _leaves(state: Any) -> Iterator[Any]:
    if hasattr(state, "_asdict"):
        for item in state:
            yield from _leaves(item)
    else:
        yield state


def _rebuilt(template: Any, vector: Vector, first: int) -> tuple[Any, int]:
    """Return a part of a state from a place in the vector on, and the place behind it."""
    if hasattr(template, "_asdict"):
        items = []
        for item in template:
            made, first = _rebuilt(item, vector, first)
            items.append(made)
        return type(template)(*items), first
    if isinstance(template, np.ndarray):
        part = vector[first : first + template.size]
        return part.astype(template.dtype).reshape(template.shape), first + template.size
    if isinstance(template, tuple):
        return tuple(vector[first : first + len(template)].tolist()), first + len(template)
    return type(template)(vector[first]), first + 1
