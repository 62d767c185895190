"""Trust in the friction that is fed forward: how much of it the joint turns out to have.

Where the model does not hold (bristles that bend, motion within the Stribeck regime, a curve far steeper than assumed),
the identified friction, fed forward in full, may leave more error than it takes away. What share of it would leave the
least? With ``x = G(f_ref)`` what the loop would make of all the friction that the model has for the plan (but for what
the integral held of it before, :mod:`adaptive_ff.adaptive.at_rest.wound_integral`), and ``ehat`` the error that is
predicted to be left with the share ``gamma`` that is fed, the error without any is

    y = ehat + gamma x

and the share that leaves the least error over the last seconds is the regression of ``y`` on ``x``,

    gamma_LS = (Sxy + rho Syy)/(Sxx + rho Syy)

drawn towards 1 by a prior. It is used to the extent that all of the friction would leave much:

    q = S(y - x)^2 / Syy,    gamma = 1 + sat((q - 1/4)/(1/4)) (gamma_LS - 1),    0 <= gamma <= 1

The predicted error is that of a linear loop. Where friction falls steeply with the velocity a joint hunts, and the
error that there is tells more: with ``m`` its square beyond what noise explains, times the misfit of the model (see
:mod:`adaptive_ff.adaptive.supervision.observer`), while the plan moves and no outer loop asks for more,

    gamma <= sat(2 - S(gamma m)/(0.16^2 Sxx))

Where what is fed leaves more than 0.16 of the error that all friction would make, the observer does better without it.
What speaks against the friction fades while little of it is fed, so that it is tried again.

It falls at once and rises slowly. ``ehat`` is the observer's, so what the observer takes away counts as left by the
model. Instruments of the identification keep the unscaled friction.

Before half a memory has been learnt, trust and observer are held back further on motion much slower than the gate of
the identification, ``0.2 Vs``: at most ``sat(4 peak |r| / (0.2 Vs) - 1)``, or at the start, when the motion is not
known yet, ``sat(1 - t/5 s)`` where that is more.

They are held back for good where the loop is soft for its friction, at most ``sat(16 peak |r| Kp/F - 0.6)``, or at the
start ``sat(1.5 - t/1 s)`` where that is more. An error of ``F/Kp`` is what the proportional gain needs to overcome the
friction ``F``. Where the plan is much slower than that, PI alone leaves the joint stuck for seconds, with an error of
no more than the plan; what breaks it away more often makes it slip, far faster than the plan. With a tenth of the
built-in inertia, gain and all, and a plan of 0.0125 rad/s (``peak Kp/F`` 0.02) it settles at 0.27 to 0.9 of PI alone
then on 16 references, and every one has a window that is worse.
"""

import math
from typing import NamedTuple

from numba.extending import register_jitable

from adaptive_ff.estimation.shares import saturated
from adaptive_ff.model.loop_response import LoopResponse, advance_loop_response, initial_loop_response
from controllers import PIParameters, delay_line, delayed, remember

MEMORY = 4.0
"""Memory of the sums, s."""

STANDING = 0.1
"""Rate at which they fade while the joint stands behind an outer loop, over that in motion.

As fast as in motion, all that is left after a rest of seconds is the last sample at which the plan has set out, and a
stiction that was learnt too large loses all trust: with a weight of twice the friction that is not told, moves between
rests of 4 to 20 s settle at 0.84 of PI alone then (velocity, six plans), with this at 1.2.
"""

PRIOR = 0.05
"""Weight ``rho`` of the prior, in mean squares of the error without friction feedforward."""

ENOUGH = 0.25
"""Share of the squared error that the whole friction may leave before it is distrusted; at twice that, fully."""

MISSED = 0.16
"""Error that there is, over the one that all of the friction would make, from which it is distrusted (rms values).

Of 214 joints of seed 101 whose friction falls by two gains or more, 56 have more without this rule, 50 of which a
disturbance observer without a model tracks better.
"""

RISE = 10.0
"""Time in which trust rises from 0 to 1, s."""

LEAST_ENERGY = 1e-12
"""Sums of this size, rad^2/s, come from a joint at rest: trust stays."""

PEAK_MEMORY = 100.0
"""Time of motion in which the largest speed of the plan fades, s; a bound that comes and goes is worse than either."""

SPAN, SLOWER = 10.0, 20.0
"""Unless over this time of motion, s, and up to twice that, the plan was so many times slower: then it is forgotten.

With it the built-in joint settles at 0.93 of PI or better on plans of 0.001 to 0.012 rad/s after a minute of 0.35
rad/s, without it at 0.68; joints, machines and cascades of seed 101 are the same to the bit.
"""

STEEPNESS = 4.0
"""Slope of the bound over the largest speed, in speeds of the sliding gate: none at a quarter of it, full at half."""

SOFT, SOFTEST = 16.0, 0.6
"""Slope of the bound over the largest speed, in speeds ``F/Kp``, and what it begins at: none at 0.0375, full at 0.1.

With full at 0.12 joints whose friction falls by 20 gains settle 10 % worse, with full at 0.08 three times as many of
them have a window that is worse than that of PI.
"""

SOFT_GRACE = 1.0
"""From half of this time after the start on, s, that is a reason to hold back; in full from one and a half on."""

GRACE = 5.0
"""Time after the start in which slow motion becomes a reason to hold back, s: it may begin slowly."""

LEARNT = 0.5
"""Time learnt, in memories of the estimator, from which slow motion is no reason to hold back."""


class TrustState(NamedTuple):
    """State of the trust.

    Attributes
    ----------
    trust : float
        Share ``gamma`` of the friction that is fed forward.
    response : LoopResponse
        What the loop makes of all the friction that the model has for the plan.
    frictions : tuple of float
        That friction, N m, the newest first, as far back as the drive may still apply it.
    xx, xy, yy : float
        Fading sums over the last seconds, rad^2/s.
    missed : float
        The same of the squared error that there is, by trust and misfit of the model.
    peak : float
        Largest speed of the plan of late, rad/s.
    earned : float
        Share that would be fed without :func:`caution` and :func:`soft_bound`; ``trust`` is the one in force.
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
    """Return largest speed of the plan of late, time in the present span, and largest speeds of this and the last one.

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
    """Return the state after a period.

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
        Error ``ehat`` that the loop would be left with, rad/s.
    missed : float
        Mean square ``m`` of the error that there is, as far as it tells of the model, rad^2/s^2.
    reference : float
        Planned velocity now, rad/s.
    valid : bool
        Whether the predicted error tells of the friction: not while a measurement is doubted, while not all is fed, or
        while a model that was trusted waits for the cause of a change.
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
    """Return the bound on trust that the error that there is sets, from the fading sums of :class:`TrustState`."""
    return saturated(2.0 - missed / (MISSED * MISSED * xx + LEAST_ENERGY))


@register_jitable
def caution(state: TrustState, slowest: float, learnt: float, memory: float, time: float) -> float:
    """Return the bound on trust and on the observer's gain while little has been learnt.

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
    """Return the bound on trust and on the observer's gain where the feedback is soft for the friction.

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
