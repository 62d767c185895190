"""Indices that cannot be negative."""

import numpy as np
from numba.extending import overload


def natural(index: int) -> int:
    """Return an index that is not negative: compiled code then need not test whether it counts from the end."""
    return index


overload(natural)(lambda index: lambda index: np.uint64(index))
