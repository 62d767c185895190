"""What an observer is told of a joint beside its motion, and when a joint seems to be held by a brake."""

from typing import NamedTuple

from numba.extending import register_jitable

HELD = 3.0
"""Torque at which a joint still sticks, over the largest one with which it has moved, from which a brake holds it.

Not less: at 1.5 friction that triples is taken for a brake, and the first 5 s after it leave 0.39 of the error of PI,
not 0.24.
"""


class Circumstances(NamedTuple):
    """What is known of a joint in a period beside its motion.

    Attributes
    ----------
    held : bool
        Whether the disturbance is held.
    peak : float
        Largest speed of the plan of late, rad/s.
    strained : bool
        Whether the drive gives far more torque than has ever moved the joint, see :func:`strains`.
    falls : bool
        Whether the identified friction falls so steeply that the joint rings by itself.
    believed : bool
        Whether the drive has never been asked for a torque that it may not give; see
        :mod:`adaptive_ff.adaptive.faults.drive_limit`.
    saturates : bool
        Whether it has seemed to saturate, for long.
    friction : float
        Friction beside which noise counts, N m.
    unforeseen : float
        What of the plan was not foreseen when the torque of the period was fed forward, rad/s.
    learnt : bool
        Whether anything has been learnt from the joint, or a model was given.
    """

    held: bool
    peak: float
    strained: bool
    falls: bool
    believed: bool
    saturates: bool
    friction: float
    unforeseen: float
    learnt: bool


@register_jitable
def strains(torque: float, moved: float) -> bool:
    """Tell whether a torque is far larger than any with which the joint has moved, both less what is known, N m."""
    return abs(torque) > HELD * moved
