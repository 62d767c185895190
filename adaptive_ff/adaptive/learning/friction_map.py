"""A map of friction over position and load, learnt from what the model leaves.

Friction of gears and screws rises and falls with their position, and with the torque that they carry. What the model
has for friction is multiplied by a factor

    phi = 1 + g m,    m = sum_k (a_k cos(2 pi q/p_k) + b_k sin(2 pi q/p_k)) + sum_j c_j hat_j(q) + l (|u| - <|u|>)/unit

with known periods ``p_k``, hats ``hat_j`` (piecewise linear functions of one at their own position, zero from the next
ones on, evenly over a range), and the known torque ``u`` that the joint transmits. The factor enters the regression in
the columns of friction and the feedforward in its Coulomb friction, stiction and viscous friction, so both lags and
the bristles are those of the model.

The coefficients are found beside the model, not with it: with ``F`` the filtered friction of the model without the
factor and ``e`` the error that model and full map leave,

    D_i <- D_i + |x_i| (F^2 sum_j |x_j| - D_i/T) dt,    c_i <- c_i + x_i F e dt/(D_i + prior)

``D`` is the sum of the rows of the information matrix of least squares, which is at least that matrix, so that the
recursion is stable; an entry fades only while it is visited, with the memory ``T``. A hat more costs three numbers
of memory and no time: only the two at the present position change, and one that is visited for the first time begins
as far like its neighbour as hats so far are alike. This is the projection algorithm of G. Goodwin and
K. Sin, "Adaptive filtering, prediction and control" (1984), with a gain for each coefficient.

Whether friction depends on position is decided by evidence: with what the map said of the torque before the present
stroke, ``x = F m``, and the error without the map, ``y``, over the last seconds

    g = sat((<x y>/(<x^2> + rho <y^2>) - 0.3)/0.2)

The map of before, because within a stroke the hats follow whatever the model lacks, and a load that is not modelled
turns its sign against friction at the reversal. Where friction does not depend on position, ``g`` is zero, and the
controller is the one without a map.
"""

import math
from typing import NamedTuple

import numpy as np
from numba.extending import register_jitable
from numpy.typing import NDArray

from adaptive_ff.learning.filters import filter_decay
from adaptive_ff.regression.known_loads import INPUT, VALUE, advance_load_in_place
from controllers.arrays import MutableArray

POSITION, LOAD = range(2)
"""Rows of the filters."""

PRIOR = 0.001
"""Time for which the first coefficients, zero, weigh, s of sliding motion at a position."""

MEMORIES = 2.0
"""Memory of the evidence, in memories of the estimator ..."""

GROWTH = 0.5
"""... and at most this share of the time for which there has been any."""

LOAD_MEMORIES = 10.0
"""Memory of the mean known torque, in memories of the estimator."""

LOAD_FADING = 0.5
"""Memory of the load's coefficient over that of the others: with the position it changes all the time."""

FIRST = 1.0
"""Time of learning before the map is fed, in memories of the estimator."""

DOUBT = 0.05
"""Share of the mean squared error that the map must explain to count as much as none, ``rho``."""

LEAST_SLOPE, FULL_SLOPE = 0.3, 0.5
"""Slope from which the map is fed at all, and fed in full.

A map that is right has a slope below one: before it is fed, the estimator follows slow variations by itself.
"""

OUTLIER = 3.0
"""Errors beyond this many times the usual one count as so large: a sudden change is none of position."""

LEAST_FACTOR, LARGEST_FACTOR = 0.2, 3.0
"""Range of the factor."""

LARGEST_COEFFICIENT = 2.0
"""Largest coefficient of the map, of either sign."""


class MapParameters(NamedTuple):
    """Parameters of the map; without periods, hats and load there is none.

    Attributes
    ----------
    waves : ndarray, shape (k,)
        ``2 pi`` over the known periods, 1/rad.
    hats : int
        Number of hats; none, or two at least.
    lowest : float
        Position of the first hat, rad.
    spacing : float
        From one hat to the next, rad.
    load : float
        Unit of the known torque, N m; zero where friction is not assumed to depend on it.
    memory : float
        Memory ``T`` of the map, s of sliding motion at a position.
    """

    waves: NDArray[np.float64]
    hats: int
    lowest: float
    spacing: float
    load: float
    memory: float


class MapState(NamedTuple):
    """State of the map; its arrays are changed in place.

    Attributes
    ----------
    coefficients : ndarray, shape (n,)
        That of the load where there is one, cosine and sine of each period, hats.
    before : ndarray, shape (n,)
        The coefficients as they were at the last reversal, without hats at most a memory of the estimator ago: what an
        earlier stroke says of this one.
    information : ndarray, shape (n,)
        Sum of the rows of their information matrix, N^2 m^2 s.
    signals : ndarray, shape (2, 3)
        Filters of position (rad) and known torque (N m).
    known : bool
        Whether there has been a position.
    direction : float
        Direction of the present stroke, 1 or -1; zero before the first.
    age : float
        For how long these coefficients have been kept, s of sliding motion.
    share : float
        Share ``g`` of the map that is fed.
    seen : float
        For how long the map has been learnt, s of sliding motion.
    xx, xy, yy : float
        Mean products of what the map of earlier strokes says of the torque, and of the error without map, N^2 m^2.
    friction : float
        Mean squared friction, N^2 m^2.
    load : float
        Mean known torque, without its sign, N m: at it friction is that of the model.
    """

    coefficients: MutableArray
    before: MutableArray
    information: MutableArray
    signals: MutableArray
    known: bool
    direction: float
    age: float
    share: float
    seen: float
    xx: float
    xy: float
    yy: float
    friction: float
    load: float


NO_MAP = MapParameters(np.zeros(0), 0, 0.0, 1.0, 0.0, 1.0)
"""Friction that depends neither on position nor on load."""


def coefficient_count(parameters: MapParameters) -> int:
    """Return how many coefficients a map has."""
    return 2 * parameters.waves.size + parameters.hats + (1 if parameters.load > 0.0 else 0)


def initial_map(parameters: MapParameters) -> MapState:
    """Return the map of a joint of which nothing has been seen."""
    count = coefficient_count(parameters)
    arrays = (np.zeros(count), np.zeros(count), np.zeros(count), np.zeros((2, 3)))
    return MapState(*arrays, False, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0)


@register_jitable
def follow_map_in_place(
    state: MapState, pole: float, angle: float, load: float, duration: float, first: bool
) -> MapState:
    """Advance the filters of position (rad) and known torque (N m) by one sample; return the state."""
    if state.coefficients.size == 0:
        return state
    known = state.known or math.isfinite(angle)
    if known:
        decay = filter_decay(pole, duration)
        advance_load_in_place(state.signals[POSITION], pole, decay, angle, duration, not state.known)
        advance_load_in_place(state.signals[LOAD], pole, decay, abs(load), duration, first or not state.known)
    return state._replace(known=known)


@register_jitable
def hat_place(parameters: MapParameters, angle: float) -> tuple[int, float]:
    """Return the hat below a position (rad), and the share of the one above; at the ends the map goes on as it is."""
    place = min(max((angle - parameters.lowest) / parameters.spacing, 0.0), parameters.hats - 1.0)
    below = min(int(place), parameters.hats - 2)
    return below, place - below


@register_jitable
def map_value(parameters: MapParameters, coefficients: NDArray[np.float64], angle: float, load: float) -> float:
    """Return what a map says at a position (rad) under a known torque (N m, without its sign, beyond its mean)."""
    value, place = 0.0, 0
    if parameters.load > 0.0:
        value += coefficients[place] * load / parameters.load
        place = 1
    for i in range(parameters.waves.size):
        phase = parameters.waves[i] * angle
        value += coefficients[place] * math.cos(phase) + coefficients[place + 1] * math.sin(phase)
        place += 2
    if parameters.hats > 1:
        below, share = hat_place(parameters, angle)
        value += (1.0 - share) * coefficients[place + below] + share * coefficients[place + below + 1]
    return value


@register_jitable
def limited_factor(share: float, value: float) -> float:
    """Return the factor on friction of a share of what a map says."""
    return min(max(1.0 + share * value, LEAST_FACTOR), LARGEST_FACTOR)


@register_jitable
def filtered_factor(parameters: MapParameters, state: MapState) -> float:
    """Return the factor on the friction of the regression: that at the filtered position."""
    if state.coefficients.size == 0:
        return 1.0
    if state.share == 0.0:
        return 1.0
    angle, load = state.signals[POSITION, VALUE], state.signals[LOAD, VALUE] - state.load
    return limited_factor(state.share, map_value(parameters, state.coefficients, angle, load))


@register_jitable
def coming_factor(parameters: MapParameters, state: MapState, turn: float) -> float:
    """Return the factor on the friction that is fed, after a change of position (rad)."""
    if state.coefficients.size == 0:
        return 1.0
    if state.share == 0.0:
        return 1.0
    angle, load = state.signals[POSITION, INPUT], state.signals[LOAD, INPUT] - state.load
    if state.known:  # else the map stands where it says nothing
        angle += turn
    return limited_factor(state.share, map_value(parameters, state.coefficients, angle, load))


@register_jitable
def correct_entry_in_place(
    state: MapState, place: int, value: float, memory: float, total: float, duration: float, torque: float
) -> None:
    """Correct one coefficient whose regressor has a value.

    Parameters
    ----------
    state : MapState
        The map; changed in place.
    place : int
        Which coefficient.
    value : float
        Its regressor.
    memory : float
        Its memory, s.
    total : float
        Squared friction times the sum of the sizes of all regressors, N^2 m^2.
    duration : float
        Time since the last sample, s.
    torque : float
        Friction times the error that is left, N^2 m^2.
    """
    size, prior = abs(value), PRIOR * state.friction
    state.information[place] += duration * (size * total - min(size, 1.0) * state.information[place] / memory)
    weight = state.information[place] + prior
    if weight > 0.0:  # else there has been no friction yet
        moved = state.coefficients[place] + value * torque * duration / weight
        state.coefficients[place] = min(max(moved, -LARGEST_COEFFICIENT), LARGEST_COEFFICIENT)


@register_jitable
def likeness(parameters: MapParameters, state: MapState) -> float:
    """Return how far hats that have been visited are like the next ones, from 0 to 1."""
    product, square = 0.0, 0.0
    for i in range(state.coefficients.size - parameters.hats, state.coefficients.size - 1):
        if state.information[i] > 0.0 and state.information[i + 1] > 0.0:
            one, other = state.coefficients[i], state.coefficients[i + 1]
            product += one * other
            square += 0.5 * (one * one + other * other)
    if square == 0.0:
        return 0.0
    return max(product / square, 0.0)


@register_jitable
def begin_hat_in_place(parameters: MapParameters, state: MapState, place: int, neighbour: int) -> None:
    """Let a hat that is visited for the first time begin as far like its neighbour as others are.

    The likeness is squared since neighbours have errors in common, which look like it.
    """
    if state.information[place] == 0.0:
        state.coefficients[place] = likeness(parameters, state) ** 2 * state.coefficients[neighbour]


@register_jitable
def taken_over(parameters: MapParameters, old: MapState, new: MapState) -> float:
    """Return the factor on the friction of the model by which a change of the share leaves what is fed as it is.

    While the map is not fed the model follows friction from place to place by itself: it has that of the present one.
    """
    if new.share == old.share:
        return 1.0
    angle, load = new.signals[POSITION, VALUE], new.signals[LOAD, VALUE] - new.load
    value = map_value(parameters, new.coefficients, angle, load)
    return limited_factor(old.share, value) / limited_factor(new.share, value)


@register_jitable
def correct_map_in_place(
    parameters: MapParameters, state: MapState, friction: float, error: float, duration: float
) -> None:
    """Correct all coefficients that the present position and load excite.

    Parameters
    ----------
    parameters : MapParameters
        The map.
    state : MapState
        Its state; changed in place.
    friction : float
        Filtered friction of the model without the factor, N m.
    error : float
        Error of the torque that model and full map leave, N m.
    duration : float
        Time since the last sample, s.
    """
    angle, load, place, memory = state.signals[POSITION, VALUE], 0.0, 0, parameters.memory
    sizes = 1.0 if parameters.hats > 1 else 0.0
    for i in range(parameters.waves.size):
        phase = parameters.waves[i] * angle
        sizes += abs(math.cos(phase)) + abs(math.sin(phase))
    if parameters.load > 0.0:
        load = (state.signals[LOAD, VALUE] - state.load) / parameters.load
        sizes += abs(load)
    total, torque = friction * friction * sizes, friction * error
    if parameters.load > 0.0:
        correct_entry_in_place(state, place, load, LOAD_FADING * memory, total, duration, torque)
        place = 1
    for i in range(parameters.waves.size):
        phase = parameters.waves[i] * angle
        correct_entry_in_place(state, place, math.cos(phase), memory, total, duration, torque)
        correct_entry_in_place(state, place + 1, math.sin(phase), memory, total, duration, torque)
        place += 2
    if parameters.hats > 1:
        below, share = hat_place(parameters, angle)
        if share < 1.0:
            begin_hat_in_place(parameters, state, place + below, place + below + 1)
        if share > 0.0:
            begin_hat_in_place(parameters, state, place + below + 1, place + below)
        correct_entry_in_place(state, place + below, 1.0 - share, memory, total, duration, torque)
        correct_entry_in_place(state, place + below + 1, share, memory, total, duration, torque)


@register_jitable
def learn_map_in_place(
    parameters: MapParameters, state: MapState, friction: float, error: float, duration: float, memory: float
) -> MapState:
    """Take one sample of sliding motion into account, and weigh whether friction depends on position at all.

    Parameters
    ----------
    parameters : MapParameters
        The map.
    state : MapState
        Its state; its arrays are changed in place.
    friction : float
        Filtered friction of the model with the factor in use, N m.
    error : float
        Error of the torque that it leaves, N m.
    duration : float
        Time since the last sample, s.
    memory : float
        Memory of the estimator, s.
    """
    if state.coefficients.size == 0 or not state.known:
        return state
    direction = math.copysign(1.0, friction)
    age = state.age + duration
    if direction != state.direction or (parameters.hats == 0 and age > memory):
        age = 0.0
        for i in range(state.before.size):
            state.before[i] = state.coefficients[i]
    angle, load = state.signals[POSITION, VALUE], state.signals[LOAD, VALUE] - state.load
    value = map_value(parameters, state.coefficients, angle, load)
    factor = limited_factor(state.share, value)
    friction /= factor
    plain = error + (factor - 1.0) * friction
    said = map_value(parameters, state.before, angle, load) * friction
    seen = state.seen + duration
    weight = duration / (duration + min(MEMORIES * memory, GROWTH * seen))
    slow = duration / min(LOAD_MEMORIES * memory, seen)
    xx, xy = state.xx + weight * (said * said - state.xx), state.xy + weight * (said * plain - state.xy)
    yy = state.yy + weight * (plain * plain - state.yy)
    squared = state.friction + weight * (friction * friction - state.friction)
    share, left = 0.0, plain - (limited_factor(1.0, value) - 1.0) * friction
    if seen > FIRST * memory and yy > 0.0:
        slope = xy / (xx + DOUBT * yy)
        share = min(max((slope - LEAST_SLOPE) / (FULL_SLOPE - LEAST_SLOPE), 0.0), 1.0)
        usual = OUTLIER * math.sqrt(yy)
        left = min(max(left, -usual), usual)
    new = MapState(
        coefficients=state.coefficients,
        before=state.before,
        information=state.information,
        signals=state.signals,
        known=state.known,
        direction=direction,
        age=age,
        share=share,
        seen=seen,
        xx=xx,
        xy=xy,
        yy=yy,
        friction=squared,
        load=state.load + slow * (state.signals[LOAD, VALUE] - state.load),
    )
    correct_map_in_place(parameters, new, friction, left, duration)
    return new
