"""What the integral winds up while the joint stands: it is friction, and leaves with the plan.

At rest behind a position loop the integral winds up on what is left of the position, until the joint breaks away, or
up to there: ``+-Fs`` about the load, whichever way. The joint holds all of it, so it tells nothing of the load. When
the plan sets out, the friction of the new direction is fed on top of it: with the wrong sign the joint stays behind
until the integral has unwound, with the right one it is thrown.

The load ``l`` that the integral ``I`` has to hold is known from the motion before. While the plan rests, a joint that
stands with the torque ``U`` shows that it is within the friction at breakaway ``F`` of it, and with the trust ``gamma``

    l <- min(max(l, U - F), U + F),        I <- I - gamma (I - l)    when the plan sets out

A load that comes at rest is so followed as far as the joint shows it. PI alone keeps what has been wound up: of moves
to and fro it is breakaway in the direction of the next one, as long as it overshoots its stops.
"""

import math
from typing import NamedTuple

from numba.extending import register_jitable

FADES = 4.0
"""Time constant with which what has left is forgotten, s: that of the sums of the trust."""


class Standing(NamedTuple):
    """What a joint at rest has shown of its load.

    Attributes
    ----------
    wound : float
        What integral and observer give beyond the load ``l``, N m.
    rests : bool
        Whether the plan rests.
    left : float
        Torque that has left the integral along with the friction that was fed, at full trust, N m; it fades.
    """

    wound: float
    rests: bool
    left: float


def initial_standing() -> Standing:
    """Return the state of a joint that has not moved."""
    return Standing(0.0, False, 0.0)


@register_jitable
def advance_standing(
    state: Standing, held: float, asked: float, torque: float, friction: float, rests: bool, duration: float
) -> Standing:
    """Return the state after a sample.

    Parameters
    ----------
    state : Standing
        The state.
    held : float
        What integral and observer give, N m.
    asked : float
        By how much the integral has changed over the period that has ended because of an outer loop, N m.
    torque : float
        Torque ``U`` of the period that has ended, beyond what is known, N m.
    friction : float
        Friction ``F`` at breakaway, N m.
    rests : bool
        Whether the plan rests over the coming period.
    duration : float
        Length of the period, s.
    """
    left = state.left * math.exp(-duration / FADES)
    if not rests:
        return Standing(0.0, False, left + state.wound)
    wound = state.wound + asked if state.rests else 0.0
    beyond = held - min(max(held - wound, torque - friction), torque + friction)
    return Standing(max(0.0, min(wound, beyond)) if wound > 0.0 else min(0.0, max(wound, beyond)), True, left)


@register_jitable
def wound_up(before: Standing, now: Standing) -> float:
    """Return what leaves the integral because the plan sets out, N m, where the friction is trusted in full."""
    return 0.0 if now.rests else before.wound
