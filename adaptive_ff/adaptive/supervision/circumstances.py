"""What the observer knows of a joint beside its motion, and when the joint does not answer to the observer at all.

The observer assumes that torque moves the joint. There it would feed back its own torque, and so it is switched off:

- *A brake holds the joint*: it has stuck for longer than 2 s although its plan moves, or it sticks although the drive
  gives more than 3 times the largest torque with which it has moved.
- *The joint has run away*: for 0.3 s the error is beyond three times the plan's largest speed and ten standard
  deviations of the noise (the squares added). The drive gives less than it says.
- *The loop hunts* from sample to sample (:func:`adaptive_ff.adaptive.supervision.noise_level.hunts`), as it does with
  an inertia that is given twice too large: off for 1 s.
"""

from typing import NamedTuple

from numba.extending import register_jitable

from adaptive_ff.adaptive.supervision.noise_level import NoiseState, hunts, noise_known
from adaptive_ff.adaptive.supervision.observer_state import ObserverState

HELD = 3.0
"""Torque of a joint that sticks, over the largest one with which it has moved, beyond which a brake holds it.

With 1.5 friction that triples is taken for a brake, and the first 5 s after it leave 0.39 of PI's error, not 0.24.
"""

CLAMPED = 2.0
"""Time for which a joint may stick while its plan moves, s; after that something else than friction holds it.

Of 116 drawn joints whose friction falls by more than 15 gains (seeds 101, 201 and 301) 10 settle below 0.95 of PI's
accuracy, the worst at 0.85, as they do without this rule. With 0.6 s it would be 12, the worst at 0.69.
"""

AWAY = 3.0
"""Error in largest speeds of the plan, ..."""

BEYOND = 10.0
"""... and in standard deviations of the noise, beyond which a joint runs away ..."""

GONE = 0.3
"""... and the time for which that may last, s: a joint that sticks and slips comes back sooner."""

CALM = 1.0
"""Time for which the observer is off after a sample at which the loop hunts, s."""


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
        Whether the drive has seemed to saturate for long.
    friction : float
        Friction beside which noise counts, N m.
    unforeseen : float
        Change of the plan that was not foreseen when the torque of the period was fed forward, rad/s.
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
    """Tell whether a torque is far larger than any with which the joint has moved, both less known torque, N m."""
    return abs(torque) > HELD * moved


@register_jitable
def runs_away(noise: NoiseState, error: float, peak: float) -> bool:
    """Tell whether an error (rad/s) is out of all proportion to the largest speed of the plan (rad/s)."""
    square = error * error
    return noise_known(noise) and square > AWAY * AWAY * peak * peak + BEYOND * BEYOND * noise.variance


@register_jitable
def astray(
    state: ObserverState, noise: NoiseState, error: float, sticks: bool, known: Circumstances, duration: float
) -> tuple[float, float]:
    """Return for how long the joint has stuck although its plan moves, and for how long it has run away, s.

    Parameters
    ----------
    state : ObserverState
        The state before the period.
    noise : NoiseState
        Noise of the measured velocity after it.
    error : float
        Error that the feedback sees, rad/s.
    sticks : bool
        Whether the joint sticks now.
    known : Circumstances
        What is known of the joint beside its motion.
    duration : float
        Length of the period, s.
    """
    stuck = state.stuck + duration if sticks else 0.0
    if known.strained and (sticks or state.stuck > CLAMPED):  # until the torque is a plausible one again
        stuck = CLAMPED + duration
    away = state.away + duration if runs_away(state.noise, error, known.peak) else max(0.0, state.away - duration)
    if hunts(noise, known.peak):
        away = max(away, GONE + CALM)
    return stuck, away


@register_jitable
def is_astray(stuck: float, away: float) -> bool:
    """Tell whether the observer is to be off for a joint that has stuck, or run away, for so long (s)."""
    return stuck > CLAMPED or away > GONE
