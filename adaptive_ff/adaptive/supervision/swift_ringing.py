"""Swift ringing: an elastic gear, or one with play, that an observer shakes faster than a rigid joint rings.

The observer is designed for a rigid joint. Where motor and load are two masses, what it feeds back may drive their
resonance, whose half cycles are shorter than those of :mod:`adaptive_ff.adaptive.supervision.ringing`, mostly a few
samples:

    A_k >= 0.4 A_{k-1},    T_k < 1.6 J/Kp

with the largest error ``A`` and the length ``T`` of each. Samples meet them at different places, so one may be less
than half of the last. Of ``n`` such half cycles in a row, all in one motion,

    n >= 4,    min(n, 8) A > 0.56 of the plan's largest speed,    A > 0.25 F/Kp

with the friction ``F`` at breakaway are taken for ringing. The observer goes on with 0.2 of its pole, which is slow
enough for most gears; only where that rings as well is it let go of. Without the last condition slow plans with counts
behind a Kalman filter, whose errors are larger than the plan, lose the observer as well: the two of 350 drawn scenarios
that lose most settle at 1.06 and 1.00 times better than PI instead of 1.95 and 1.66 (seed 604, an experiment).

Counts that a filter has made slow swing like a gear for some half cycles, and a gear that swings within a few samples
looks like such noise. Only the gear goes on and on, so beside noise that seems coloured 32 half cycles are asked for,
and the observer is slowed but not let go of: there it must help anyway.

Before the noise is known such an oscillation looks like noise itself; nine times the least variance so far stands for
it then (:mod:`adaptive_ff.adaptive.supervision.noise_level`).
"""

from typing import NamedTuple

from numba.extending import register_jitable

from adaptive_ff.adaptive.supervision.ringing import (
    LOUD,
    MOST,
    TOGETHER,
    Ringing,
    crosses,
    grown_half_cycle,
    next_half_cycle,
)

KEEPS = 0.4
"""Largest error of a half cycle over that of the one before, from which on it counts ..."""

LONGEST = 1.6
"""... where its length is at most this, in time constants of the proportional loop."""

FEWEST = 4
"""Half cycles in a row, at least ..."""

FEWEST_COLOURED = 32
"""... and where the noise seems coloured.

Were nothing taken for ringing beside such noise, the first 5 s of a gear might have ten times the error of PI: the
observer would shake it until the noise is known. Of joints behind Kalman filters at 1 kHz with 8192 to 65536 counts 18
of 120 would have a window above 1.2 times PI's error instead of 11, and medians would be up to 9 % lower. With 8 or 16
half cycles it is as with 32, but for single joints whose friction triples (seeds 101 to 130). Were the observer let go
of, four of 30 with a load that comes would settle at 1.1 to 1.6 times better than PI instead of 3.3 and more.
"""

FELT = 0.25
"""Share of what friction at breakaway makes of the proportional gain, from which on their errors count."""

SLOWED = 0.2
"""Pole of an observer that has shaken a gear, over that of the design.

Where the observer is let go of instead, the drawn joints with elastic gears or play that the rule changes settle at
0.89 and 1.38 times the ratio to PI that they have without it (13 of seed 603, 30 of 606, geometric means); with 0.5 of
the pole the former at 0.91, with 0.3 at 1.04 and 1.47, with this at 1.11 and 1.53.
"""

DIES_OUT = 8
"""Half cycles that are not counted after that: a gear swings on for a while by itself."""


class Background(NamedTuple):
    """What short half cycles are judged beside.

    Attributes
    ----------
    variance : float
        Variance of the measured velocity that holds no motion which looks like noise, rad^2/s^2.
    coloured : bool
        Whether its noise seems coloured.
    stuck_error : float
        Error that friction at breakaway makes of the proportional gain, rad/s.
    """

    variance: float
    coloured: bool
    stuck_error: float


@register_jitable
def advance_swift(state: Ringing, error: float, variance: float, time_constant: float, duration: float) -> Ringing:
    """Take the error of a sample into account.

    Parameters
    ----------
    state : Ringing
        Short half cycles so far; blamed, where the observer has been slowed for them.
    error : float
        Error that the feedback sees, rad/s.
    variance : float
        Variance of the measured velocity, rad^2/s^2.
    time_constant : float
        ``J/Kp``, s.
    duration : float
        Length of the period, s.
    """
    length, most = state.length + duration, LONGEST * time_constant
    if not crosses(state, error, variance):
        grown = grown_half_cycle(state, error, length)
        return grown if length <= most else grown._replace(sustained=0)
    return next_half_cycle(state, error, KEEPS, length <= most)


@register_jitable
def slowed(state: Ringing) -> Ringing:
    """Return the state of a loop whose observer is slowed from now on."""
    return state._replace(sustained=-DIES_OUT, blamed=True)


@register_jitable
def pace(state: Ringing) -> float:
    """Return the pole of the observer over that of the design."""
    return SLOWED if state.blamed else 1.0


@register_jitable
def rings_swiftly(state: Ringing, beside: Background, peak: float) -> bool:
    """Tell whether the loop rings, beside a background and the largest speed of the plan of late (rad/s)."""
    least = max(TOGETHER * peak / max(1, min(state.sustained, MOST)), FELT * beside.stuck_error)
    squared = state.last_extreme * state.last_extreme
    fewest = FEWEST_COLOURED if beside.coloured else FEWEST
    return state.sustained >= fewest and state.last_extreme > least and squared > LOUD * beside.variance
