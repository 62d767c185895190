"""Whether the observer helps: the error that there is, against the one that the loop would make without it.

    rho = (<e^2> - s^2) / <ehat^2 + c^2>,    h = 1 - sat((rho - 1.05) / 0.15)

``e`` is the error that the feedback sees, ``s`` the noise of the measured velocity, ``ehat = G(res)`` the error that
the PI loop would make of the residual, ``c`` what an outer loop adds to the plan, ``<.>`` a mean over 1 s. An observer
takes a part of the residual away, so what is left is less than the PI loop would leave: 0.1 to 0.7 of it on joints of
all kinds, hardly ever more than all of it. Where it is far more, the loop oscillates with what the observer feeds back.
So it does where a filter makes a velocity of an encoder with few counts and lags by more than has been told: with 4096
counts in a turn and a Kalman filter the error was five times that of the PI loop alone.

The share ``h`` of the gain falls at once while the observer is in use and the error is 0.12 of the plan's largest speed
or more, and rises by at most 1 in 20 s.
"""

from typing import NamedTuple

from numba.extending import register_jitable

WINDOW = 1.0
"""Length of the means, s: single reversals, at which a joint sticks and does not answer as predicted, do not count."""

WORSE = 1.05
"""Squared error that there is over the predicted one, from which on the observer is held back ..."""

FAR_WORSE = 1.2
"""... and from which on it is not used."""

LARGE = 0.12
"""Error over the largest speed of the plan from which on it counts: a loop that oscillates makes such ones.

Of a small one it matters little what made it; with all counted, joints on steep curves lost up to a tenth.
"""

IN_USE = 0.5
"""Gain of the observer from which on the error tells of it."""

RETURN = 20.0
"""Time in which the share rises from zero to one, s."""

NONE = 1e-15
"""Added to what may be zero, rad^2/s^2."""


class ObserverEffect(NamedTuple):
    """What is known of the effect of the observer.

    Attributes
    ----------
    error_squared : float
        Mean squared error that the feedback sees, rad^2/s^2.
    expected_squared : float
        Mean square of what it would be without the observer, rad^2/s^2.
    share : float
        Share ``h`` of its gain that the observer is used with.
    """

    error_squared: float
    expected_squared: float
    share: float


def initial_effect() -> ObserverEffect:
    """Return the state of an observer of which nothing bad is known."""
    return ObserverEffect(0.0, 0.0, 1.0)


@register_jitable
def advance_effect(
    state: ObserverEffect,
    error: float,
    predicted: float,
    correction: float,
    variance: float,
    peak: float,
    gain: float,
    duration: float,
) -> ObserverEffect:
    """Take the error of a sample into account.

    Parameters
    ----------
    state : ObserverEffect
        The state.
    error, predicted, correction : float
        Error that the feedback sees, error ``ehat``, and what an outer loop asks for, rad/s.
    variance : float
        Variance of the measured velocity, rad^2/s^2.
    peak : float
        Largest speed of the plan of late, rad/s.
    gain : float
        Gain with which the observer was fed back.
    duration : float
        Length of the period, s.
    """
    weight = duration / (WINDOW + duration)
    error_squared = state.error_squared + weight * (error * error - state.error_squared)
    expected = predicted * predicted + correction * correction
    expected_squared = state.expected_squared + weight * (expected - state.expected_squared)
    share = min(1.0, state.share + duration / RETURN)
    beyond_noise = error_squared - variance
    if gain > IN_USE * state.share and beyond_noise > LARGE * LARGE * peak * peak:
        ratio = beyond_noise / (expected_squared + NONE)
        share = min(share, max(0.0, min(1.0, (FAR_WORSE - ratio) / (FAR_WORSE - WORSE))))
    return ObserverEffect(error_squared, expected_squared, share)
