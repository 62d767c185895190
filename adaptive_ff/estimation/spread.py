"""How far an estimate may be from the truth, whatever the gain that corrected it.

An estimate that is corrected by ``P(k) = P(k-1) + g (y - x' P(k-1))``, where ``y = x' P + v`` and the ``v`` are
independent with one variance, is off by an error with covariance

    C(k) = (I - g x') C(k-1) (I - g x')' + g g'

in units of that variance, for every gain ``g`` that does not depend on ``v``: R. S. Bucy and P. D. Joseph, "Filtering
for Stochastic Processes with Applications to Guidance" (Interscience, 1968). With a forgetting factor this is *not* the
``R`` of the recursion, which is up to twice as large: what is forgotten is weighted by ``lambda``, its variance by
``lambda^2``.
"""

import numpy as np
from numba.extending import register_jitable
from numpy.typing import NDArray


@register_jitable
def update_spread_in_place(
    spread: NDArray[np.float64],
    gain: NDArray[np.float64],
    projected: NDArray[np.float64],
    predicted: float,
) -> None:
    """Take a correction of the estimate into account.

    One triangle is computed and copied: the matrix is symmetric exactly.

    Parameters
    ----------
    spread : ndarray, shape (n, n)
        Covariance ``C`` of the estimate, in units of the variance of an equation's error; changed in place.
    gain : ndarray, shape (n,)
        Gain ``g`` of the correction.
    projected : ndarray, shape (n,)
        ``C x``, of before.
    predicted : float
        ``x' C x``, of before.
    """
    for i in range(gain.size):
        left = projected[i] - gain[i] * predicted  # (I - g x') C x
        for j in range(i + 1):
            entry = spread[i, j] - gain[i] * projected[j] - left * gain[j] + gain[i] * gain[j]
            spread[i, j] = entry
            spread[j, i] = entry
