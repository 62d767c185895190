"""Feedforward: the columns along the coming reference, times their coefficients; and friction at standstill.

Three facts of friction that the loop's response does not know are here: it turns a little late; at standstill it is
what is bent, and what the joint was shown to hold; and on a reference that is slow for the loop, what breaks a joint
away makes it slip.
"""

import math
from typing import NamedTuple

from adaptive_ff.adaptive.learn import distance_apart, speed_level
from adaptive_ff.adaptive.state import AdaptiveParameters, AdaptiveState
from adaptive_ff.friction.columns import (
    COULOMB,
    INERTIA,
    LAGS,
    PATHS,
    STICTION,
    VISCOUS,
    Curve,
    FrictionState,
    hold,
    is_friction,
    write_columns,
)
from adaptive_ff.learning.kalman import LOOP
from adaptive_ff.learning.response import put_in
from controllers import Inputs


class Fed(NamedTuple):
    """What is fed forward over the coming period.

    Attributes
    ----------
    friction : FrictionState
        Memory of the columns.
    torque, change : float
        Torque of the estimates, and what of it a change of estimates has brought, N m.
    kept : float
        Friction that is not fed, N m.
    known : float
        Torque known from elsewhere, N m.
    steady : float
        Torque that the integral holds in the mean, N m.
    held, sliding : float
        Friction that stays at standstill, bent over paths or held there, and all friction along the reference, N m.
    standing : float
        What is fed of friction that is newly held at standstill, N m.
    largest : float
        Largest friction at low speed, N m.
    """

    friction: FrictionState
    torque: float
    change: float
    kept: float
    known: float
    steady: float
    held: float
    sliding: float
    standing: float
    largest: float


def at_standstill(
    parameters: AdaptiveParameters, state: AdaptiveState, inputs: Inputs, static: float, rests: bool
) -> tuple[FrictionState, float, float, float]:
    """Return the memory of the columns, what the integral holds in the mean, and friction held before and now, N m.

    Friction that is bent over a path stays where the reference comes to rest; what slid stays as far as the rest was
    not foreseen, and fades else. What the integral winds up from then on, beyond its mean, is friction of the joint
    that stands as well, up to the static friction.
    """
    pi, integral, steady = parameters.feedback, state.feedback.integral, state.steady
    if not rests:
        weight = min(1.0, inputs.dt * pi.integral / pi.proportional)
        return state.friction, steady + weight * (integral - steady), 0.0, 0.0
    if static <= 0.0:
        return state.friction, steady, state.held, 0.0
    before = state.held
    if state.rested == 0.0:
        apart = 2.0 * distance_apart(0.0, state.foreseen, speed_level(parameters, state, parameters.tuning.standing))
        before += apart * (state.sliding - before)
        for i in range(LAGS):
            state.friction.lagged[i] *= 1.0 - apart
    held = min(max(before + integral - steady, -static), static)
    return hold(state.friction, held / static), steady, before, held


def feed_in_place(
    parameters: AdaptiveParameters, state: AdaptiveState, inputs: Inputs, start: float, end: float, position: float
) -> Fed:
    """Write the columns of the coming period, put them into the response, and return what is fed.

    Parameters
    ----------
    parameters, state, inputs : AdaptiveParameters, AdaptiveState, Inputs
        The controller and its inputs.
    start, end : float
        Reference over the period in which the torque acts, rad/s.
    position : float
        Position in the middle of it, rad; not a number where it is not known.
    """
    machine, mean, psi = parameters.machine, state.estimate.mean, state.psi
    paths, last = 0.0, mean.size - 1
    for i in range(state.friction.bent.size):
        paths += mean[LOOP + PATHS + i]
    coulomb, stiction = mean[LOOP + COULOMB], mean[LOOP + STICTION]
    largest = max(coulomb, stiction) + paths
    rests = inputs.reference == 0.0 and start == 0.0 and end == 0.0
    friction, steady, before, held = at_standstill(parameters, state, inputs, stiction + paths, rests)
    late = parameters.tuning.hold * largest * parameters.period / machine.inertia
    curve = Curve(math.exp(mean[last - 1]), math.exp(mean[last]), coulomb, stiction, mean[LOOP + VISCOUS], late)
    friction = write_columns(
        parameters.hypothesis,
        friction,
        curve,
        start,
        end,
        parameters.period,
        position,
        inputs.feedforward,
        state.regressors,
        psi,
    )
    if math.isfinite(inputs.inertia):
        psi[INERTIA] *= inputs.inertia / machine.inertia
    known, torque, change, kept, sliding = inputs.feedforward, 0.0, 0.0, 0.0, 0.0
    if machine.includes_inertia:
        known -= machine.inertia * psi[INERTIA]
    for i in range(psi.size - 2):
        fed = machine.friction_share if is_friction(parameters.hypothesis, i) else 1.0
        torque += fed * psi[i] * mean[LOOP + i]
        change += fed * psi[i] * (mean[LOOP + i] - state.given[i])
        kept += (1.0 - fed) * psi[i] * mean[LOOP + i]
        state.given[i] = mean[LOOP + i]
        if COULOMB <= i < PATHS + state.friction.bent.size:
            sliding += psi[i] * mean[LOOP + i]
        if not rests and PATHS <= i < PATHS + state.friction.bent.size:
            held += psi[i] * mean[LOOP + i]
    standing = machine.friction_share * (held - before) if rests else 0.0
    for i in range(psi.size):
        put_in(state.response, i, psi[i])
    return Fed(friction, torque, change, kept, known, steady, held, sliding, standing, largest)


def next_gain(
    parameters: AdaptiveParameters, state: AdaptiveState, peak: float, largest: float, duration: float
) -> float:
    """Return the gain of what is fed: it fades to one, to zero, or to less where the reference is slow for the loop.

    Parameters
    ----------
    parameters, state : AdaptiveParameters, AdaptiveState
        The controller.
    peak : float
        Peak of the reference, rad/s.
    largest : float
        Largest friction at low speed, N m.
    duration : float
        Time, s.
    """
    tuning, step = parameters.tuning, duration / parameters.tuning.fade
    allowed = 1.0 if state.feedforward_enabled else 0.0
    if largest > 0.0 and peak > 0.0:
        speed = tuning.slow * largest
        allowed = min(allowed, max(0.0, peak * parameters.feedback.proportional / speed - 1.0))
    return min(state.fed_gain + step, allowed) if allowed > state.fed_gain else max(state.fed_gain - step, allowed)
