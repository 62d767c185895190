"""Long series: in blocks, and their largest size without a copy of them."""

from collections.abc import Iterator

import numpy as np
from numpy.typing import NDArray

BLOCK = 2**18
"""Values of a series that are computed at a time."""


def blocks(size: int) -> Iterator[slice]:
    """Yield a series in blocks, so that what is computed on the way takes no room that grows with its length."""
    for begin in range(0, size, BLOCK):
        yield slice(begin, min(begin + BLOCK, size))


def largest_size(values: NDArray[np.float64]) -> float:
    """Return the largest absolute value."""
    return max(float(np.max(values)), -float(np.min(values)))
