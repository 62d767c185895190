"""Correction of an estimate that stays possible."""

import numpy as np
from numba.extending import register_jitable
from numpy.typing import NDArray

from adaptive_ff.estimation.resetting import move_parameter_in_place
from adaptive_ff.friction.bounds import confine_in_place


@register_jitable
def correct_in_place(
    scale: NDArray[np.float64],
    estimate: NDArray[np.float64],
    correction: NDArray[np.float64],
    factor: NDArray[np.float64],
    ranges: NDArray[np.float64],
    work: NDArray[np.float64],
) -> None:
    """Add a scaled correction to the estimate and keep it possible.

    A parameter that would leave its range is moved back with the others adjusted; what still lies outside after
    that is cut off.
    """
    for i in range(estimate.size):
        value = estimate[i] + correction[i] * scale[i]
        possible = min(max(value, ranges[i, 0]), ranges[i, 1])
        if possible != value:
            move_parameter_in_place(factor, i, (possible - value) / scale[i], correction, work)
    for i in range(estimate.size):
        estimate[i] += correction[i] * scale[i]
    confine_in_place(estimate, ranges)
