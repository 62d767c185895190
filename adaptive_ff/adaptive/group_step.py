"""One sample of all joints of a group in one compiled call, in a time that grows with their number."""

import numpy as np
from numpy.typing import NDArray

from controllers import compiled, step_in_memory


def _step_group(addresses: NDArray[np.intp], rows: NDArray[np.float64]) -> None:
    for k in range(addresses.shape[0]):
        step_in_memory(addresses[k, 0], addresses[k, 1], addresses[k, 2], rows[k])


step_group = compiled(_step_group)
"""Step all joints of a group.

Parameters
----------
addresses : ndarray of int, shape (n, 3)
    Where step, parameters and state of each joint lie.
rows : ndarray, shape (n, 13)
    Inputs of each joint, a column for each field of ``Inputs``; torque and feedforward, N m, are filled in behind.
"""
