"""Friction fed forward at rest: the share of it that the joint holds, from the torque that the feedback adds meanwhile.

Where the plan comes to rest most of the Coulomb friction ``Fc`` of the last direction would stay fed forward. The share
``s`` of that does, ``h``. It follows from the torque ``i`` that the integral of the feedback has asked for since the
plan came to rest:

    rho = <(h + i) h> / <h^2>                                         over a rest
    s <- max(0.03, min(1, s sat(rho + 0.05, 0.7, 1.3)))               after it, for the next one

- *Why*: a joint on bristles needs ``h``, by which they stay bent. Other joints do not hold it. A constraint of a
  simulator, or a film of grease, lets a joint creep on along ``h``; behind a position loop the feedback then takes back
  what the feedforward holds, by ``i``, and the next move starts from there. At rest the torque balances friction, so
  the friction that the joint holds is ``h + i``.
- *Where all of it is held*: without an outer loop, and on a joint that stands still, the feedback asks for nothing but
  noise, and ``rho`` is about one.
- *Evidence*: on the roll axis of an arm in MuJoCo, whose Coulomb friction creeps, three quarters of the velocity error
  between moves was made by what was held.
"""

from typing import NamedTuple

from numba.extending import register_jitable

from adaptive_ff.adaptive.learning.fed_model import Block, present_model
from adaptive_ff.adaptive.learning.period import Fed
from adaptive_ff.friction.feedforward import FeedforwardState, is_plan_at_rest, released
from controllers import Inputs

SPARE = 0.05
"""Added to ``rho``: noise alone must not make the share less and less."""

LEAST_CHANGE, LARGEST_CHANGE = 0.7, 1.3
"""Range of the factor on the share after a single rest: a load that comes at rest is none of the joint's friction."""

LEAST_SHARE = 0.03
"""Least share: with none held, a joint could not show that it holds more."""


class HeldFriction(NamedTuple):
    """Share of the friction that is held at rest, and the sums of the present rest.

    Attributes
    ----------
    share : float
        Share ``s`` of what would be held that is held.
    asked : float
        Torque ``i`` that the integral of the feedback has asked for since the plan came to rest, N m.
    shown, held : float
        Integrals of ``(h + i) h`` and ``h^2`` since then, N^2 m^2 s.
    """

    share: float
    asked: float
    shown: float
    held: float


def initial_held_friction() -> HeldFriction:
    """Return the state before the first rest, with the whole share."""
    return HeldFriction(1.0, 0.0, 0.0, 0.0)


@register_jitable
def advance_held_friction(
    state: HeldFriction, friction: float, asked: float, rests: bool, duration: float
) -> HeldFriction:
    """Return the state after a period: at rest the sums grow, after a rest the share follows from them.

    Parameters
    ----------
    state : HeldFriction
        The state.
    friction : float
        Friction ``h`` that was held over the period, N m.
    asked : float
        By how much the integral has changed over it because of the error, N m.
    rests : bool
        Whether the plan rested over it.
    duration : float
        Its length, s.
    """
    if rests:
        in_all = state.asked + asked
        shown = state.shown + (friction + in_all) * friction * duration
        return HeldFriction(state.share, in_all, shown, state.held + friction * friction * duration)
    share = state.share
    if state.held > 0.0:
        change = state.shown / state.held + SPARE
        share = max(LEAST_SHARE, min(1.0, share * max(LEAST_CHANGE, min(change, LARGEST_CHANGE))))
    return HeldFriction(share, 0.0, 0.0, 0.0)


@register_jitable
def friction_shown(block: Block, state: Block, inputs: Inputs, rests: bool) -> HeldFriction:
    """Return the share and the sums after a period, at rest or not, whose velocity was measured."""
    asked = block.feedback.integral * inputs.dt * (inputs.correction - inputs.velocity)
    friction = state.command.share * state.trust.trust * state.feedforward.friction
    return advance_held_friction(state.held_friction, friction, asked, rests, inputs.dt)


@register_jitable
def feedforward_at_rest(block: Block, state: Block, fed: Fed, inputs: Inputs) -> FeedforwardState:
    """Return the state of the feedforward, which at rest holds the share ``s`` of the friction."""
    share = state.held_friction.share
    if share >= 1.0 or not is_plan_at_rest(state.feedforward, inputs, block.feedback.delay):
        return fed.feedforward
    model = present_model(block, fed.estimator, fed.timing.lag, inputs.reference)
    return released(model, fed.feedforward, share, inputs.dt)
