"""Friction guessed before there is anything to learn, so that the first reversals have some."""

import math

from numba.extending import register_jitable

from adaptive_ff.adaptive.learning.estimator import PEAK_FACTOR, SPEED_FACTOR
from adaptive_ff.adaptive.learning.estimator_state import EstimatorState, Levels, with_levels
from adaptive_ff.adaptive.learning.prediction import add_loads
from adaptive_ff.friction.bounds import COULOMB, INERTIA, STICTION
from adaptive_ff.learning.torque_form import FILTER_TORQUE, FILTER_VELOCITY, Signals
from adaptive_ff.regression.known_loads import write_loads

GUESS = 0.9
"""Share of the largest friction torque seen that Coulomb friction and stiction are guessed to be."""

STILL = 0.1
"""Speed, as a share of the largest of the reference, below which joint or reference stand nearly still."""

CLAMPED = 1.0
"""Time without following, s, from which the joint is taken for clamped."""


@register_jitable
def time_stuck(levels: Levels, speed: float, measured: Signals, model: Signals, duration: float) -> float:
    """Return for how long the joint has not followed its reference, s; while that is slow itself, nothing is known.

    Parameters
    ----------
    levels : Levels
        Levels so far.
    speed : float
        Largest filtered reference speed, rad/s.
    measured, model : Signals
        Filters over the measurements and over the reference.
    duration : float
        Time since the last sample, s.
    """
    if abs(measured.filters[FILTER_VELOCITY, 0]) >= STILL * speed:
        return 0.0
    if abs(model.filters[FILTER_VELOCITY, 0]) < STILL * speed:
        return levels.stuck
    return levels.stuck + duration


@register_jitable
def guess_friction_in_place(
    state: EstimatorState,
    measured: Signals,
    model: Signals,
    duration: float,
    ratio: float = 1.0,
) -> EstimatorState:
    """Guess Coulomb friction and stiction from the largest friction torque so far, before there is anything to learn.

    Whether the joint sticks or slides, the torque that does not accelerate it is friction; at rest it is less than the
    stiction. So the guess is on the safe side, and better than none at the first reversals. A joint that does not
    follow its reference for long may be clamped by a brake: then the guess rises no further.

    Returns
    -------
    EstimatorState
        The new state; it shares the arrays of the old one, of which the estimate is changed in place.
    """
    estimate, levels = state.recursion.estimate, state.levels
    speed = max(levels.speed, abs(model.filters[FILTER_VELOCITY, 0]))
    if not abs(measured.filters[FILTER_VELOCITY, 0]) < SPEED_FACTOR * speed:
        return with_levels(state, levels._replace(speed=speed), state.surprise, state.alarm)
    torque = measured.filters[FILTER_TORQUE, 0]
    largest = max(levels.torque, abs(torque))
    friction = torque - estimate[INERTIA] * ratio * measured.filters[FILTER_VELOCITY, 1]
    write_loads(state.loads, state.scratch.row)
    friction -= add_loads(0.0, estimate, state.scratch.row)
    guess = min(GUESS * math.copysign(friction, friction * model.velocity), PEAK_FACTOR * largest)
    stuck = time_stuck(levels, speed, measured, model, duration)
    if guess > estimate[COULOMB] and stuck <= CLAMPED:
        estimate[COULOMB] = guess
        estimate[STICTION] = guess
    new = levels._replace(torque=largest, speed=speed, stuck=stuck)
    return with_levels(state, new, state.surprise, state.alarm)
