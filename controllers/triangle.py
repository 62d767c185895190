"""Symmetric matrices as their lower triangle, row by row: half the memory, and nothing to keep symmetric."""

import math
from typing import Any

import numpy as np

from controllers.arrays import MutableArray
from controllers.kernels.language import natural


def row_of(i: int) -> int:
    """Return where row ``i`` begins; its element ``j <= i`` stands ``j`` places behind."""
    return natural(i) * (natural(i) + 1) // 2


def packed(matrix: Any) -> MutableArray:
    """Return the lower triangle of a matrix."""
    return np.ascontiguousarray(matrix[np.tril_indices(len(matrix))])


def unpacked(triangle: Any) -> MutableArray:
    """Return the symmetric matrix of a triangle."""
    size = math.isqrt(2 * len(triangle))
    matrix = np.zeros((size, size))
    matrix[np.tril_indices(size)] = triangle
    return matrix + np.tril(matrix, -1).T
