"""Gates of the observer: the gain with which the observed torque is fed back, and the inertia that it is observed with.

Where the feedforward leaves nothing, an observer feeds back noise. So its gain is ``g = min(g_d, max(g_r, g_e))``, of
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

**Where the observer does not help** beside coloured noise, or where the loop oscillates steadily, its gain is reduced
besides (:func:`helping_share`, :mod:`adaptive_ff.adaptive.supervision.observer_effect`).

**The inertia** ``J_o`` of the observer is the one ``J_n`` that the feedback was designed for, or the identified one
``J`` where that is smaller and the model fits. How badly the model fits is ``q``, from the mean squared torque
``<eps^2>`` (N^2 m^2) that it leaves:

    J_o = J + q (J_n - J),    q = sat(<eps^2> / (4 (Kp s)^2) - 1)

- With half the load and the old inertia the observer would oscillate.
- But a Stribeck curve that falls steeply looks like a smaller inertia than there is. With that one the observer feeds
  back what accelerates the joint, which hunts.
- Where an inertia is given for the present configuration, ``J_o`` is in proportion to it. With that of the design, a
  joint of six times as much oscillates behind a position loop, where PI alone does not.
"""

import math

from numba.extending import register_jitable

from adaptive_ff.adaptive.supervision.circumstances import Circumstances
from adaptive_ff.adaptive.supervision.noise_level import NoiseState, noise_known
from adaptive_ff.adaptive.supervision.observer_effect import steadily_oscillates
from adaptive_ff.adaptive.supervision.observer_state import ObserverParameters, ObserverState
from adaptive_ff.estimation.shares import ROUNDING, TINY, saturated
from controllers import PIParameters

WINDOW = 0.3
"""Length of the short means, s."""

LOUDER = 4.0
"""Mean square over what noise explains of it, from which on a gate begins to open; at twice that it is open."""

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
