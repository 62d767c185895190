"""Unit torques of a joint along a motion: the columns of every regression in this package.

The torque that a motion ``r(t)`` needs is a sum ``sum_i theta_i psi_i`` of unit torques ``psi_i`` times coefficients:

=============  ==============================  ==========================================================
column         unit torque                     coefficient
=============  ==============================  ==========================================================
inertia        ``dr/dt``                       inertia ``J``, kg m^2
viscous        ``r`` behind the lag            viscous coefficient ``sigma``, N m s/rad
coulomb        ``s (1 - e)`` behind the lag    Coulomb friction ``Fc``, N m; ``g`` of the paper's (5)
stiction       ``s e`` behind the lag          stiction ``Fs``, N m; ``h`` of (6)
distance_i     ``z_i``, ``dz_i/dx = (s - z_i)/d_i``  Coulomb friction that follows over a path ``d_i``, N m
asymmetries    ``e`` behind the lag, ``|r|``   what differs by direction, N m and N m s/rad
waves          ``sin kq``, ``cos kq``          gravity (``k = 1``) and cogging, N m
map            ``s`` times a function of q     friction over position or load, N m
regressors     known signals                   their sizes, N m
=============  ==============================  ==========================================================

with ``e = exp(-|r/Vs|^delta)``, ``s`` the sign of ``r``, and the friction lag ``tau dz/dt = F - z``, equation (1). Two
parameters enter nonlinearly, ``ln tau`` and ``ln Vs``; the last two columns are the torque's sensitivities to them.
A new term is a new column here; nothing else has to know of it.
"""

import math
from typing import NamedTuple

import numpy as np

from adaptive_ff.friction.model import stribeck_power
from controllers import compiled
from controllers.arrays import MutableArray, NDArray

Array = NDArray[np.float64]

INERTIA, VISCOUS, COULOMB, STICTION, PATHS = range(5)
"""Places of the first columns; the distances begin at ``PATHS``."""

LAGGED_SLIP, LAGGED_STICTION, LAGGED_SLOPE, LAGGED_SPEED = range(4)
"""Places of what follows with the friction lag: ``g``, ``h``, ``dh/d ln Vs``, ``r``."""

SLIP_SENSITIVITY, STICTION_SENSITIVITY, SPEED_SENSITIVITY, LAGS = range(4, 8)
"""Places of the slopes of ``g``, ``h`` and ``r`` behind the lag over ``ln tau``."""


class Hypothesis(NamedTuple):
    """What the torque of a joint is taken to consist of."""

    shape: float  # stribeck shape factor ``delta``
    distances: Array  # shape (d,); presliding distances, rad
    directions: bool  # whether friction may differ by direction
    waves: Array  # shape (w,); wave numbers of torque over position, 1/rad: 1 for gravity
    map_waves: Array  # shape (m,); wave numbers of friction over position, 1/rad
    hats: int  # piecewise linear functions of position that friction varies by (linear B-splines)
    lowest: float  # position of the first of them, rad
    spacing: float  # distance of two of them, rad
    over_load: bool  # whether friction varies with the known torque
    regressors: int  # further known regressors
    gear_ratio: float  # given positions over those of the joint


class FrictionState(NamedTuple):
    """Memory of the friction columns; arrays are changed in place."""

    lagged: MutableArray  # shape (7,); what follows with the friction lag
    bent: MutableArray  # shape (d,); what follows over each presliding distance
    direction: float  # sign of the friction: -1, 0 before any motion, or 1
    held: float  # fraction of its static friction that a joint at rest holds, from -1 to 1


def initial_friction_state(hypothesis: Hypothesis) -> FrictionState:
    """Return the memory before any motion."""
    return FrictionState(np.zeros(LAGS), np.zeros(hypothesis.distances.size), 0.0, 0.0)


def column_count(hypothesis: Hypothesis) -> int:
    """Return the number of columns, the two sensitivities among them."""
    waves = hypothesis.waves.size + hypothesis.map_waves.size
    further = hypothesis.hats + int(hypothesis.over_load) + hypothesis.regressors
    return PATHS + hypothesis.distances.size + 2 * int(hypothesis.directions) + 2 * waves + further + 2


def is_friction(hypothesis: Hypothesis, place: int) -> bool:
    """Return whether a column is friction: neither inertia nor torque over position nor a further regressor."""
    first = PATHS + hypothesis.distances.size + 2 * int(hypothesis.directions)
    after = first + 2 * hypothesis.waves.size
    further = after + 2 * hypothesis.map_waves.size + hypothesis.hats + int(hypothesis.over_load)
    return INERTIA < place < first or after <= place < further


class Curve(NamedTuple):
    """What the columns depend on nonlinearly; the sensitivities are those of the present coefficients."""

    lag: float  # friction lag ``tau``, s
    stribeck_velocity: float  # stribeck velocity ``Vs``, rad/s
    coulomb: float  # present coefficient of Coulomb friction, N m
    stiction: float  # present coefficient of stiction, N m
    viscous: float  # present viscous coefficient, N m s/rad
    hold: float  # speed beyond zero at which a reversed motion turns friction, rad/s


def _follow_lag(
    lagged: MutableArray,
    place: int,
    slope_place: int,
    first: float,
    last: float,
    lag: float,
    duration: float,
    decay: float,
) -> tuple[float, float]:
    """Let one column follow a ramp with the friction lag; return its integral and that of its slope over ``ln tau``.

    With ``E = exp(-h/tau)``, the ``decay``, and ``rho = (F1 - F0)/h``: ``z1 = F1 + (z0 - F0) E - rho tau (1 - E)``; its
    integral and the derivatives of both with respect to ``ln tau`` in closed form.
    """
    settled, rate, away = 1.0 - decay, (last - first) / duration, lagged[place] - first
    integral = (first + 0.5 * rate * duration) * duration + away * lag * settled
    integral += rate * lag * (lag * settled - duration)
    lagged[place] = last + away * decay - rate * lag * settled
    if slope_place < 0:
        return integral, 0.0
    slope = lagged[slope_place]
    total = slope * lag * settled + away * (lag * settled - duration * decay)
    total += rate * (2.0 * lag * lag * settled - lag * duration * (decay + 1.0))
    lagged[slope_place] = slope * decay + away * decay * duration / lag - rate * (lag * settled - duration * decay)
    return integral, total


def _slide(
    hypothesis: Hypothesis,
    state: FrictionState,
    curve: Curve,
    sign: float,
    start: float,
    end: float,
    duration: float,
    psi: MutableArray,
) -> None:
    """Add the integrals of the friction columns over a motion in which friction has one sign."""
    velocity, shape = curve.stribeck_velocity, hypothesis.shape
    power_low, power_high = stribeck_power(abs(start), velocity, shape), stribeck_power(abs(end), velocity, shape)
    low, high = math.exp(-power_low), math.exp(-power_high)
    steep_low, steep_high = low * shape * power_low, high * shape * power_high
    lagged, lag, last = state.lagged, curve.lag, psi.size - 1
    decay = math.exp(-duration / lag)
    slip, by_slip = _follow_lag(
        lagged, LAGGED_SLIP, SLIP_SENSITIVITY, sign * (1.0 - low), sign * (1.0 - high), lag, duration, decay
    )
    stick, by_stick = _follow_lag(
        lagged, LAGGED_STICTION, STICTION_SENSITIVITY, sign * low, sign * high, lag, duration, decay
    )
    steep, _ = _follow_lag(lagged, LAGGED_SLOPE, -1, sign * steep_low, sign * steep_high, lag, duration, decay)
    psi[COULOMB] += slip
    psi[STICTION] += stick
    psi[last - 1] += curve.coulomb * by_slip + curve.stiction * by_stick
    psi[last] += (curve.stiction - curve.coulomb) * steep
    middle = 0.5 * (start + end)
    half, path = 0.25 * abs(start + middle) * duration, abs(middle) * duration
    for i in range(hypothesis.distances.size):
        away = state.bent[i] - sign
        psi[PATHS + i] += (sign + away * math.exp(-half / hypothesis.distances[i])) * duration
        state.bent[i] = sign + away * math.exp(-path / hypothesis.distances[i])


def write_columns(
    hypothesis: Hypothesis,
    state: FrictionState,
    curve: Curve,
    start: float,
    end: float,
    duration: float,
    position: float,
    load: float,
    regressors: Array,
    psi: MutableArray,
) -> FrictionState:
    """Write the mean unit torques over a period in which the velocity goes linearly from one value to another.

    Parameters
    ----------
    hypothesis, state, curve : Hypothesis, FrictionState, Curve
        Terms, their memory, and what they depend on nonlinearly.
    start, end : float
        Velocity at the start and at the end of the period, rad/s.
    duration : float
        The period, s.
    position : float
        Position in the middle of the period, rad; not a number where it is not known.
    load : float
        Known torque, N m, for friction that varies with it.
    regressors : ndarray
        Further known regressors.
    psi : ndarray, shape (n,)
        Is given the columns.
    """
    for i in range(psi.size):
        psi[i] = 0.0
    decay = math.exp(-duration / curve.lag)
    speed, by_speed = _follow_lag(state.lagged, LAGGED_SPEED, SPEED_SENSITIVITY, start, end, curve.lag, duration, decay)
    direction, hold, held = state.direction, curve.hold, state.held
    if direction == 0.0:
        direction = 1.0 if start + end > 0.0 else (-1.0 if start + end < 0.0 else 0.0)
    if start == 0.0 and end == 0.0:
        _slide(hypothesis, state, curve, 0.0, 0.0, 0.0, duration, psi)  # what slid fades, what is bent stays
        psi[STICTION] += held * duration
    else:
        state.lagged[LAGGED_STICTION] += held
        held = 0.0
        turn = 1.0  # fraction of the period before friction turns
        if direction * end < -hold:
            turn = 0.0
            if direction * start > -hold:
                turn = (start + direction * hold) / (start - end)
        edge = start + turn * (end - start)
        if turn * duration > 0.0:  # the product may underflow
            _slide(hypothesis, state, curve, direction, start, edge, turn * duration, psi)
        if turn < 1.0:
            direction = -direction
            _slide(hypothesis, state, curve, direction, edge, end, (1.0 - turn) * duration, psi)
    for i in range(COULOMB, psi.size):
        psi[i] /= duration
    psi[INERTIA], psi[VISCOUS] = (end - start) / duration, speed / duration
    psi[psi.size - 2] += curve.viscous * by_speed / duration
    place = PATHS + hypothesis.distances.size
    sign = psi[COULOMB] + psi[STICTION]
    if hypothesis.directions:
        psi[place], psi[place + 1] = direction * psi[STICTION], abs(psi[VISCOUS])
        place += 2
    _write_over_position(hypothesis, position, sign, load, place, psi)
    place = psi.size - 2 - hypothesis.regressors
    for i in range(hypothesis.regressors):
        psi[place + i] = regressors[i]
    return FrictionState(state.lagged, state.bent, direction, held)


def hold(state: FrictionState, fraction: float) -> FrictionState:
    """Let a joint at rest hold a fraction of its static friction, from -1 to 1; what slid before fades with the lag."""
    for i in range(state.bent.size):
        state.bent[i] = fraction
    return FrictionState(state.lagged, state.bent, state.direction, fraction)


def _write_over_position(
    hypothesis: Hypothesis, position: float, sign: float, load: float, place: int, psi: MutableArray
) -> None:
    """Write the columns that depend on position and load; they are zero where it is not known."""
    if math.isfinite(position):
        q = position / hypothesis.gear_ratio
        for i in range(hypothesis.waves.size):
            angle = hypothesis.waves[i] * q
            psi[place + 2 * i], psi[place + 2 * i + 1] = math.sin(angle), math.cos(angle)
        for i in range(hypothesis.map_waves.size):
            angle, at = hypothesis.map_waves[i] * q, place + 2 * (hypothesis.waves.size + i)
            psi[at], psi[at + 1] = sign * math.sin(angle), sign * math.cos(angle)
        for i in range(hypothesis.hats):
            away = abs(q - hypothesis.lowest - i * hypothesis.spacing) / hypothesis.spacing
            psi[place + 2 * (hypothesis.waves.size + hypothesis.map_waves.size) + i] = sign * max(0.0, 1.0 - away)
    if hypothesis.over_load:
        psi[psi.size - 3 - hypothesis.regressors] = sign * abs(load)


@compiled
def write_along(
    hypothesis: Hypothesis,
    state: FrictionState,
    curve: Curve,
    velocity: Array,
    periods: Array,
    position: Array,
    load: Array,
    regressors: Array,
    columns: Array,
) -> FrictionState:
    """Write the columns of each period of a motion into a row; return the memory after it."""
    for k in range(periods.size):
        state = write_columns(
            hypothesis,
            state,
            curve,
            velocity[k],
            velocity[k + 1],
            periods[k],
            position[k],
            load[k],
            regressors[k],
            columns[k],
        )
    return state


def columns_along(
    hypothesis: Hypothesis,
    curve: Curve,
    velocity: Array,
    period: float | Array,
    position: Array | None = None,
    load: Array | None = None,
) -> Array:
    """Return the mean unit torques between the samples of a motion.

    Parameters
    ----------
    hypothesis, curve : Hypothesis, Curve
        Terms, and what they depend on nonlinearly.
    velocity : ndarray, shape (n + 1,)
        Velocity at the samples, rad/s, linear in between.
    period : float or ndarray, shape (n,)
        Time between the samples, s.
    position : ndarray, shape (n,), optional
        Position in the middle of each period, rad.
    load : ndarray, shape (n,), optional
        Known torque, N m.

    Returns
    -------
    ndarray, shape (n, columns)
        Unit torques, in the order of the table above.
    """
    count = velocity.size - 1
    columns = np.zeros((count, column_count(hypothesis)))
    write_along(
        hypothesis,
        initial_friction_state(hypothesis),
        curve,
        np.ascontiguousarray(velocity, dtype=float),
        np.full(count, period, dtype=float),
        np.full(count, np.nan) if position is None else np.ascontiguousarray(position, dtype=float),
        np.zeros(count) if load is None else np.ascontiguousarray(load, dtype=float),
        np.zeros((count, hypothesis.regressors)),
        columns,
    )
    return columns
