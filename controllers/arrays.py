"""Arrays: their types under short names, and symmetric matrices as their lower triangle, row by row.

Expanded, the types of numpy drown a signature in ``help()``. A triangle takes half the memory, and there is nothing to
keep symmetric.
"""

import math
from functools import cache
from typing import TYPE_CHECKING, Any, TypeAlias

import numpy as np

from controllers.kernels.language import natural

if TYPE_CHECKING:
    from numpy.typing import ArrayLike as ArrayLike
    from numpy.typing import NDArray as NDArray
else:

    class _Named:
        """A type in annotations that shows as its name; nothing checks it while a program runs."""

        def __init__(self, name: str) -> None:
            self.name = name

        def __repr__(self) -> str:
            return self.name

        def __or__(self, other: Any) -> "_Named":
            return _Named(f"{self} | {_name(other)}")

        def __ror__(self, other: Any) -> "_Named":
            return _Named(f"{_name(other)} | {self}")

        def __getitem__(self, kind: Any) -> "_Named":
            return _Named(f"{self}[{_name(kind)}]")

        def __call__(self) -> None:
            raise TypeError(f"{self} is for annotations only")

    def _name(kind: Any) -> str:
        return "None" if kind is None else getattr(kind, "__name__", str(kind))

    ArrayLike, NDArray = _Named("ArrayLike"), _Named("NDArray")

MutableArray: TypeAlias = NDArray[np.float64]
"""An array of a state that steps change in place; all other arrays stay as they are."""


def row_of(i: int) -> int:
    """Return where row ``i`` begins; its element ``j <= i`` stands ``j`` places behind."""
    return natural(i) * (natural(i) + 1) // 2


lower_triangle = cache(np.tril_indices)  # rows and columns of the elements, by the size of the matrix


def packed(matrix: Any) -> MutableArray:
    """Return the lower triangle of a matrix."""
    return np.ascontiguousarray(matrix[lower_triangle(len(matrix))])


def unpacked(triangle: Any) -> MutableArray:
    """Return the symmetric matrix of a triangle."""
    size = math.isqrt(2 * len(triangle))
    matrix = np.zeros((size, size))
    matrix[lower_triangle(size)] = triangle
    return matrix + np.tril(matrix, -1).T
