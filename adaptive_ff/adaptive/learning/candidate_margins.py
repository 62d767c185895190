"""When a candidate is taken: how much of the error in use it may leave.

See :mod:`adaptive_ff.adaptive.learning.candidates`.
"""

import numpy as np
from numba.extending import register_jitable
from numpy.typing import NDArray

MARGIN = 0.75
"""Mean squared error of a candidate over that of the one in use, below which it takes its place."""

BENT_MARGIN = 0.3
"""The same where the candidate has a presliding distance: a load that depends on position looks like bristles."""

SHORT_MARGIN = 0.7
"""The same where that is a short one, up to ``Vs`` by the pole of the filters, ``Vs J/Kp`` by default.

It, or a lag in time, whichever is in use first, makes the joint move so that it fits: what stays has to be taken early.
Where all reversals are alike, a way and a time are the same: the time stays, and only what is far better replaces it.
"""

RETURN_MARGIN = 1.5
"""The same for one without a presliding distance where the one in use has one, which must stay clearly better.

Else bristles that a disturbance of the plan has feigned would stay for ever: where there are none, both leave the same.
"""

SHORT_RETURN_MARGIN = 1.3
"""The same where the one in use has a short one."""

ALIKE = 1.5
"""Largest over least acceleration at reversals up to which they are alike: what takes a time there bends on one way."""

FADING = 0.1
"""Share by which the least and the largest go back to the last one at each reversal."""


@register_jitable
def note_reversal_in_place(reversals: NDArray[np.float64], acceleration: float) -> None:
    """Note the acceleration (rad/s^2, without its sign) at which the reference reversed, started or stopped."""
    if reversals[1] == 0.0:
        reversals[0], reversals[1] = acceleration, acceleration
    reversals[0] = min(acceleration, reversals[0] + FADING * (acceleration - reversals[0]))
    reversals[1] = max(acceleration, reversals[1] + FADING * (acceleration - reversals[1]))


@register_jitable
def alike(reversals: NDArray[np.float64]) -> bool:
    """Return whether the reference reversed, and each time at about the same acceleration."""
    return 0.0 < reversals[1] <= ALIKE * reversals[0]  # type: ignore[no-any-return]


@register_jitable
def least_error(errors: NDArray[np.float64], count: int) -> float:
    """Return the least of the first errors, so many."""
    least = errors[0]
    for i in range(count):
        least = min(least, errors[i])
    return least  # type: ignore[no-any-return]


@register_jitable
def margin_of(present: float, tried: float, short: float) -> float:
    """Return the share of the error in use below which another candidate is taken.

    Parameters
    ----------
    present, tried : float
        Presliding distance of the candidate in use and of the other one, rad, zero where there is none.
    short : float
        Longest distance that a lag in time may be taken for, rad.
    """
    if tried > 0.0:
        return SHORT_MARGIN if tried <= short else BENT_MARGIN
    if present > short:
        return RETURN_MARGIN
    return SHORT_RETURN_MARGIN if present > 0.0 else MARGIN
