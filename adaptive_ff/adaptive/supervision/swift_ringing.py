"""Swift ringing: an elastic gear, or one with play, that the observer shakes faster than a rigid joint would ring.

The observer is designed for a rigid joint. Where motor and load are two masses, the torque that it feeds back may drive
their resonance. The half cycles of the error are then shorter than those of
:mod:`adaptive_ff.adaptive.supervision.ringing`, mostly a few samples long. One of them, with the largest error ``A_k``
and the length ``T_k``, is *sustained* where

    A_k > 0.4 A_{k-1},    T_k <= 1.6 J/Kp

(samples meet the peaks at different places, so a half cycle may seem less than half as large as the last). The gear is
taken to ring after ``n`` sustained half cycles in a row, without a reversal of the plan between them, if

    n >= 4,    min(n, 8) A > 0.56 of the plan's largest speed,    A > 0.25 F/Kp,    A^2 > 25 variances of the noise

with ``A`` the largest error of the last one, and the friction ``F`` at breakaway. What follows:

- *First* the observer is slowed to 0.2 of its pole, which is slow enough for most gears.
- *If it rings with that as well*, the observer is switched off. The next 8 sustained half cycles do not count,
  since a gear swings on for a while by itself.
- *Beside noise that seems coloured* (:mod:`adaptive_ff.adaptive.supervision.colour`) ``n`` must be 32, and the observer
  is slowed but not switched off: there it must help anyway
  (:mod:`adaptive_ff.adaptive.supervision.observer_effect`). Counts that a filter has made slow swing like a gear for
  some half cycles, and a gear that swings within a few samples looks like such noise; but only the gear goes on.
- *Why the error is compared with the friction*: on slow plans, counts behind a Kalman filter make errors larger than
  the plan. Without that condition such joints lose the observer as well. The two of 350 drawn scenarios that lose most
  settle at 1.06 and 1.00 times better than PI instead of 1.95 and 1.66 (seed 604, an experiment).
- *Before the noise is known* such an oscillation looks like noise itself. Nine times the least variance so far stands
  for its variance then (:mod:`adaptive_ff.adaptive.supervision.noise_level`).
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
"""Least ratio of the largest error of a half cycle to that of the one before, for it to be sustained ..."""

LONGEST = 1.6
"""... and the longest one that counts, in time constants of the proportional loop."""

FEWEST = 4
"""Least number of sustained half cycles in a row ..."""

FEWEST_COLOURED = 32
"""... and where the noise seems coloured.

Alternatives that are not used, on joints behind Kalman filters at 1 kHz with 8192 to 65536 counts (seeds 101 to 130):

- No half cycle is ringing beside such noise: the first 5 s of a gear may have ten times PI's error, since the observer
  shakes it until the noise is known. 18 of 120 joints have a window above 1.2 times PI's error instead of 11, and
  medians are up to 9 % lower.
- 8 or 16 half cycles: as with 32, but for single joints whose friction triples.
- The observer is switched off: four of 30 joints with a load that comes settle at 1.1 to 1.6 times better than PI
  instead of 3.3 and more.
"""

FELT = 0.25
"""Least error of ringing, over the one that friction at breakaway makes at the proportional gain."""

SLOWED = 0.2
"""Pole of an observer that has shaken a gear, over that of the design.

How the ratio of PI's settled error to the controller's changes with this rule, on the drawn joints with elastic gears
or play that it changes (13 of seed 603, 30 of seed 606, geometric means): 1.11 and 1.53 times; with 0.3 of the pole
1.04 and 1.47; with 0.5 0.91 (seed 603); with the observer switched off at once 0.89 and 1.38.
"""

DIES_OUT = 8
"""Sustained half cycles that do not count after that: a gear swings on for a while by itself."""


class Background(NamedTuple):
    """Noise and friction with which short half cycles are compared.

    Attributes
    ----------
    variance : float
        Variance of the noise of the measured velocity, without motion that looks like noise, rad^2/s^2.
    coloured : bool
        Whether that noise seems coloured.
    stuck_error : float
        Error that friction at breakaway makes at the proportional gain, rad/s.
    """

    variance: float
    coloured: bool
    stuck_error: float


@register_jitable
def advance_swift(state: Ringing, error: float, variance: float, time_constant: float, duration: float) -> Ringing:
    """Return the short half cycles after a sample.

    Parameters
    ----------
    state : Ringing
        Short half cycles so far; ``blamed`` where the observer has been slowed because of them.
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
    """Tell whether the gear rings, for noise and friction, and the largest speed of the plan of late (rad/s)."""
    least = max(TOGETHER * peak / max(1, min(state.sustained, MOST)), FELT * beside.stuck_error)
    squared = state.last_extreme * state.last_extreme
    fewest = FEWEST_COLOURED if beside.coloured else FEWEST
    return state.sustained >= fewest and state.last_extreme > least and squared > LOUD * beside.variance
