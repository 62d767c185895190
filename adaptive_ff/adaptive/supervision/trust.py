"""Trust ``gamma``: which share of the identified friction is fed forward.

Where the model does not hold (bristles that bend, motion within the Stribeck regime, a curve far steeper than assumed),
the identified friction, fed forward in full, may leave more error than it takes away. So ``gamma`` is the least of five
bounds. All of them fall at once; what the first two allow rises by at most 1 in 10 s. Instruments of the identification
keep the unscaled friction.

**1. The share that leaves the least error.** Let ``ehat`` be the error that is predicted to be left while the share
``gamma`` is fed, and ``x = G(f_ref)`` what the loop would make of all the friction that the model has for the plan,
except what the integral held of it before (:mod:`adaptive_ff.adaptive.at_rest.wound_integral`). The error without any
friction feedforward is then ``y``, and a regression of ``y`` on ``x`` gives the share that would have left the least
error over the last seconds, drawn towards 1 by a prior of weight ``rho``:

    y = ehat + gamma x,    gamma_LS = (Sxy + rho Syy)/(Sxx + rho Syy)

It is used as far as all of the friction would leave much, more than a quarter of the squared error ``Syy``:

    q = S(y - x)^2 / Syy,    gamma <= 1 + sat((q - 1/4)/(1/4)) (gamma_LS - 1),    0 <= gamma <= 1

``S`` is a sum that fades over 4 s. ``ehat`` is that of the observer, so what the observer takes away counts as left by
the model.

**2. The actual error.** ``ehat`` is that of a linear loop. Where friction falls steeply with the velocity a joint
hunts, and the actual error is more than predicted:

    gamma <= sat(2 - S(gamma m)/(0.16^2 Sxx))

with ``m`` the mean square of the actual error beyond what noise explains, times the misfit of the model
(:mod:`adaptive_ff.adaptive.supervision.observer_gates`). It is summed while the plan moves and no outer loop asks for a
correction, once a memory of the estimator has been learnt. Where the friction that is fed leaves more than 0.16 of the
error that all friction would make, the observer does better without it. The sum fades while little friction is fed, so
that more of it is tried again.

**3. Slow motion** (:func:`caution`). Before half a memory has been learnt, trust and observer are held back on motion
much slower than the gate of the identification, ``0.2 Vs``:

    gamma <= max(sat(4 peak|r| / (0.2 Vs) - 1), sat(1 - t/5 s))

with the time ``t`` since the first sample: at the start the motion is not known yet.

**4. A loop that is soft for its friction** (:func:`soft_bound`) holds both back for good:

    gamma <= max(sat(16 peak|r| Kp/F - 0.6), sat(1.5 - t/1 s))

The proportional gain needs an error of ``F/Kp`` to overcome the friction ``F`` at breakaway. Where the plan is much
slower than that, PI alone leaves the joint stuck for seconds, with an error of no more than the plan. Whatever breaks
it away more often makes it slip, far faster than the plan. Without this bound a joint with a tenth of the built-in
inertia and gains, on a plan of 0.0125 rad/s (``peak|r| Kp/F`` is 0.02), settles at 0.27 to 0.9 of PI's accuracy on 16
references, and every one has a window that is worse than PI's.

**5. A drive that does not seem to give its torque, or a sensor of few counts**
(:mod:`adaptive_ff.adaptive.faults.drive_limit`, :mod:`adaptive_ff.adaptive.supervision.balance`).
"""

import math
from typing import NamedTuple

from numba.extending import register_jitable

from adaptive_ff.estimation.shares import saturated
from adaptive_ff.model.loop_response import LoopResponse, advance_loop_response, initial_loop_response
from controllers import PIParameters, delay_line, delayed, remember

MEMORY = 4.0
"""Time over which the sums fade, s."""

STANDING = 0.1
"""Rate at which they fade while the joint stands behind an outer loop, over that in motion.

If they faded as fast as in motion, all that is left after a rest of seconds would be the last sample, at which the plan
sets out, and a stiction that was learnt too large would lose all trust. With an unmodelled weight of twice the
friction, moves between rests of 4 to 20 s settle at 1.2 of PI's accuracy, without this at 0.84 (velocity, six plans).
"""

PRIOR = 0.05
"""Weight ``rho`` of the prior, in mean squares of the error without friction feedforward."""

ENOUGH = 0.25
"""Share of the squared error that all of the friction may leave before ``gamma_LS`` counts; at twice that, in full."""

MISSED = 0.16
"""Actual error over the one that all of the friction would make, from which less friction is fed (rms values).

Of 214 joints of seed 101 whose friction falls by two gains or more, 56 have more than this without the rule. A
disturbance observer without a model tracks 50 of these better.
"""

RISE = 10.0
"""Time in which trust rises from 0 to 1, s."""

LEAST_ENERGY = 1e-12
"""Sums of this size, rad^2/s, come from a joint at rest, and leave trust as it is."""

PEAK_MEMORY = 100.0
"""Time of motion over which ``peak|r|`` fades, s: long, since a bound that comes and goes is worse than either."""

SPAN, SLOWER = 10.0, 20.0
"""Time of motion, s, and ratio of speeds: if the plan is more than so many times slower than ``peak|r|`` for once to
twice that time, the faster speed before is forgotten.

With this the built-in joint settles at 0.93 of PI's accuracy or better on plans of 0.001 to 0.012 rad/s after a minute
at 0.35 rad/s, without it at 0.68. Joints, machines and cascades of seed 101 are the same to the bit.
"""

STEEPNESS = 4.0
"""Slope of bound 3 over the largest speed, in speeds of the sliding gate: 0 at a quarter of that speed, 1 at half."""

SOFT, SOFTEST = 16.0, 0.6
"""Slope of bound 4 over the largest speed, in speeds ``F/Kp``, and what is subtracted: 0 at 0.0375, 1 at 0.1.

If the bound reached 1 at 0.12, joints whose friction falls by 20 gains would settle 10 % worse. If it did at 0.08,
three times as many of them would have a window that is worse than PI's.
"""

SOFT_GRACE = 1.0
"""Bound 4 begins to act half of this time after the start, s, and acts in full from one and a half times it on."""

GRACE = 5.0
"""Time after the start over which bound 3 comes into force, s: a motion may begin slowly."""

LEARNT = 0.5
"""Time learnt, in memories of the estimator, from which on bound 3 does not act."""


class TrustState(NamedTuple):
    """State of the trust.

    Attributes
    ----------
    trust : float
        Share ``gamma`` of the friction that is fed forward.
    response : LoopResponse
        Response ``x`` of the loop to all the friction that the model has for the plan.
    frictions : tuple of float
        All the friction that the model has for the plan, N m, the newest first, as far back as the drive's delay.
    xx, xy, yy : float
        Fading sums ``Sxx``, ``Sxy``, ``Syy``, rad^2/s.
    missed : float
        Fading sum ``S(gamma m)``, rad^2/s.
    peak : float
        Largest speed of the plan of late, rad/s.
    earned : float
        Share that bounds 1 and 2 allow; ``trust`` is the one in force.
    span : float
        Time of motion in the present span, s.
    fastest, before : float
        Largest speeds of the plan in this span and in the one before, rad/s.
    """

    trust: float
    response: LoopResponse
    frictions: tuple[float, ...]
    xx: float
    xy: float
    yy: float
    missed: float
    peak: float
    earned: float
    span: float
    fastest: float
    before: float


def initial_trust(feedback: PIParameters) -> TrustState:
    """Return full trust."""
    line = delay_line(feedback.delay)
    return TrustState(
        trust=1.0,
        response=initial_loop_response(feedback),
        frictions=line,
        xx=0.0,
        xy=0.0,
        yy=0.0,
        missed=0.0,
        peak=0.0,
        earned=1.0,
        span=0.0,
        fastest=0.0,
        before=0.0,
    )


@register_jitable
def plan_speeds(state: TrustState, reference: float, duration: float) -> tuple[float, float, float, float]:
    """Return ``peak|r|``, the time in the present span, and the largest speeds in this span and in the one before.

    Parameters
    ----------
    state : TrustState
        The state before the period.
    reference : float
        Planned velocity now, rad/s.
    duration : float
        Length of the period, s.
    """
    moved = duration if reference != 0.0 else 0.0
    peak = max(abs(reference), state.peak * math.exp(-moved / PEAK_MEMORY))
    span, fastest, before = state.span + moved, max(abs(reference), state.fastest), state.before
    if span > SPAN:
        span, fastest, before = 0.0, abs(reference), fastest
    if max(fastest, before) < peak / SLOWER:
        peak = max(fastest, before)
    return peak, span, fastest, before


@register_jitable
def advance_trust(
    state: TrustState,
    feedback: PIParameters,
    inertia: float,
    velocity_lag: float,
    from_integral: float,
    predicted: float,
    missed: float,
    reference: float,
    valid: bool,
    stands: bool,
    duration: float,
) -> TrustState:
    """Return the state after a period, with the share that bounds 1 and 2 allow.

    Parameters
    ----------
    state : TrustState
        The state.
    feedback : PIParameters
        The PI loop.
    inertia : float
        Inertia that it was designed for, kg m^2.
    velocity_lag : float
        Time by which the measured velocity lags, s.
    from_integral : float
        Friction that is fed and was in the integral before, N m; see
        :mod:`adaptive_ff.adaptive.at_rest.wound_integral`.
    predicted : float
        Error ``ehat`` that is predicted to be left, rad/s.
    missed : float
        Mean square ``m`` of the actual error beyond noise, times the misfit of the model, rad^2/s^2.
    reference : float
        Planned velocity now, rad/s.
    valid : bool
        Whether the predicted error shows the effect of the friction: not while a measurement is doubted, while the
        feedforward is faded, or while a model that was trusted waits for the cause of a change.
    stands : bool
        Whether the joint stands behind an outer loop.
    duration : float
        Length of the period, s.
    """
    friction = delayed(state.frictions, feedback.delay) - from_integral
    response = advance_loop_response(state.response, feedback, inertia, velocity_lag, friction, duration)
    peak, span, fastest, before = plan_speeds(state, reference, duration)
    if not valid:
        return state._replace(
            trust=state.earned, response=response, peak=peak, span=span, fastest=fastest, before=before
        )
    x = response.measured
    y = predicted + state.trust * x
    keep = math.exp(-duration / MEMORY * (STANDING if stands else 1.0))
    xx, xy = keep * state.xx + duration * x * x, keep * state.xy + duration * x * y
    yy, against = keep * state.yy + duration * y * y, keep * state.missed
    if reference != 0.0:
        against += duration * state.trust * missed
    prior = PRIOR * yy + LEAST_ENERGY
    best = (xy + prior) / (xx + prior)
    left = (yy - 2.0 * xy + xx) / (yy + LEAST_ENERGY)
    trust = saturated(1.0 + saturated((left - ENOUGH) / ENOUGH) * (best - 1.0))
    trust = min(trust, trust_by_error(against, xx))
    trust = min(trust, state.earned + duration / RISE)
    return TrustState(
        trust=trust,
        response=response,
        frictions=state.frictions,
        xx=xx,
        xy=xy,
        yy=yy,
        missed=against,
        peak=peak,
        earned=trust,
        span=span,
        fastest=fastest,
        before=before,
    )


@register_jitable
def trust_by_error(missed: float, xx: float) -> float:
    """Return bound 2, of the actual error, from the fading sums of :class:`TrustState`."""
    return saturated(2.0 - missed / (MISSED * MISSED * xx + LEAST_ENERGY))


@register_jitable
def caution(state: TrustState, slowest: float, learnt: float, memory: float, time: float) -> float:
    """Return bound 3, on trust and on the observer's gain, of slow motion while little has been learnt.

    Parameters
    ----------
    state : TrustState
        The state.
    slowest : float
        Speed of the sliding gate, rad/s.
    learnt, memory : float
        Time for which the estimator has learnt, and its memory, s.
    time : float
        Time since the first sample, s.
    """
    if learnt >= LEARNT * memory:
        return 1.0
    return max(saturated(STEEPNESS * state.peak / slowest - 1.0), saturated(1.0 - time / GRACE))


@register_jitable
def soft_bound(state: TrustState, proportional: float, friction: float, time: float) -> float:
    """Return bound 4, on trust and on the observer's gain, of feedback that is soft for the friction.

    Parameters
    ----------
    state : TrustState
        The state.
    proportional : float
        Proportional gain, N m s/rad.
    friction : float
        Friction at breakaway as it is identified, N m.
    time : float
        Time since the first sample, s.
    """
    reached = state.peak * proportional
    if SOFT * reached >= (1.0 + SOFTEST) * friction:
        return 1.0
    return max(saturated(SOFT * reached / friction - SOFTEST), saturated(1.5 - time / SOFT_GRACE))


@register_jitable
def with_friction(state: TrustState, trust: float, friction: float) -> TrustState:
    """Return the state with the trust in force over the coming period and the model's friction (N m) for it."""
    return state._replace(trust=trust, frictions=remember(state.frictions, friction))
