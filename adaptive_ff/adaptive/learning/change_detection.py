"""Sudden changes of friction: noticed from the prediction error, and what was known of the size of friction forgotten.

A fading memory mixes equations from before and after a change. Until the old ones have faded, the fit makes up for the
difference with whatever can explain it, inertia and lag included, and the feedforward can be worse than none.

What changes in a working joint is how large friction is: lubricant, temperature, load and wear scale it, or part of it.
So the mean over a short window of the error ``e`` times the predicted friction ``f`` is compared with the usual error:

    <e f>^2 / <f^2>  >  JUMP <e^2>

The left-hand side is the part of the short mean of ``e^2`` that a common factor on friction explains. Where it is that
large, and larger than what the prediction is in doubt by (``estimator.is_change``), the information ``M`` about that
factor, the direction ``d`` of the friction parameters in the space of all, is reduced to what the short window holds,

    M  ->  M - (1 - known / d'M d) M d d'M / (d'M d)

which is what a large variance added along ``d`` makes of a covariance; what ``M`` holds of everything else, the ratios
of the parameters among them, stays. For ``known > 0`` the result is positive definite.

Where an offset is estimated, the change may be a load as well. While the joint moves one way nobody can know: then
nothing is learnt, whoever has an observer lets it carry the torque, half of the change is fed forward as friction
(:func:`undecided_factor`), and it is attributed when the joint has moved the other way (:func:`attribute_change`). A
change that undoes the last load, as the end of a push, is that load at once, but only once: a load of alternating sign
is friction. Only what a change is attributed to is forgotten, and set to what the short window says: the offset by its
mean error, or all friction by the factor ``1 + <e f>/<f^2>``.
While a load settles only offset and known loads are corrected, and candidates are not compared. Through a push of
80 N m for 3 s inertia and friction stay within 10 % (``python -m benchmarks.push``); corrected with the others inertia
moved by 35 %, viscous friction by 43 %.

For comparing short with long means see M. Basseville and I. Nikiforov, "Detection of Abrupt Changes" (Prentice Hall,
1993).
"""

import math
from typing import NamedTuple

from numba.extending import register_jitable

JUMP = 6.0
"""How many times the usual mean squared error the part that a factor on friction explains must be."""

JUMP_WINDOW = 4.0
"""Length of the short window, in time constants of the filters."""

LEAST_ERROR = 1e-9
"""Mean squared error, in units of the torque scale squared, that is usual at least."""


TURNED = 0.5
"""Friction the other way, as a share of that at the alarm, from which the joint has turned."""

TURNED_FOR = 1.5
"""For how long it must have, in short windows, until their means tell of that direction alone."""

LONGEST_WAIT = 1.0
"""Longest time without a decision, in memories of the estimator."""

RENEWED = 0.7
"""Share of its size so far from which the latest mean takes its place; less is the mixture of a short turn."""

LETTING_GO = 0.1
"""Reverse of the last load, as a share of it, from which that load is taken to end before it has settled."""

UNDONE = 0.3
"""Difference between a change and the reverse of the last load, as a share of it, up to which the load is undone."""

HEDGE = 0.5
"""Share of a change that is fed forward as friction while it may be a load.

Measured with an observer that is not yet on where a change shows its cause (seeds 101 to 130): the first 5 s after a
drop of friction have 0.39, 0.36, 0.32 and 0.29 of PI's error with 0, 0.5, 0.8 and 1, after a load step of 80 N m 0.29,
0.35, 0.41 and 0.42; and the larger the share, the more pushes of 80 N m leave 1.2 times the undisturbed error or more.
"""

LEAST_LIKELY, LARGEST_LIKELY = 0.3, 4.0
"""Range of the factor on friction in which a change may be one of friction; what goes beyond looks like a load."""

SETTLING = 20.0
"""Time after a decision in which no other is made, in short windows, but that a load that was followed ends."""


class Surprise(NamedTuple):
    """Means over a short window, in units of the torque scale squared.

    Attributes
    ----------
    product : float
        Mean of the prediction error times the predicted friction, ``<e f>``.
    friction_squared : float
        Mean of the predicted friction squared, ``<f^2>``.
    error : float
        Mean of the prediction error ``<e>``, in units of the torque scale.
    """

    product: float
    friction_squared: float
    error: float


@register_jitable
def note_surprise(surprise: Surprise, friction: float, error: float, duration: float, window: float) -> Surprise:
    """Return the means over the short window with one more error taken into account.

    Parameters
    ----------
    surprise : Surprise
        The means so far.
    friction, error : float
        Predicted friction and prediction error, in the same unit.
    duration : float
        Time since the last sample, s.
    window : float
        Length of the window, s.
    """
    share = duration / (window + duration)
    product = surprise.product + share * (friction * error - surprise.product)
    squared = surprise.friction_squared + share * (friction * friction - surprise.friction_squared)
    return Surprise(product, squared, surprise.error + share * (error - surprise.error))


@register_jitable
def explained_by_friction(surprise: Surprise) -> float:
    """Return the part of the mean squared error that a common factor on friction explains."""
    if not surprise.friction_squared > 0.0:
        return 0.0
    return surprise.product * surprise.product / surprise.friction_squared


NOTHING, UNDECIDED, FRICTION, LOAD, EITHER = range(5)
"""What a change is attributed to."""


class Alarm(NamedTuple):
    """A change that was noticed, and what it is attributed to.

    Attributes
    ----------
    cause : int
        ``NOTHING``, ``UNDECIDED``, ``FRICTION``, ``LOAD`` or ``EITHER``.
    product : float
        Mean of prediction error times predicted friction when it was noticed, and once it is attributed to friction,
        the mean since the joint turned; see :class:`Surprise`.
    friction : float
        Predicted friction then, in units of the torque scale.
    age : float
        For how long this has been the cause, s of sliding motion.
    turned : float
        For how much of it the joint has moved the other way, s.
    load : float
        The last change that was attributed to a load, in units of the torque scale.
    undone : bool
        Whether that was the end of the load before it.
    """

    cause: int
    product: float
    friction: float
    age: float
    turned: float
    load: float
    undone: bool


NO_ALARM = Alarm(NOTHING, 0.0, 0.0, 0.0, 0.0, 0.0, False)


@register_jitable
def load_is_undone(alarm: Alarm, surprise: Surprise, window: float) -> bool:
    """Return whether a change that has filled the short window (s) is about the reverse of the last load.

    A load is undone once: friction that is taken for a load changes its sign at every reversal, again and again.
    """
    filled = alarm.age > TURNED_FOR * window and not alarm.undone
    return filled and abs(surprise.error + alarm.load) < UNDONE * abs(alarm.load)


@register_jitable
def since_turned(mean: float, before: float, windows: float) -> float:
    """Return the mean over the time since the joint turned, in short windows, of a short mean that holds older ones."""
    left = math.exp(-windows)
    return (mean - left * before) / (1.0 - left)


@register_jitable
def begun(alarm: Alarm, cause: int, product: float, friction: float) -> Alarm:
    """Return the alarm with a cause from now on; what is known of the last load stays."""
    return Alarm(
        cause=cause,
        product=product,
        friction=friction,
        age=0.0,
        turned=0.0,
        load=alarm.load,
        undone=alarm.undone,
    )


@register_jitable
def begun_load(alarm: Alarm, product: float, load: float, undone: bool) -> Alarm:
    """Return the alarm with a load (in units of the torque scale) as its cause from now on."""
    return Alarm(
        cause=LOAD,
        product=product,
        friction=alarm.friction,
        age=0.0,
        turned=0.0,
        load=load,
        undone=undone,
    )


@register_jitable
def gone_on(alarm: Alarm, product: float, age: float, turned: float) -> Alarm:
    """Return the alarm of the same cause, with the age and the time since the joint turned that it has by now (s)."""
    return alarm._replace(product=product, age=age, turned=turned)


@register_jitable
def settle_change(alarm: Alarm, other_way: bool, window: float, duration: float) -> Alarm:
    """Return the alarm of a change whose cause is decided, after a sample with motion the other way or not."""
    age, turned = alarm.age + duration, alarm.turned
    if alarm.cause == EITHER and turned == 0.0 and not other_way:
        age = 0.0  # only the other way shows which it was: what is surprising there is no other change
    elif alarm.cause == EITHER:
        turned += duration
    if age > SETTLING * window:
        return begun(alarm, NOTHING, 0.0, 0.0)
    return gone_on(alarm, alarm.product, age, turned)


@register_jitable
def decide_change(
    alarm: Alarm, surprise: Surprise, friction: float, window: float, longest: float, duration: float
) -> Alarm:
    """Return the alarm of a change without a cause; parameters are those of :func:`attribute_change`."""
    product, age, turned = alarm.product, alarm.age + duration, alarm.turned
    if abs(friction) > TURNED * abs(alarm.friction):
        if friction * alarm.friction < 0.0:
            turned += duration
        else:
            turned = 0.0  # not for long enough: the means are mixed
            if abs(surprise.product) > RENEWED * abs(product):
                product = surprise.product  # the latest: a push may have ended since
    if turned > TURNED_FOR * window:
        if surprise.product * product < 0.0:
            return begun_load(alarm, product, surprise.error, False)
        since = since_turned(surprise.product, product, turned / window)
        return begun(alarm, FRICTION, since, alarm.friction)
    if age > longest:
        return begun(alarm, EITHER, product, alarm.friction)
    return gone_on(alarm, product, age, turned)


@register_jitable
def attribute_change(
    alarm: Alarm, noticed: bool, surprise: Surprise, friction: float, window: float, longest: float, duration: float
) -> Alarm:
    """Return the alarm after a sample of sliding motion.

    While the joint moves one way, a load and a change of friction are one number. So a change waits for a decision
    until the joint has moved the other way: if the errors then have the sign that they had before, it is a load; if
    they have turned with the motion, it is friction. What undoes the last load need not wait.

    Parameters
    ----------
    alarm : Alarm
        The alarm so far.
    noticed : bool
        Whether there is a change at this sample.
    surprise : Surprise
        Means over the short window.
    friction : float
        Predicted friction at this sample, in units of the torque scale.
    window, longest : float
        Length of the short window, and longest time without a decision, s.
    duration : float
        Time since the last sample, s.
    """
    if alarm.cause == NOTHING:
        return begun(alarm, UNDECIDED, surprise.product, friction) if noticed else alarm
    if (noticed or alarm.cause == UNDECIDED) and load_is_undone(alarm, surprise, window):
        return begun_load(alarm, alarm.product, -alarm.load, True)
    lets_go = not alarm.undone and surprise.error * alarm.load < -LETTING_GO * alarm.load * alarm.load
    if alarm.cause == LOAD and noticed and lets_go:
        return begun(alarm, UNDECIDED, surprise.product, friction)
    if alarm.cause == UNDECIDED:
        return decide_change(alarm, surprise, friction, window, longest, duration)
    return settle_change(alarm, friction * alarm.friction < 0.0, window, duration)


@register_jitable
def undecided_factor(alarm: Alarm, surprise: Surprise, window: float) -> float:
    """Return the factor on the friction that is fed forward while it is not known whether a change is a load.

    Along the motion all torques that explain the change are the same, and the integral gives up what friction is given.
    Where the motion reverses, a change that is taken for the wrong cause is missed twice; half of each is missed once.
    Before the change fills the short window (s) its size is not known.
    """
    if alarm.cause != UNDECIDED or not (alarm.age > TURNED_FOR * window and surprise.friction_squared > 0.0):
        return 1.0
    factor = 1.0 + alarm.product / surprise.friction_squared
    return 1.0 + HEDGE * (factor - 1.0) if LEAST_LIKELY < factor < LARGEST_LIKELY else 1.0


@register_jitable
def shows_cause(alarm: Alarm, plan: float) -> bool:
    """Return whether a plan (rad/s) moves the way that shows whether a change was a load, which is not known yet."""
    return (alarm.cause == UNDECIDED or alarm.cause == EITHER) and plan * alarm.friction < 0.0


@register_jitable
def is_decided(alarm: Alarm) -> bool:
    """Return whether a change has just been attributed to a load or to friction."""
    return (alarm.cause == LOAD or alarm.cause == FRICTION) and alarm.age == 0.0
