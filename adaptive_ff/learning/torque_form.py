"""Torque-form regression: the joint's equation, filtered, linear in its physical parameters.

Equation (2) of the paper, ``J tau w'' + J w' + F(w) = u + tau u'``, is passed through ``(p/(s + p))^2``:

    u_f = (J tau) w''_f + J w'_f + Fc g_f + Fs h_f + sigma w_f - tau u'_f

with ``g`` and ``h`` of (5) and (6). No signal is differentiated: the filters hold the derivatives as states. For an
input that is linear over a step their output is known in closed form, so the steps may vary without error. The torque
is held between samples; the velocity is taken as linear between them, and where it reverses, ``g`` and ``h`` are split
at the moment of reversal, because the friction lag shows nowhere else.

An offset and friction that differs by direction (see ``model``) add the columns ``1``, ``|h|_f`` and ``|w|_f``. A
regression without them has neither their columns nor their filters: the sizes of the arrays say which it is.
"""

import math
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from adaptive_ff.friction.model import WITH_OFFSET, stiction_fraction
from controllers.arrays import MutableArray

FILTER_TORQUE, FILTER_VELOCITY, FILTER_COULOMB, FILTER_ADHESION, FILTER_FRACTION, FILTER_SPEED = range(6)
"""Rows of the filters; the last two, ``|h|`` and ``|w|``, are there where friction differs by direction."""


class TorqueForm(NamedTuple):
    """Parameters of the regression."""

    pole: float  # filter pole ``p``, rad/s
    stribeck_velocity: float  # stribeck velocity ``Vs``, rad/s
    stribeck_shape: float  # stribeck shape factor ``delta``


class Signals(NamedTuple):
    """Filtered signals."""

    # shape (4, 2) or (6, 2); filtered value and derivative of torque, velocity, ``g`` and ``h``, and of ``|h|`` and
    # ``|w|`` where friction differs by direction; changed in place
    filters: MutableArray
    velocity: float  # velocity at the last sample, rad/s


def initial_signals(form: TorqueForm, parameters: int, velocity: float = 0.0) -> Signals:
    """Return the filters of a joint that has moved at a velocity (rad/s) for long, under an unknown torque.

    The number is that of the parameters of the model.
    """
    filters = np.zeros((4 if parameters <= len(WITH_OFFSET) else 6, 2))
    fraction = stiction_fraction(abs(velocity), form.stribeck_velocity, form.stribeck_shape)
    direction = float(np.sign(velocity))
    filters[FILTER_VELOCITY, 0] = velocity
    filters[FILTER_COULOMB, 0] = direction * (1.0 - fraction)
    filters[FILTER_ADHESION, 0] = direction * fraction
    if len(filters) > FILTER_FRACTION:
        filters[FILTER_FRACTION:, 0] = abs(direction) * fraction, abs(velocity)
    return Signals(filters, velocity)


def advance_filter_in_place(
    state: NDArray[np.float64], pole: float, decay: float, start: float, end: float, duration: float
) -> None:
    """Advance value and derivative behind a filter over a segment (s) of input that is linear in time.

    All filters of a step share the ``decay``, ``exp(-p duration)``.
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


def advance_friction_in_place(form: TorqueForm, signals: Signals, start: float, end: float, duration: float) -> None:
    """Advance the filters of ``g`` and ``h``, and of ``|h|`` and ``|w|``, over a motion that does not reverse."""
    if duration > 0.0:
        direction = math.copysign(1.0, start + end) if start + end != 0.0 else 0.0
        first = stiction_fraction(abs(start), form.stribeck_velocity, form.stribeck_shape)
        last = stiction_fraction(abs(end), form.stribeck_velocity, form.stribeck_shape)
        decay = math.exp(-form.pole * duration)
        slip, slips = direction * (1.0 - first), direction * (1.0 - last)
        adhesion, adhesions = direction * first, direction * last
        advance_filter_in_place(signals.filters[FILTER_COULOMB], form.pole, decay, slip, slips, duration)
        advance_filter_in_place(signals.filters[FILTER_ADHESION], form.pole, decay, adhesion, adhesions, duration)
        if signals.filters.shape[0] > FILTER_FRACTION:
            sliding = abs(direction)
            advance_filter_in_place(
                signals.filters[FILTER_FRACTION], form.pole, decay, sliding * first, sliding * last, duration
            )
            advance_filter_in_place(signals.filters[FILTER_SPEED], form.pole, decay, abs(start), abs(end), duration)


def advance_signals_in_place(
    form: TorqueForm, signals: Signals, torque: float, velocity: float, duration: float
) -> Signals:
    """Advance all filters by one sample.

    Parameters
    ----------
    form : TorqueForm
        The regression.
    signals : Signals
        Filters; their array is changed in place.
    torque : float
        Torque over the period that ends now, N m.
    velocity : float
        Velocity now, rad/s.
    duration : float
        Length of that period, s.

    Returns
    -------
    Signals
        The filters at the new sample.
    """
    start = signals.velocity
    decay = math.exp(-form.pole * duration)
    advance_filter_in_place(signals.filters[FILTER_TORQUE], form.pole, decay, torque, torque, duration)
    advance_filter_in_place(signals.filters[FILTER_VELOCITY], form.pole, decay, start, velocity, duration)
    if start * velocity < 0.0:
        turn = duration * start / (start - velocity)
        advance_friction_in_place(form, signals, start, 0.0, turn)
        advance_friction_in_place(form, signals, 0.0, velocity, duration - turn)
    else:
        advance_friction_in_place(form, signals, start, velocity, duration)
    return Signals(signals.filters, velocity)


def write_regressors(form: TorqueForm, signals: Signals, row: NDArray[np.float64]) -> float:
    """Write the regressors into a row, and return the regressed torque ``u_f``, N m.

    The row has as many places as there are columns; what follows these belongs to known loads and is written after.
    """
    velocity = signals.filters[FILTER_VELOCITY]
    row[0] = second_derivative(velocity, form.pole, signals.velocity)
    row[1] = velocity[1]
    row[2] = signals.filters[FILTER_COULOMB, 0]
    row[3] = signals.filters[FILTER_ADHESION, 0]
    row[4] = velocity[0]
    row[5] = -signals.filters[FILTER_TORQUE, 1]
    if row.size > 6:
        row[6] = 1.0
    if signals.filters.shape[0] > FILTER_FRACTION:
        row[7] = signals.filters[FILTER_FRACTION, 0]
        row[8] = signals.filters[FILTER_SPEED, 0]
    return signals.filters[FILTER_TORQUE, 0]  # type: ignore[no-any-return]
