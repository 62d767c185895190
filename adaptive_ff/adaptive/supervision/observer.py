"""Noise-gated disturbance observer: the torque that the feedforward lacks, fed back while it stands out of the noise.

**The observer.** The residual is what moved the joint beyond what was fed forward, less what the change of the error
took; a low-pass of it is the observed torque ``d``:

    res = u_act - u_fed - J_o ((w - w-) - (r - r-))/dt
    d(k) = d(k-1) + (1 - exp(-p dt)) (res - d(k-1))

with the fed torque behind the drive's delay, torque and reference behind the low-pass of the measured velocity. Fed
back with a gain ``g``, ``u = u_ff + g d + PI``, it is a disturbance observer around the feedforward (K. Ohnishi,
M. Shibata, T. Murakami, "Motion control for advanced mechatronics", IEEE/ASME Trans. Mechatronics 1, 1996). It answers
within ``1/p`` to what no identification can know yet: a start, a jump of friction, a load, a bristle that bends.

**Its inertia** ``J_o`` is the one ``J_n`` that the feedback was designed for, or the identified one ``J`` where that is
smaller and the model fits. How badly the model fits is ``q``, from the mean squared torque ``<eps^2>`` (N^2 m^2) that
it leaves:

    J_o = J + q (J_n - J),    q = sat(<eps^2> / (4 (Kp s)^2) - 1)

- With half the load and the old inertia the observer would oscillate.
- But a Stribeck curve that falls steeply looks like a smaller inertia than there is. With that one the observer feeds
  back what accelerates the joint, which hunts.
- Where an inertia is given for the present configuration, ``J_o`` is in proportion to it. With that of the design, a
  joint of six times as much oscillates behind a position loop, where PI alone does not.

**Its gain.** Where the feedforward leaves nothing, an observer feeds back noise. So ``g = min(g_d, max(g_r, g_e))``,
gates that are open while the noise is not known:

    g_d = sat(<d^2> / (4 * 2 s_d^2) - 1),   s_d^2 = a^2 2/(2 - a) (J s/T)^2,  a = 1 - exp(-p T)   (d against its noise)
    g_r = sat(<ehat^2> / (4 s_T^2) - 1),    s_T^2 = s^2 2 b/(2 - b),          b = Kp T/J          (error to come)
    g_e = sat(<e_f^2> / (4 s_e^2) - 1),     s_e^2 = s^2 a/(2 - a)                                 (error that there is)

- ``s`` is the standard deviation of the noise of the measured velocity, ``ehat = G(res)`` the error that the loop would
  make of the residual, ``e_f`` the error behind a low-pass with the observer's pole, which is held where ``d`` is. The
  two errors differ while the estimates move, since what a new estimate feeds is taken out of the integral.
- ``<.>`` is a mean over 0.3 s. Those of ``d`` and ``e_f`` are at once no less than a quarter of the present square
  where ``d`` is a sudden change (:func:`tells_at_once`).
- A velocity out of a filter has noise of another colour, and ``s_T`` is too small for it: in a fast loop behind a
  Kalman filter its square is a fifth of what the noise makes. So its square is raised to the slowly rising minimum of
  ``<ehat^2>``, at most to 2.5 times, and as far as the model fits, ``1 - q``. Where the model does not fit, the least
  of the error is not noise.
- Neither time nor age enters: the gate is open while there is something to gain.

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
    steadily_oscillates,
)
from adaptive_ff.adaptive.supervision.observer_state import ObserverParameters, ObserverState
from adaptive_ff.adaptive.supervision.ringing import beside_correction, far_error, loudest
from adaptive_ff.adaptive.supervision.swift_ringing import Background, pace
from adaptive_ff.estimation.shares import ROUNDING, TINY, saturated
from adaptive_ff.model.loop_response import advance_loop_response
from controllers import PIParameters

WINDOW = 0.3
"""Length of the short means, s."""

LOUDER = 4.0
"""Mean square over what noise explains of it, from which on a gate begins to open; at twice that it is open."""

STUCK = 0.2
"""Velocity along the plan, over the plan, below which a joint sticks or has not turned yet ..."""

CLEAR = 9.0
"""... if the square of its error also exceeds this many variances of the noise (any error before that is known)."""

OBSERVED_NOISE = 2.0
"""Factor on the variance that noise gives the observed torque: two measurements make a difference."""

COLOURED = 2.5
"""Largest factor on the noise level of the error to come: velocities come out of filters."""

EXPLAINED = 2.0
"""Mean squared error that is taken for noise, over what noise explains of it."""


MUCH, AT_ONCE = 0.3, 0.25
"""Observed torque over the friction, from which on the observer is used even where it does not help; and share of a
present square that counts beside a short mean.

Of 112 joints behind Kalman filters 15 to 18 have a window above 1.2 times PI's error, whatever threshold of noise is
set beside these two. With 0 as the first (and such a threshold) it is 39, with 1 as the second 25. With 0 as the second
a load that comes leaves 0.8 of PI's error in its first second, not 0.5.
"""


SUDDEN = 0.15
"""Observed torque over the friction, beyond which it may be a sudden change.

With 0.15 the first 5 s after a drop of friction leave 0.283 of PI's error, with 0.3 0.303, without the rule 0.306
(seeds 101 to 130).
"""


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


@register_jitable
def short_mean(mean: float, square: float, weight: float, at_once: float) -> float:
    """Return a short mean of squares after another one of this weight, of which a share may count at once."""
    return max(mean + weight * (square - mean), at_once * square)


@register_jitable
def tells_at_once(disturbance: float, one_way: float, coloured: bool, known: Circumstances) -> bool:
    """Tell whether the observed torque may be a sudden change: then a gate opens within two samples, not in five.

    The plan must have moved one way for 0.3 s, and the torque must be more than 0.15 of a friction that is known. For
    friction that is reversed too early or too late is observed as well, only the error after a reversal shows by how
    much (:mod:`adaptive_ff.adaptive.learning.lag_tuning`), and an observer that takes it over leaves nothing to learn
    from. Beside coloured noise a large torque may be noise.

    Parameters
    ----------
    disturbance : float
        The observed torque, N m.
    one_way : float
        For how long the plan has moved one way, s.
    coloured : bool
        Whether the noise of the measured velocity is coloured.
    known : Circumstances
        What is known of the joint.
    """
    much = SUDDEN * SUDDEN * known.friction * known.friction
    return 0.0 < much < disturbance * disturbance and one_way >= WINDOW and not coloured and not known.held


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


@register_jitable
def misfit(noise: NoiseState, feedback: PIParameters, squared_error: float) -> float:
    """Return how badly the identified model fits, ``q``: 0 where noise explains its error, up to 1.

    Parameters
    ----------
    noise : NoiseState
        Noise of the measured velocity.
    feedback : PIParameters
        The PI loop; its gain makes a torque of the noise.
    squared_error : float
        Mean square of the torque that it leaves, N^2 m^2.
    """
    if not noise_known(noise):
        return 1.0
    explained = feedback.proportional * feedback.proportional * (LOUDER * noise.variance + ROUNDING)
    return saturated(squared_error / (explained + TINY) - 1.0)


@register_jitable
def observed_inertia(observer: ObserverParameters, identified: float, unfit: float) -> float:
    """Return the inertia ``J_o`` (kg m^2) for an identified one (kg m^2) of a model that is unfit to a share."""
    least = min(identified, observer.inertia)
    return least + unfit * (observer.inertia - least)


@register_jitable
def smoothed_noise(state: ObserverState, share: float) -> float:
    """Return the variance (rad^2/s^2) of the noise behind a mean that takes a share of each new value."""
    return state.noise.variance * share / (2.0 - share)


@register_jitable
def error_beyond_noise(observer: ObserverParameters, state: ObserverState) -> float:
    """Return by how much the mean squared error that the feedback sees is more than noise explains, rad^2/s^2."""
    share = -math.expm1(-observer.pole * observer.period)
    return state.error_squared - EXPLAINED * smoothed_noise(state, share)


@register_jitable
def observer_gain(
    observer: ObserverParameters, state: ObserverState, feedback: PIParameters, inertia: float, unfit: float
) -> float:
    """Return the gain ``g`` that the gates allow, for an identified inertia (kg m^2) of a model unfit to a share."""
    if not noise_known(state.noise):
        return 1.0
    share = -math.expm1(-observer.pole * observer.period)
    left = state.error_squared / (LOUDER * smoothed_noise(state, share) + TINY) - 1.0
    amplified = share * inertia / observer.period
    noise = amplified * (amplified * 2.0 / (2.0 - share) * state.noise.variance)
    rounding = feedback.proportional * feedback.proportional * ROUNDING
    observed = state.squared / (LOUDER * OBSERVED_NOISE * noise + rounding + TINY) - 1.0
    share_of_loop = min(1.0, feedback.proportional * observer.period / observer.inertia)
    white = 2.0 * smoothed_noise(state, share_of_loop)
    level = min(max(white, state.quiet), (unfit + (1.0 - unfit) * COLOURED) * white)
    predicted = state.predicted_squared / (LOUDER * level + TINY) - 1.0
    return min(saturated(observed), max(saturated(predicted), saturated(left)))


@register_jitable
def helping_share(state: ObserverState, friction: float) -> float:
    """Return the share of its gain that the observer is used with beside coloured noise or in a steady oscillation.

    Where it does not help the share is less than one, unless the observed torque is much of the friction (N m), as a
    load is. In a steady oscillation even that does not count, since a sensor that ripples feigns any torque.
    """
    if state.effect.help >= 1.0 or steadily_oscillates(state.effect, state.noise.variance):
        return state.effect.help
    level = MUCH * MUCH * friction * friction
    observed = max(state.squared, AT_ONCE * state.disturbance * state.disturbance)
    return state.effect.help + (1.0 - state.effect.help) * saturated(observed / (level + TINY) - 1.0)
