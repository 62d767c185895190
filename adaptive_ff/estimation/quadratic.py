"""A vector of one parameter alone, the quadratic form of a matrix, and what a square of a vector takes from it."""

import numpy as np
from numba.extending import register_jitable
from numpy.typing import NDArray


@register_jitable
def write_unit_in_place(vector: NDArray[np.float64], index: int) -> None:
    """Write the vector, shape (n,), that is one at an index and zero elsewhere."""
    for k in range(vector.size):
        vector[k] = 1.0 if k == index else 0.0


@register_jitable
def quadratic_form(matrix: NDArray[np.float64], vector: NDArray[np.float64], product: NDArray[np.float64]) -> float:
    """Fill in ``M v``, shape (n,), and return ``v' M v``."""
    total = 0.0
    for i in range(vector.size):
        entry = 0.0
        for j in range(vector.size):
            entry += matrix[i, j] * vector[j]
        product[i] = entry
        total += vector[i] * entry
    return total


@register_jitable
def take_square_in_place(matrix: NDArray[np.float64], share: float, vector: NDArray[np.float64]) -> None:
    """Take ``share v v'`` from a matrix, shape (n, n)."""
    for i in range(vector.size):
        for j in range(vector.size):
            matrix[i, j] -= share * vector[i] * vector[j]
