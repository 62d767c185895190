"""Noise-gated disturbance observer: the torque that the feedforward lacks, fed back while it stands out of the noise.

**The observer.** The residual is what moved the joint beyond what was fed forward, less what the change of the error
took; a low-pass of it is the observed torque ``d``:

    res = u_act - u_fed - J_o ((w - w-) - (r - r-))/dt
    d(k) = d(k-1) + (1 - exp(-p dt)) (res - d(k-1))

with the fed torque behind the drive's delay, torque and reference behind the low-pass of the measured velocity. Fed
back with a gain ``g``, ``u = u_ff + g d + PI``, it is a disturbance observer around the feedforward (K. Ohnishi,
M. Shibata, T. Murakami, "Motion control for advanced mechatronics", IEEE/ASME Trans. Mechatronics 1, 1996). It answers
within ``1/p`` to what no identification can know yet: a start, a jump of friction, a load, a bristle that bends.

**Its inertia** ``J_o`` and **its gain** ``g`` are those of :mod:`adaptive_ff.adaptive.supervision.observer_gates`.

**Its pole** is at most ``Kp/J``: a faster observer destabilises joints with an elastic gear or backlash, which the
gains of the PI loop respect and the observer would not. By default it is at most 65 rad/s, since a fast loop has no
margin to spare.
"""

import math
from typing import NamedTuple

from numba.extending import register_jitable

from adaptive_ff.adaptive.learning.lag_tuning import lag_torque
from adaptive_ff.adaptive.supervision.circumstances import Circumstances, astray, is_astray
from adaptive_ff.adaptive.supervision.colour import advance_colour, is_coloured, mean_length
from adaptive_ff.adaptive.supervision.noise_level import (
    RISE,
    NoiseState,
    advance_noise,
    likely_variance,
    noise_known,
    sure_variance,
)
from adaptive_ff.adaptive.supervision.observer_effect import (
    ObserverEffect,
    advance_effect,
    demand_help,
    follow_half_cycles,
    restrain_ringing,
)
from adaptive_ff.adaptive.supervision.observer_gates import AT_ONCE, WINDOW, short_mean, tells_at_once
from adaptive_ff.adaptive.supervision.observer_state import ObserverParameters, ObserverState
from adaptive_ff.adaptive.supervision.ringing import beside_correction, far_error, loudest
from adaptive_ff.adaptive.supervision.swift_ringing import Background, pace
from adaptive_ff.model.loop_response import advance_loop_response
from controllers import PIParameters

STUCK = 0.2
"""Velocity along the plan, over the plan, below which a joint sticks or has not turned yet ..."""

CLEAR = 9.0
"""... if the square of its error also exceeds this many variances of the noise (any error before that is known)."""


@register_jitable
def plan_as_measured(lag: float, seen: float, plan: float, duration: float) -> float:
    """Return the plan (rad/s) as a velocity with a lag (s) shows it after a period (s); ``seen`` is the last value."""
    return seen + (plan - seen) * duration / (duration + lag)


@register_jitable
def shown_share(lag: float, duration: float) -> float:
    """Return the share of a change that a velocity with a lag (s) shows after a period (s)."""
    return duration / (duration + lag)


@register_jitable
def bridged_torque(mean: float, torque: float, gap: float, duration: float) -> float:
    """Return the mean torque (N m) since a velocity was believed.

    Parameters
    ----------
    mean : float
        The mean before the period that has ended, N m; zero where that is the first one.
    torque : float
        Torque in that period, N m.
    gap : float
        Time since then, with that period, s.
    duration : float
        Length of that period, s.
    """
    return mean + (torque - mean) * (duration / gap)


class Answer(NamedTuple):
    """How the joint has answered over a period, by which the effect of the observer is judged.

    Attributes
    ----------
    error, predicted, correction : float
        Error that the feedback sees, error ``ehat``, and what an outer loop asks for, rad/s.
    observed : float
        Mean square of what is observed, N^2 m^2.
    coloured : bool
        Whether the noise of the measured velocity is coloured.
    stands : bool
        Whether the joint stands although its plan moves: it does not answer as predicted then.
    turned : bool
        Whether the plan has changed its sign.
    """

    error: float
    predicted: float
    correction: float
    observed: float
    coloured: bool
    stands: bool
    turned: bool


@register_jitable
def effect_after(
    state: ObserverState,
    observer: ObserverParameters,
    feedback: PIParameters,
    noise: NoiseState,
    answer: Answer,
    known: Circumstances,
    duration: float,
) -> ObserverEffect:
    """Return the effect of the observer after a period (s); it is as before while the observed torque is held."""
    effect, gain = state.effect, state.gain
    if known.held:
        return effect
    error, predicted, correction = answer.error, answer.predicted, answer.correction
    variance, time_constant = likely_variance(noise), observer.inertia / feedback.proportional
    if not answer.stands:
        if noise_known(noise):
            effect = advance_effect(
                effect, error, predicted, correction, noise.variance, known.peak, gain, known.believed, duration
            )
        effect = demand_help(effect, error, predicted, correction, variance, gain, answer.coloured, duration)
    own = beside_correction(error, correction)
    load = 0.0 if known.saturates else math.sqrt(answer.observed)  # then it may be torque that never acted
    far = far_error(max(known.friction, load), feedback.proportional, correction)
    loud = loudest(known.peak, far) if known.saturates else known.peak
    beside = Background(sure_variance(noise), answer.coloured, known.friction / feedback.proportional)
    effect = follow_half_cycles(effect, own, variance, beside, far, answer.turned, time_constant, duration)
    return restrain_ringing(effect, variance, beside, loud, gain, known.falls)


class Residual(NamedTuple):
    """Torque that the feedforward has left over a period, and the low-passes behind which it is compared.

    Attributes
    ----------
    torque : float
        The residual ``res``, N m.
    seen : float
        Plan as the measured velocity would show it, rad/s.
    lagged_torque : float
        Torque beyond what was fed forward, behind the low-pass of the measured velocity, N m.
    unforeseen : float
        Change of the plan that was not foreseen, behind that low-pass, rad/s.
    """

    torque: float
    seen: float
    lagged_torque: float
    unforeseen: float


@register_jitable
def residual_over(
    observer: ObserverParameters,
    state: ObserverState,
    lacking: float,
    inertia: float,
    reference: float,
    velocity: float,
    duration: float,
    known: Circumstances,
) -> Residual:
    """Return the residual over a period; parameters as of :func:`observe`."""
    seen, lagged_torque = reference, state.lagged_torque
    if observer.velocity_lag > 0.0:
        seen = plan_as_measured(observer.velocity_lag, state.reference, reference, duration)
        lacking, lagged_torque = lag_torque(observer.velocity_lag, lagged_torque, lacking, duration)
    # of a change that was not foreseen no inertia torque was fed
    unforeseen = state.unforeseen + shown_share(observer.velocity_lag, duration) * (known.unforeseen - state.unforeseen)
    change = (velocity - state.velocity) - (seen - state.reference - unforeseen)
    return Residual(lacking - inertia * change / duration, seen, lagged_torque, unforeseen)


@register_jitable
def observe(
    observer: ObserverParameters,
    state: ObserverState,
    feedback: PIParameters,
    lacking: float,
    inertia: float,
    reference: float,
    correction: float,
    velocity: float,
    duration: float,
    known: Circumstances,
) -> ObserverState:
    """Return the state after a period, or several that were bridged, before the gates are set.

    - While the plan rests, or friction of the last direction is held, the observed torque is held. A stuck joint
      answers to no torque: an observer would take what the feedback asks for as a disturbance, feed it back and wind
      up, until the joint jumps, again and again.
    - Where the joint sticks although the plan moves, the observed torque may grow along the error, which frees the
      joint, but not against it: there the integral would drive it, with what it holds from before.
    - Where a brake holds the joint, where it has run away or hunts
      (:mod:`adaptive_ff.adaptive.supervision.circumstances`), the observed torque fades with the observer's pole.

    Parameters
    ----------
    observer : ObserverParameters
        The observer.
    state : ObserverState
        The state.
    feedback : PIParameters
        The PI loop.
    lacking : float
        Torque that the drive gave over the period beyond what was fed forward, N m.
    inertia : float
        Inertia ``J_o``, kg m^2.
    reference, correction, velocity : float
        Plan, what an outer loop adds to it for the feedback, and measured velocity, now, rad/s.
    duration : float
        Length of the period, s; with what was bridged before.
    known : Circumstances
        What is known of the joint beside that.
    """
    residual = residual_over(observer, state, lacking, inertia, reference, velocity, duration, known)
    seen, left = residual.seen, residual.torque
    now = seen + correction - velocity
    sticks = velocity * seen < STUCK * seen * seen and now * now > CLEAR * state.noise.variance
    pole = observer.standing_pole if sticks and not known.learnt else observer.pole
    share = -math.expm1(-pole * pace(state.effect.swift) * duration)
    if known.held or (sticks and (left - state.disturbance) * now < 0.0):
        share = 0.0
    disturbance = state.disturbance + share * (left - state.disturbance)
    tells = reference != 0.0 and velocity != state.velocity  # a joint at rest, or a value repeated, shows no noise
    noise = advance_noise(state.noise, seen - velocity, tells, duration)
    length = mean_length(observer.pole, observer.period)
    colour = advance_colour(state.colour, seen - velocity, tells, length, duration)
    stuck, away = astray(state, noise, now, sticks, known, duration)
    if is_astray(stuck, away):
        disturbance = state.disturbance * math.exp(-observer.pole * duration)
    # the residual is behind the low-pass of the velocity already
    response = advance_loop_response(state.response, feedback, observer.inertia, 0.0, left, duration)
    weight = 0.0 if known.held else duration / (WINDOW + duration)
    coloured = is_coloured(colour, noise, length, feedback.proportional, known.friction)
    one_way = state.one_way + duration if seen * state.reference > 0.0 else 0.0
    at_once = AT_ONCE if tells_at_once(disturbance, one_way, coloured, known) else 0.0
    squared = short_mean(state.squared, disturbance * disturbance, weight, at_once)
    predicted = short_mean(state.predicted_squared, response.velocity * response.velocity, weight, 0.0)
    answer = Answer(
        error=now,
        predicted=response.velocity,
        correction=correction,
        observed=squared,
        coloured=coloured,
        stands=sticks and abs(velocity) < STUCK * abs(seen),
        turned=seen * state.reference < 0.0,
    )
    error = state.error + share * (now - state.error)
    quiet = min(predicted, state.quiet * (1.0 + duration / RISE)) if noise_known(state.noise) else predicted
    return ObserverState(
        disturbance=disturbance,
        gain=state.gain,
        velocity=velocity,
        reference=seen,
        lagged_torque=residual.lagged_torque,
        fed=state.fed,
        squared=squared,
        response=response,
        predicted_squared=predicted,
        noise=noise,
        error=error,
        error_squared=short_mean(state.error_squared, error * error, weight, at_once),
        quiet=quiet,
        stuck=stuck,
        away=away,
        let_go=state.let_go or is_astray(stuck, away),
        effect=effect_after(state, observer, feedback, noise, answer, known, duration),
        colour=colour,
        unforeseen=residual.unforeseen,
        one_way=one_way,
    )
