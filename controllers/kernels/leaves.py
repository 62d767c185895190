"""Parameters and states as flat lists of numbers: what is in them, in which order, and where C keeps it."""

from collections.abc import Iterator
from dataclasses import dataclass
from typing import Any

import numpy as np

from controllers.kernels.literals import c_name
from controllers.kernels.types import Array, Line, Record, Scalar, Type


@dataclass(frozen=True)
class Leaf:
    """A number, or an array of numbers, in a nested named tuple."""

    path: tuple[str | int, ...]  # names of the fields, and places in tuples, that lead to it
    kind: Scalar  # what it holds
    shape: tuple[int, ...] = ()  # shape of the array; empty for a number
    is_array: bool = False  # whether it is an array

    @property
    def count(self) -> int:
        """How many numbers it holds."""
        return int(np.prod(self.shape, dtype=int))

    @property
    def member(self) -> str:
        """Its place within a struct in C."""
        text = "".join(f".at[{step}]" if isinstance(step, int) else f".{c_name(step)}" for step in self.path)
        return text.removeprefix(".")

    @property
    def storage(self) -> str:
        """Name of the array that holds its numbers."""
        return "_".join(str(step) for step in self.path)


def leaves(kind: Type, path: tuple[str | int, ...] = ()) -> Iterator[Leaf]:
    """Yield all numbers and arrays of a type in their order."""
    if isinstance(kind, Record):
        for name, field in kind.fields:
            yield from leaves(field, (*path, name))
    elif isinstance(kind, Line):
        for place in range(kind.length):
            yield from leaves(kind.element, (*path, place))
    elif isinstance(kind, Array):
        yield Leaf(path, kind.element, tuple(extent for extent in kind.shape if extent is not None), True)
    else:
        yield Leaf(path, Scalar(kind.kind))


def value_at(value: Any, path: tuple[str | int, ...]) -> Any:
    """Return what stands at a place in a nested named tuple."""
    for step in path:
        value = value[step] if isinstance(step, int) else getattr(value, step)
    return value


def rebuilt(template: Any, values: Iterator[Any]) -> Any:
    """Return a nested named tuple like a template with other numbers, in the order of its leaves."""
    if isinstance(template, tuple):
        items = [rebuilt(item, values) for item in template]
        return type(template)(*items) if hasattr(template, "_fields") else tuple(items)
    value = next(values)
    if isinstance(template, np.ndarray):
        return np.array(value, dtype=template.dtype).reshape(template.shape)
    return type(template)(value)
