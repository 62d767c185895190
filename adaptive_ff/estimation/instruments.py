"""Instruments: gradients without noise that may stand for the measured ones while they resemble them."""

import numpy as np
from numba.extending import register_jitable
from numpy.typing import NDArray

AGREEMENT = (0.7, 1.4)
"""Range of ``E z x / E z^2`` in which the gradient ``z`` of the model may stand for the measured one ``x``."""

EXCITED = 1e-3
"""Mean of ``z^2``, times the floor of the information, below which a parameter is not excited.

What is left of it then is the model's own change, which follows the noise: over an hour it would move the parameter.
"""


@register_jitable
def fade_agreement_in_place(
    agreement: NDArray[np.float64], model: NDArray[np.float64], measured: NDArray[np.float64], keep: float
) -> None:
    """Take a pair of gradients into account in the fading means of ``z^2`` and ``z x``, shape (n, 2)."""
    for i in range(model.size):
        agreement[i, 0] = keep * agreement[i, 0] + (1.0 - keep) * model[i] * model[i]
        agreement[i, 1] = keep * agreement[i, 1] + (1.0 - keep) * model[i] * measured[i]


@register_jitable
def gradients_agree(agreement: NDArray[np.float64], unexcited: float) -> bool:
    """Return whether the model's gradient resembles the measured one on the average, in every parameter.

    Means that differ by less than ``unexcited`` count as alike: without excitation both are small, and noise in the
    measured one must not pass for a signal that the model lacks.
    """
    for i in range(agreement.shape[0]):
        low = AGREEMENT[0] * agreement[i, 0] - unexcited
        high = AGREEMENT[1] * agreement[i, 0] + unexcited
        if agreement[i, 1] < low or agreement[i, 1] > high:
            return False
    return True


@register_jitable
def choose_instrument_in_place(
    agreement: NDArray[np.float64],
    model: NDArray[np.float64],
    measured: NDArray[np.float64],
    keep: float,
    unexcited: float,
    instrument: NDArray[np.float64],
) -> None:
    """Choose the model's gradient for an instrument while it resembles the measured one, else the measured one.

    Parameters
    ----------
    agreement : ndarray, shape (n, 2)
        Fading means of ``z^2`` and ``z x``; changed in place.
    model, measured : ndarray, shape (n,)
        Gradient of the model ``z`` and the measured one ``x``; left as they are.
    keep : float
        Forgetting factor of the means, in (0, 1).
    unexcited : float
        Floor of the information: means below it are no excitation.
    instrument : ndarray, shape (n,)
        Filled with the instrument; zero where the model's gradient does not excite a parameter.
    """
    fade_agreement_in_place(agreement, model, measured, keep)
    alike = gradients_agree(agreement, unexcited)
    for i in range(model.size):
        if not alike:
            instrument[i] = measured[i]  # plain least squares: biased by noise, but bounded whatever the model does
        elif agreement[i, 0] < EXCITED * unexcited:
            instrument[i] = 0.0
        else:
            instrument[i] = model[i]
