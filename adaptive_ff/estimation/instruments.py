"""Instruments: gradients without noise that may stand for the measured ones while they resemble them."""

import numpy as np
from numba.extending import register_jitable
from numpy.typing import NDArray

AGREEMENT = (0.7, 1.4)
"""Range of ``E z x / E z^2`` in which the gradient ``z`` of the model may stand for the measured one ``x``."""

EXCITED = 1e-3
"""Mean of ``z^2``, times the floor of the information, below which a gradient of the model tells nothing.

What is left of it then is the model's own change, which follows the noise: over an hour it would move the parameter.
"""


@register_jitable(forceinline=True)
def gradients_agree(
    agreement: NDArray[np.float64],
    model: NDArray[np.float64],
    measured: NDArray[np.float64],
    keep: float,
    unexcited: float,
) -> bool:
    """Update the fading means and tell whether the model's gradient resembles the measured one in every parameter.

    Where the model's tells nothing of a parameter, it is set to zero.

    Means that differ by less than ``unexcited`` count as alike: without excitation both are small, and noise in the
    measured one must not pass for a signal that the model lacks.
    """
    alike = True
    for i in range(model.size):
        agreement[i, 0] = keep * agreement[i, 0] + (1.0 - keep) * model[i] * model[i]
        agreement[i, 1] = keep * agreement[i, 1] + (1.0 - keep) * model[i] * measured[i]
        low = AGREEMENT[0] * agreement[i, 0] - unexcited
        high = AGREEMENT[1] * agreement[i, 0] + unexcited
        if agreement[i, 1] < low or agreement[i, 1] > high:
            alike = False
        if agreement[i, 0] < EXCITED * unexcited:
            model[i] = 0.0
    return alike
