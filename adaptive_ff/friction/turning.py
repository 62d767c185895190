"""When friction that is fed forward turns, where the reference reverses.

Friction of the last direction is held until the reference is beyond zero by a speed, or as long as it only touches the
other side: continued along its present parabola, it turns back before it has gone a path. Friction that is turned too
early throws a joint that still slides, by ``2 F/J`` times the time. Turned too late it leaves a joint at rest that
sticks anyway. A plan that hardly crosses zero is not worth the turn: the joint stands still and is no further from the
plan than the plan from zero.
"""

import math
from typing import NamedTuple

from adaptive_ff.friction.model import TorqueModel

TURNED = 0.027
"""Speed at which a reversed reference turns friction, over the change of speed that breakaway makes in a period.

Of 936 joints drawn with seeds 101 to 701, whose friction falls by 0.5 to 10 times the gain, 20 have a window of 5 s
with 1.2 times the error of PI with this and ``TOUCHED``; where 0.04 of Coulomb friction is taken, which is the same for
the built-in joint, and touches are turned for, 37 have.
"""

TOUCHED = 1.35
"""Path of a reference on the other side of zero, over the way that breakaway moves the joint by in a period's square.

With half of it 24 of those joints have such a window, with twice 20. Of 522 of them with seeds from 401 on those whose
friction falls by up to 1, 2, 5 and 10 gains settle at 8.1, 8.2, 5.4 and 2.7 times better than PI (geometric means);
with half at 8.2, 8.3, 5.5 and 2.7, with twice at 7.8, 7.8, 5.3 and 2.7, and at 8.2, 8.3, 5.5 and 2.7 where touches are
turned for.
"""

UNFIT = 2.0
"""The same for a model that misses the torque, over that for one that does not.

Weights of 100 N m that are not modelled have a window of 1.25 times the error of PI at worst (60 references), without
this 1.83.
"""

STEEP = 2.0
"""Fall of friction with speed, in gains, from which that path is shorter in proportion.

Such joints leave and reach the plan in a slip. So they are 2.2 times better than PI and 1.2 times worse in a window
(``steep_10``, 60 references), with twice the path for all of them, and in full, 2.0 and 2.2 times.
"""

RISEN = 1.5
"""Speed up to which friction is held on a touch, over the one that it is expected to rise to."""


class Turning(NamedTuple):
    """When a reversed reference turns friction.

    Attributes
    ----------
    speed : float
        Speed up to which friction of the last direction is held, rad/s; zero where it turns with the reference.
    path : float
        Path up to which a reference that turns back by itself does not turn friction either, rad.
    """

    speed: float
    path: float


def turning_of(model: TorqueModel, inertia: float, gain: float, period: float, unfit: float = 0.0) -> Turning:
    """Return when a reversed reference turns friction.

    Parameters
    ----------
    model : TorqueModel
        The joint's friction.
    inertia : float
        Inertia, kg m^2; without any, friction turns at once.
    gain : float
        Proportional gain of the velocity loop, N m s/rad.
    period : float
        Sampling period, s.
    unfit : float, optional
        Share to which the model misses the torque, from 0 to 1.
    """
    if inertia <= 0.0:
        return Turning(0.0, 0.0)
    throw = max(model.coulomb, model.stiction) / inertia * period
    fall = (model.stiction - model.coulomb) / model.stribeck_velocity
    path = TOUCHED * (1.0 + unfit * (UNFIT - 1.0)) * throw * period
    if fall > STEEP * gain:
        path *= STEEP * gain / fall
    return Turning(TURNED * throw, path)


def is_held(friction: float, start: float, end: float, turned: float) -> bool:
    """Tell whether friction (N m) is held that is of the other direction than a motion that does not reverse.

    It is while start and end of the motion are slower than the speed ``turned``, rad/s.
    """
    return friction * (start + end) < 0.0 and max(abs(start), abs(end)) < turned


def held_speed(turned: float, touched: float, last: float, before: float, start: float, end: float) -> float:
    """Return the speed up to which friction is held over a period, rad/s.

    Parameters
    ----------
    turned : float
        That where the reference does not only touch the other side of zero, rad/s.
    touched : float
        Path of a touch at most, over the period, rad/s.
    last : float
        The speed of the period before, rad/s; on the way back from a touch it stays.
    before : float
        Change of the reference over that period, rad/s.
    start, end : float
        Reference at the start and at the end of the period, rad/s.
    """
    step = end - start
    if touched <= 0.0:
        return turned
    if step * end <= 0.0:
        return max(turned, last)
    bend = step - before
    if step * bend >= 0.0:
        return turned
    slope = step + 0.5 * bend  # at the end, in a period
    highest = abs(end) + 0.5 * slope * slope / abs(bend)
    path = 4.0 / 3.0 * highest * math.sqrt(2.0 * highest / abs(bend))  # of a parabola from zero to zero, in periods
    return max(turned, RISEN * highest) if path < touched else turned
