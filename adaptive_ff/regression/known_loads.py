"""Known loads: torques whose course is known and whose size is not, ``G(t) = sum_i a_i x_i(t)``.

Gravity on a rotary joint is ``a sin q + b cos q``: two regressors that the measured position makes, a wave over the
position with one period in a turn. Cogging and ripple of a motor are waves of a shorter known period. In a coupled arm
a joint carries sines of other angles as well: further regressors, given at each sample.

A load does not follow the friction lag as friction does. In the joint's equation,

    J tau w'' + J w' + F(w) + G + tau G' = u + tau u',

it brings its derivative along, so a regressor's column is ``x_f + tau x'_f``, both out of one filter
``(p/(s + p))^2``. Between samples it is taken as linear. Regressors should be of the size of one, as sines are.

Where a position or a regressor is not finite, its last value is held; before there has been a position there are no
waves, neither in the regression nor in the feedforward.
"""

import math

import numpy as np
from numba.extending import register_jitable
from numpy.typing import NDArray

from adaptive_ff.learning.filters import advance_filter_in_place, filter_decay

VALUE, SLOPE, INPUT = range(3)
"""Columns of the loads: filtered value, its derivative, last input."""

SINE, COSINE = range(2)
"""Rows of the first wave, which are the first ones where there is one; two of each further wave follow."""


def initial_loads(count: int) -> NDArray[np.float64]:
    """Return the filters of so many regressors before the first sample, shape (count, 3)."""
    return np.zeros((count, 3))


@register_jitable
def advance_load_in_place(
    load: NDArray[np.float64], pole: float, decay: float, value: float, duration: float, fresh: bool
) -> None:
    """Advance the filter of one regressor to a new value, or settle it there where it is the first one."""
    if not math.isfinite(value):
        value = load[INPUT]
    if fresh:
        load[VALUE] = value
        load[SLOPE] = 0.0
    else:
        advance_filter_in_place(load, pole, decay, load[INPUT], value, duration)
    load[INPUT] = value


@register_jitable
def advance_loads_in_place(
    loads: NDArray[np.float64],
    waves: NDArray[np.float64],
    regressors: NDArray[np.float64],
    pole: float,
    position: float,
    duration: float,
    first: bool,
) -> None:
    """Advance the filters of all regressors by one sample.

    Parameters
    ----------
    loads : ndarray, shape (n, 3)
        Filters, a sine and a cosine of each wave first; changed in place.
    waves : ndarray, shape (w,)
        Waves over the position, times ``2 pi``, in a rad: one for gravity.
    regressors : ndarray, shape (m,)
        Further regressors now; ``n`` is ``2 w + m``.
    pole : float
        Pole ``p``, rad/s.
    position : float
        Measured position, rad; not a number where it is not known.
    duration : float
        Time since the last sample, s.
    first : bool
        Whether this is the first sample.
    """
    if loads.shape[0] == 0:
        return
    decay, fresh = filter_decay(pole, duration), first
    if waves.size > 0:  # no angle has a sine and a cosine of zero: there has been no position yet
        fresh = first or (loads[SINE, INPUT] == 0.0 and loads[COSINE, INPUT] == 0.0)
    for i in range(waves.size):
        sine, cosine = math.nan, math.nan
        if math.isfinite(position):
            sine, cosine = math.sin(waves[i] * position), math.cos(waves[i] * position)
        advance_load_in_place(loads[2 * i], pole, decay, sine, duration, fresh)
        advance_load_in_place(loads[2 * i + 1], pole, decay, cosine, duration, fresh)
    for i in range(regressors.size):
        advance_load_in_place(loads[2 * waves.size + i], pole, decay, regressors[i], duration, first)


@register_jitable
def write_loads(loads: NDArray[np.float64], row: NDArray[np.float64]) -> None:
    """Write the regressors behind the others of a row: all filtered values, then all derivatives."""
    count = loads.shape[0]
    first = row.size - 2 * count
    for i in range(count):
        row[first + i] = loads[i, VALUE]
        row[first + count + i] = loads[i, SLOPE]


@register_jitable
def load_torque(
    estimate: NDArray[np.float64], loads: NDArray[np.float64], waves: NDArray[np.float64], angle: float
) -> float:
    """Return the torque (N m) that carries the loads, waves as they are after a turn by an angle (rad).

    Parameters
    ----------
    estimate : ndarray, shape (k,)
        Estimate, of which the last are the sizes of the loads.
    loads : ndarray, shape (n, 3)
        Filters; their last inputs are taken.
    waves : ndarray, shape (w,)
        Waves over the position, times ``2 pi``, in a rad.
    angle : float
        How far the joint will have turned when the torque acts.
    """
    torque = 0.0
    place = estimate.size - loads.shape[0]
    for i in range(waves.size):
        sine, cosine = loads[2 * i, INPUT], loads[2 * i + 1, INPUT]
        turned, ahead = math.sin(waves[i] * angle), math.cos(waves[i] * angle)
        torque += estimate[place + 2 * i] * (sine * ahead + cosine * turned)
        torque += estimate[place + 2 * i + 1] * (cosine * ahead - sine * turned)
    for i in range(2 * waves.size, loads.shape[0]):
        torque += estimate[place + i] * loads[i, INPUT]
    return torque
