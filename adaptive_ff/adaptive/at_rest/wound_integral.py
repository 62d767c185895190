"""Wound-up integral of a joint at rest: it becomes friction of the feedforward when the plan sets out.

Behind a position loop the integral winds up at rest on what is left of the position error, ``w = sum Ki c dt`` with the
correction ``c``: until the joint breaks away, or up to there, ``+-Fs`` about the load, in either direction. A joint
that stands holds all of it, so ``w`` is friction and no load. When the plan sets out, it goes on as friction ``f`` of
the feedforward, to the share ``gamma`` to which friction is fed:

    f <- min(max(f + w, -F), F),        I <- I - gamma (change of f)        when the plan sets out,

with the friction ``F`` at breakaway. From then on it turns with the friction, and the torque does not jump. Bristles
are bent by the share ``f/F`` then.

- *Why*: friction of the new direction would be fed on top of ``w``. Where ``w`` has the wrong sign the joint would stay
  behind until the integral has unwound; where it has the right one the joint would be thrown. PI alone keeps ``w``,
  which is the breakaway torque of the next move if that goes the other way and the joint has overshot its stop. On
  moves to and fro between rests of seconds the velocity error would be 1.5 to 3 times PI's.
- *What integral and observer hold beyond* ``w`` is the load. A load that comes at rest shows as well: while the joint
  stands with the torque ``U``, the load is within ``F`` of ``U``, so ``w`` is never larger than that allows.
- *Trust*: for the loop, what leaves the integral is a fed torque of the other sign, and
  :mod:`adaptive_ff.adaptive.supervision.trust` takes it into account. Otherwise trust would count it against the
  friction where the integral has wound up in the right direction.
"""

import math
from typing import NamedTuple

from numba.extending import register_jitable

from adaptive_ff.adaptive.supervision.trust import MEMORY


class Standing(NamedTuple):
    """What has been wound up while the plan rests.

    Attributes
    ----------
    wound : float
        What integral and observer give beyond the load, ``w``, N m.
    rests : bool
        Whether the plan rests.
    left : float
        What has left the integral of late, at full trust, N m: it fades like the sums of the trust.
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
    """Return the state after a period.

    Parameters
    ----------
    state : Standing
        The state.
    held : float
        What integral and observer give, N m.
    asked : float
        By how much the integral has changed over the period because of an outer loop, N m.
    torque : float
        Torque ``U`` that the joint stands with, beyond what is known, N m, without the noise of its velocity.
    friction : float
        Friction ``F`` at breakaway, N m.
    rests : bool
        Whether the plan rests over the coming period.
    duration : float
        Length of the period, s.
    """
    left = state.left * math.exp(-duration / MEMORY)
    if not rests:
        return Standing(0.0, False, left)
    wound = state.wound + asked if state.rests else 0.0
    most = held - min(max(held - wound, torque - friction), torque + friction)
    return Standing(max(0.0, min(wound, most)) if wound > 0.0 else min(0.0, max(wound, most)), True, left)


@register_jitable
def having_left(state: Standing, torque: float) -> Standing:
    """Return the state once a torque (N m) has become friction of the feedforward."""
    return Standing(state.wound, state.rests, state.left + torque)


@register_jitable
def wound_up(before: Standing, now: Standing) -> float:
    """Return what has been wound up where the plan sets out, N m; zero where it rests, or has not rested."""
    return 0.0 if now.rests else before.wound
