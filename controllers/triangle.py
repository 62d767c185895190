"""Symmetric matrices as their lower triangle, row by row: half the memory, and nothing to keep symmetric."""

import math
from functools import cache
from typing import Any

import numpy as np

from controllers.arrays import MutableArray
from controllers.kernels.language import natural


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
