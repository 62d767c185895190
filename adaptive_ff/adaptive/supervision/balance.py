"""Balance of torques along the plan: an upper bound on the friction that is fed, from the mean torque that was needed.

Over some motion, inertia takes as much torque when a joint speeds up as it gives when it slows down. So the mean torque
along the plan, less known and identified loads, is the mean friction, however noisy each sample is: what the model
feeds too much, the feedback takes away again. With the torque ``u``, that of the model without its friction ``u_0``,
all friction of the model ``f``, the plan ``r``, and ``S x`` a sum of ``sgn(r) x dt`` that fades over 20 s of motion,

    share of the friction that is fed <= (S (u - u_0) + 1 s F)/(0.6 (S f + 1 s F))

The second terms are a prior: 1 s of the friction ``F`` at breakaway. The bound is far above one for a model that fits,
and for a joint that sticks, or whose bristles bend, at its reversals.

Where a sensor of few counts makes the feedback kick harder than the friction
(:mod:`adaptive_ff.adaptive.faults.counts`), the numerator has no prior, and 1 stands for 0.6.

- *Why*: velocities of an encoder with few counts teach wrong friction. The torque with which the feedback answers a
  count is noise that is correlated with the velocity, and it may be fifty times the friction.
- *Evidence*: a joint of another simulator, whose encoder now and then gives one count of ten times the planned speed,
  settles at 1.00 of PI's accuracy. Without the bound it settles at a third, with 40 times its Coulomb friction (an
  experiment; ``benchmarks.other_joints`` draws such joints). Where nothing is wrong the bound costs nothing in the
  mean.
- *The observer is not bounded.* If it were, a joint that a brake has held, and that is thrown when the brake opens,
  would track 0.7 % worse than PI.
"""

import math
from typing import NamedTuple

from numba.extending import register_jitable

from adaptive_ff.estimation.shares import saturated

MEMORY = 20.0
"""Time of motion over which the sums fade, s: a load that comes and goes within one stroke is not friction."""

NEEDED = 0.6
"""Mean friction that was needed, over that of the model, from which on all of it is fed."""

PRIOR = 1.0
"""Time of motion for which the friction at breakaway counts in both sums, as a prior, s."""


class Balance(NamedTuple):
    """Sums along the plan.

    Attributes
    ----------
    needed, modelled : float
        Friction that was needed, ``S (u - u_0)``, and that of the model, ``S f``, N m s.
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
        Torque ``u - u_0`` beyond that of the model without friction, N m.
    modelled : float
        All friction ``f`` of the model, N m.
    duration : float
        Length of the period, s.
    """
    if plan == 0.0:
        return state
    keep, along = math.exp(-duration / MEMORY), math.copysign(duration, plan)
    return Balance(keep * state.needed + along * needed, keep * state.modelled + along * modelled)


@register_jitable
def balanced_share(state: Balance, friction: float, kicked: float) -> float:
    """Return the largest share of the friction that is fed, for a friction ``F`` at breakaway (N m).

    As ``kicked`` (:func:`adaptive_ff.adaptive.faults.counts.kicked_share`) goes from 0 to 1, the prior of the numerator
    goes to zero and the factor 0.6 to 1: no more is fed than was needed.
    """
    modelled = state.modelled + PRIOR * friction
    if modelled <= 0.0:
        return 1.0
    needed = state.needed + (1.0 - kicked) * PRIOR * friction
    return saturated(needed / ((NEEDED + kicked * (1.0 - NEEDED)) * modelled))
