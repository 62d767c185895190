"""State-variable filter ``(p/(s + p))^2``: a signal and its derivatives, smoothed alike, exact between samples.

For an input that is linear over a step, ``x(t) = x0 + r t``, the output is known in closed form, so the length of a
step may vary from sample to sample without error. A held input is the case ``r = 0``.
"""

import math

import numpy as np
from numpy.typing import NDArray


def advance_filter_in_place(
    state: NDArray[np.float64], pole: float, decay: float, start: float, end: float, duration: float
) -> None:
    """Advance one filter over a segment of input that is linear in time.

    Parameters
    ----------
    state : ndarray, shape (2,)
        Filtered value and its derivative; changed in place.
    pole : float
        Pole ``p``, rad/s.
    decay : float
        ``exp(-p duration)``, shared by all filters of a step.
    start, end : float
        Input at the start and the end.
    duration : float
        Duration, s, positive.
    """
    rate = (end - start) / duration
    offset = 2.0 * rate / pole  # in steady state the output follows a ramp this far behind
    value = state[0] - (start - offset)
    slope = state[1] - rate
    step = pole * duration
    state[0] = end - offset + decay * ((1.0 + step) * value + duration * slope)
    state[1] = rate + decay * (-pole * step * value + (1.0 - step) * slope)


def second_derivative(state: NDArray[np.float64], pole: float, value: float) -> float:
    """Return the filtered second derivative of a signal whose present value is given."""
    derivative: float = pole * pole * (value - state[0]) - 2.0 * pole * state[1]
    return derivative


def filter_decay(pole: float, duration: float) -> float:
    """Return ``exp(-p duration)``."""
    return math.exp(-pole * duration)
