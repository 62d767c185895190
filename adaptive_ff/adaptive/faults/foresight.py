"""Foresight: how far the last slope of the plan is continued where ``next_reference`` is not given.

Without ``next_reference`` the plan of the coming period is extrapolated. That is right for a plan that is computed at
every sample. It is wrong for one that comes at a slower rate and is held in between, or in steps: each step is then fed
forward as an inertia torque that the plan does not need, and the feedback answers the step a second time. The two are
told apart by how alike successive changes ``D`` of the plan are,

    rho = <D_k D_(k-1)> / <D_k^2>

with means over a second: one for a smooth plan, zero for one that is held for two samples or more. The slope is
continued in full from ``rho = 0.9`` on, not at all up to 0.5, and in proportion between.

Evidence: on the built-in joint, with trapezoidal moves that are held for five samples, the controller settles at 1.03
to 1.20 of PI's accuracy; if the slope were always continued, at 0.73 to 0.84.
"""

import math
from typing import NamedTuple

from numba.extending import register_jitable

MEAN = 1.0
"""Time constant of the means, s."""

ALIKE, UNLIKE = 0.9, 0.5
"""``rho`` from which on the slope is continued in full, and up to which it is not continued."""

NONE = 1e-300
"""Added to what may be zero, rad^2/s^2."""


class Foresight(NamedTuple):
    """Means over the changes of a plan.

    Attributes
    ----------
    slope : float
        Last change from one sample to the next, rad/s.
    product, square : float
        Means of the product of two changes in a row, and of the square of one, rad^2/s^2.
    coming : float
        Plan at the next sample, as it is given or foreseen, rad/s.
    """

    slope: float
    product: float
    square: float
    coming: float


def initial_foresight() -> Foresight:
    """Return the state before a plan has changed."""
    return Foresight(0.0, 0.0, 0.0, 0.0)


@register_jitable
def advance_foresight(state: Foresight, reference: float, following: float, slope: float, duration: float) -> Foresight:
    """Return the state after a sample.

    Parameters
    ----------
    state : Foresight
        The state.
    reference, following : float
        Plan now and at the next sample, rad/s; the latter is not a number where it is not known.
    slope : float
        Change of the plan since the last sample, rad/s.
    duration : float
        Length of the period, s.
    """
    weight = duration / (MEAN + duration)
    product = state.product + weight * (slope * state.slope - state.product)
    square = state.square + weight * (slope * slope - state.square)
    coming = following
    if not math.isfinite(following):
        coming = reference + continued_share(product, square) * slope
    return Foresight(slope, product, square, coming)


@register_jitable
def continued_share(product: float, square: float) -> float:
    """Return the share of the slope that is continued, from the means (rad^2/s^2)."""
    likeness = product / (square + NONE)
    return min(1.0, max(0.0, (likeness - UNLIKE) / (ALIKE - UNLIKE)))
