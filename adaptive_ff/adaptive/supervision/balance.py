"""Balance of torques along the plan: no more friction is fed than the joint turns out to need.

Inertia takes as much torque when a joint speeds up as it gives when it slows down. So over some motion the mean torque
along the plan, beside the loads that are known or identified, is the mean friction, however noisy each sample is: what
the model feeds too much the feedback takes away again. With ``u`` the torque, ``u_0`` that of the model without its
friction ``f``, ``r`` the plan, and sums that fade over 20 s of motion,

    share of the friction that is fed <= (sum sgn(r) (u - u_0) + F)/(0.6 (sum sgn(r) f + F))

with 1 s of the friction ``F`` at breakaway as a prior. Where a sensor of few counts makes the feedback kick harder than
the friction (:mod:`adaptive.faults.counts`), the prior is nought and 1 stands for 0.6. A model that fits is far above
that bound, and so is one of a joint that sticks or bends at its reversals.

Velocities of an encoder with few counts teach the wrong friction: the noise of the torque that answers to them is
correlated with them, and may be fifty times the friction. A joint of another simulator, whose encoder gives one count
of ten times the planned speed now and then, settles at 1.00 of the accuracy of PI, without this at a third, with 40
times its Coulomb friction (an experiment; ``benchmarks.other_joints`` draws such ones). Where nothing is wrong it costs
nothing in the mean. The observer is not bounded by it: a joint that a brake has held and that is thrown when it lets go
would track 0.7 % worse than PI.
"""

import math
from typing import NamedTuple

from numba.extending import register_jitable

from adaptive_ff.estimation.shares import saturated

MEMORY = 20.0
"""Motion over which the sums fade, s: loads that come and go along one stroke are no friction."""

NEEDED = 0.6
"""Mean friction needed, over that of the model, from which on all of it is fed."""

PRIOR = 1.0
"""Motion for which the friction at breakaway stands in both sums, s."""


class Balance(NamedTuple):
    """Sums along the plan.

    Attributes
    ----------
    needed, modelled : float
        Friction that the torque tells of, and that of the model, N m s.
    """

    needed: float
    modelled: float


def initial_balance() -> Balance:
    """Return the state before any motion."""
    return Balance(0.0, 0.0)


@register_jitable
def advance_balance(state: Balance, plan: float, needed: float, modelled: float, duration: float) -> Balance:
    """Return the state after a period.

    Parameters
    ----------
    state : Balance
        The state.
    plan : float
        Planned velocity, rad/s.
    needed : float
        Torque beside that of the model without friction, N m.
    modelled : float
        Friction of the model, all of it, N m.
    duration : float
        Length of the period, s.
    """
    if plan == 0.0:
        return state
    keep, along = math.exp(-duration / MEMORY), math.copysign(duration, plan)
    return Balance(keep * state.needed + along * needed, keep * state.modelled + along * modelled)


@register_jitable
def balanced_share(state: Balance, friction: float, kicked: float) -> float:
    """Return the largest share of the friction that is fed, for a friction at breakaway (N m).

    To the share ``kicked`` (:func:`adaptive.faults.counts.kicked_share`) the prior is none, and all that is fed is
    needed.
    """
    modelled = state.modelled + PRIOR * friction
    if modelled <= 0.0:
        return 1.0
    needed = state.needed + (1.0 - kicked) * PRIOR * friction
    return saturated(needed / ((NEEDED + kicked * (1.0 - NEEDED)) * modelled))
