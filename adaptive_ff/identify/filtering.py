"""From a piece of a log to the columns of the regression, all in the same band.

The joint's equation is linear, so it holds for filtered signals if every term passes the same filter; the sign of the
velocity is taken first, and then filtered as the torque is. Two zero-phase low-passes in series: the wide one alone
makes the velocity whose sign is taken, both make everything that is regressed, which is then decimated. At both ends
of a piece, where filters and differences know only one side, rows are dropped. It is the method of IDIM (M. Gautier,
"Dynamic identification of robots with power model", ICRA 1997), with the filter of the position on the torque, too.
"""

import math
from collections.abc import Callable, Mapping
from functools import partial
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray
from scipy.interpolate import make_interp_spline

from adaptive_ff.identify.families import LONG_SATURATION, SATURATION, SATURATIONS, STICTION
from adaptive_ff.logs.defects import Piece, runs
from adaptive_ff.logs.derivatives import REACH, Array, differentiate, differentiate_twice, lowpass
from adaptive_ff.logs.log import Log

ROWS_PER_CYCLE = 5.0
"""Rows in a second, over the band: what passes the filters at half that frequency is below -60 dB."""

EDGE = 1.5
"""Cycles of the band that are dropped at either end of a piece."""

SHORTEST = 6.0
"""Cycles of the band that a piece must have."""

JITTER = 0.01
"""Largest deviation of the clock from a uniform one, in steps, up to which it counts as uniform."""

REST_SHARE = 0.005
"""Speed below which the joint counts as resting, over its largest."""

REST_CYCLES = 1.0
"""Cycles of the band for which it must be slower than that, creeping or not."""

STOP_CYCLES, STOP_SIGNS = 0.1, 3
"""The same for a joint that stands for a moment: its measured velocity changes the sign not once but so often.

What sticks at each reversal, for as long as the torque takes to turn, has no sign of velocity there. Taken for a quick
reversal it showed a negative lag and too much stiction: of a joint of ``adaptive-ff new`` 2.61 N m for 2.5, and a
Stribeck velocity of 0.077 for 0.12 rad/s. That is so where friction jumps, with stiction or without. A joint whose
friction rises from standstill on creeps there instead, which tells of its friction: without it a model of half of the
record of the TX40's joint 4 left 0.75 N m for 0.57.
"""

DWELL = 1.5
"""Time for which a joint that reverses is slow, over that of its accelerations on both sides, from which on it stands.

A stop that is too short for the filter to let the sign change more than once still shows so. With such stops taken for
quick reversals, inertia came out 0.6 % too large, with a tenth of that as interval, and friction led by 3 ms.
"""

REST_REACH = 0.75
"""Cycles of the band around a rest that are not regressed: what the filters smear."""

STRIBECK_GRID, SATURATION_GRID = 16, 8
"""Speeds for which the columns of stiction and of saturation are made; between them they are interpolated."""


FINE = 1000.0
"""Rate at which columns that jump are averaged around the samples of a slower log, Hz."""

SMEARED = 0.05
"""Slowest speed at which friction may saturate, over the largest: below, noise around a reversal, which smears the sign
of the velocity, looks the same."""


class Rest(NamedTuple):
    """What counts as rest, and the grids of speeds that go with it.

    Attributes
    ----------
    slowest : float
        Speed below which the joint may rest, rad/s.
    speeds : dict of ndarray, shape (k,)
        Speeds of the bend of stiction and of saturation, rad/s, by term, in geometric order.
    corner : float
        Corner of the wide filter, behind which the sign of the velocity is taken, Hz.
    sticks : bool
        Whether a joint that stands for less than a cycle of the band, as while it reverses, counts as resting.
    dwells : bool
        Whether it counts as standing, too, where it is slow for longer than its accelerations say, or goes on the same
        way. A joint that creeps does the same, so it is set only where no model whose friction rises from standstill
        fits the log better.
    """

    slowest: float
    speeds: dict[str, Array]
    corner: float
    sticks: bool = False
    dwells: bool = False


class Conditioned(NamedTuple):
    """A piece of a log in the band, on a uniform grid of rows; times in s, other units SI.

    Attributes
    ----------
    time, torque, velocity, acceleration : ndarray, shape (n,)
        Filtered; the time is that of the log.
    direction, speed : ndarray, shape (n,)
        Sign and size of the velocity, filtered after the sign was taken.
    bent : dict of ndarray, shape (k, n)
        ``sgn(w) exp(-|w|/Vs)``, ``tanh(w/Vc)``, ``sgn(w) (1 - exp(-|w|/Vc))`` and ``w/(Vc + |w|)``, filtered, for each
        speed of their grid, by term.
    sine, cosine : ndarray, shape (n,), or None
        Sine and cosine of the position; None where the log has a velocity only.
    held : ndarray, shape (n,)
        Torque filtered by the wide filter only, to be read at rest.
    slides, rests : ndarray of bool, shape (n,)
        Rows that are regressed; rows at rest, away from motion.
    period, sample_time : float
        Time between rows, and between the samples of the log, s.
    between : dict of ndarray, shape (n,) or (k, n)
        Of ``coulomb`` (the direction) and of the bent columns, what they are at the samples beyond their mean around
        them, filtered; see :mod:`adaptive_ff.identify.sampled_lag`.
    mapped : dict of ndarray, shape (n,)
        Friction and forces over position and load, by term; see :mod:`adaptive_ff.identify.map_columns`.
    """

    time: Array
    torque: Array
    velocity: Array
    acceleration: Array
    direction: Array
    speed: Array
    bent: dict[str, Array]
    sine: Array | None
    cosine: Array | None
    held: Array
    slides: NDArray[np.bool_]
    rests: NDArray[np.bool_]
    period: float
    sample_time: float
    between: dict[str, Array]
    mapped: Mapping[str, Array] = {}


def shortest_piece(bandwidth: float, period: float) -> int:
    """Return the number of samples that a piece must have for rows to be left of it."""
    return math.ceil(SHORTEST / (bandwidth * period)) + 2 * REACH


def uniform(log: Log, piece: Piece, period: float) -> tuple[Array, Array, Array]:
    """Return time, motion and torque of a piece at equal steps; a jittered clock is undone by cubic splines."""
    part = slice(piece.start, piece.stop)
    time, motion, torque = log.time[part], log.motion[part], log.torque[part]
    start = float(time[0])
    count = round((float(time[-1]) - start) / period) + 1
    grid = start + (float(time[-1]) - start) * np.linspace(0.0, 1.0, count)
    if count == time.size and float(np.max(np.abs(time - grid))) <= JITTER * period:
        return grid, motion, torque
    elapsed = time - start
    return (
        grid,
        make_interp_spline(elapsed, motion, k=3)(grid - start),
        make_interp_spline(elapsed, torque, k=3)(grid - start),
    )


def wide_velocity(motion: Array, corner: float, period: float, *, is_position: bool) -> Array:
    """Return the velocity behind the wide filter alone, whose sign is taken; its corner is in Hz."""
    wide = lowpass(motion - motion[0] if is_position else motion, (corner,), period)
    return differentiate(wide, period) if is_position else wide


def find_rest(velocities: list[Array], corner: float) -> Rest:
    """Return what counts as rest in a log.

    Parameters
    ----------
    velocities : list of ndarray
        Velocities of the pieces behind the wide filter, rad/s.
    corner : float
        Corner of that filter, Hz.
    """
    largest = max(float(np.max(np.abs(velocity))) for velocity in velocities)
    slowest = REST_SHARE * largest
    speeds = {
        STICTION: np.geomspace(2.0 * slowest, 0.5 * largest, STRIBECK_GRID),
        **{shape: np.geomspace(SMEARED * largest, largest, SATURATION_GRID) for shape in SATURATIONS},
    }
    return Rest(slowest, speeds, corner)


def condition(log: Log, piece: Piece, bandwidth: float, period: float, rest: Rest) -> Conditioned:
    """Filter and decimate a piece of a log.

    Parameters
    ----------
    log : Log
        The log.
    piece : Piece
        Piece without a defect, of at least ``shortest_piece`` samples.
    bandwidth : float
        Corner of the filter of the regression, Hz.
    period : float
        Sample time, s.
    rest : Rest
        What counts as rest.

    Returns
    -------
    Conditioned
        Its rows.
    """
    time, motion, torque = uniform(log, piece, period)
    is_position = log.position is not None
    corners = (rest.corner, bandwidth)
    fast = wide_velocity(motion, rest.corner, period, is_position=is_position)
    kept = kept_rows(time.size, bandwidth, period)

    def filtered(values: Array) -> Array:
        return lowpass(values, corners, period)[kept]

    smooth = lowpass(motion - motion[0] if is_position else motion, corners, period)
    sign, speed = np.sign(fast), np.abs(fast)
    resting = _at_rest(
        fast,
        rest.slowest,
        1.0 / (bandwidth * period),
        math.ceil(1.0 / (rest.corner * period)) if rest.dwells else None,
        sticks=rest.sticks,
    )
    reach = math.ceil(REST_REACH / (bandwidth * period))
    return Conditioned(
        time[kept],
        filtered(torque),
        (differentiate(smooth, period) if is_position else smooth)[kept],
        (differentiate_twice(smooth, period) if is_position else differentiate(smooth, period))[kept],
        filtered(sign),
        filtered(speed),
        {
            term: np.array([filtered(bent_friction(term, fast, bend)) for bend in bends.tolist()])
            for term, bends in rest.speeds.items()
        },
        filtered(np.sin(motion)) if is_position else None,
        filtered(np.cos(motion)) if is_position else None,
        lowpass(torque, corners[:1], period)[kept],
        ~_widened(resting, reach)[kept],
        ~_widened(~resting, reach)[kept],
        kept.step * period,
        period,
        _between_samples(fast, rest, period, filtered),
    )


def kept_rows(size: int, bandwidth: float, period: float) -> slice:
    """Return which samples of a piece become rows: not those at its ends, and as many as the band needs."""
    edge = math.ceil(EDGE / (bandwidth * period)) + REACH
    return slice(edge, size - edge, max(1, math.floor(1.0 / (ROWS_PER_CYCLE * bandwidth * period))))


def bent_friction(term: str, velocity: Array, bend: float) -> Array:
    """Return friction that bends at a speed, over its size."""
    relative = velocity / bend
    if term == SATURATION:
        return np.asarray(np.tanh(relative))
    if term == LONG_SATURATION:
        return np.asarray(relative / (1.0 + np.abs(relative)))
    share = np.exp(-np.abs(relative))
    return np.asarray(np.sign(relative) * (share if term == STICTION else 1.0 - share))


def velocity_between(fast: Array, period: float) -> Array | None:
    """Return velocities around each sample, shape (n, times); None for a fast log, which does without."""
    times = math.ceil(FINE * period - 1e-9)
    if times <= 1:
        return None
    place = np.arange(fast.size)
    offsets = (np.arange(times) + 0.5) / times - 0.5
    fine: Array = make_interp_spline(place, fast, k=3)((place[:, np.newaxis] + offsets).ravel())
    return fine.reshape(fast.size, times)


def _between_samples(fast: Array, rest: Rest, period: float, filtered: Callable[[Array], Array]) -> dict[str, Array]:
    """Return what columns that jump are at the samples beyond their mean around them; nothing of a fast log."""
    fine = velocity_between(fast, period)
    if fine is None:
        return {}

    def beyond(shape: Callable[[Array], Array]) -> Array:
        return filtered(shape(fast) - np.mean(shape(fine), axis=1))

    made = {"coulomb": beyond(np.sign)}
    for term, bends in rest.speeds.items():
        made[term] = np.array([beyond(partial(bent_friction, term, bend=bend)) for bend in bends.tolist()])
    return made


def _at_rest(velocity: Array, slowest: float, cycle: float, reach: int | None, *, sticks: bool) -> NDArray[np.bool_]:
    """Return where a joint rests.

    Parameters
    ----------
    velocity : ndarray, shape (n,)
        Its velocity, rad/s.
    slowest : float
        Speed below which it is slow, rad/s.
    cycle : float
        Samples of a cycle of the band.
    reach : int or None
        Samples over which the accelerations beside a reversal are taken; None where those do not count.
    sticks : bool
        Whether it rests where it stands for less than a cycle, too.
    """
    sign, slow = np.sign(velocity), np.abs(velocity) < slowest
    resting = np.zeros_like(slow)
    for start, stop in runs(slow):
        cycles = REST_CYCLES
        turns = sign[start] != sign[stop - 1]
        if sticks and (turns or reach is not None) and np.count_nonzero(np.diff(sign[start:stop])) >= STOP_SIGNS:
            cycles = STOP_CYCLES
        elif sticks and reach is not None and _dwells(velocity, start, stop, slowest, reach):
            cycles = 0.0
        resting[start:stop] = stop - start >= math.ceil(cycles * cycle)
    return resting


def _dwells(velocity: Array, start: int, stop: int, slowest: float, reach: int) -> bool:
    """Tell whether a joint that reverses is slow for longer than its accelerations on both sides say."""
    if start < reach or stop + reach > velocity.size or velocity[start - 1] * velocity[stop] >= 0.0:
        return False
    ends = np.abs(velocity[[start - reach, start, stop - 1, stop - 1 + reach]])
    braking, starting = (ends[0] - ends[1]) / reach, (ends[3] - ends[2]) / reach
    if min(braking, starting) <= 0.0:
        return False
    return bool(stop - 1 - start > DWELL * (slowest / braking + slowest / starting))


def _widened(mask: NDArray[np.bool_], reach: int) -> NDArray[np.bool_]:
    """Return a mask whose runs of true values reach further on both sides."""
    steps = np.zeros(mask.size + 1, dtype=np.int64)
    for start, stop in runs(mask):
        steps[max(0, start - reach)] += 1
        steps[min(mask.size, stop + reach)] -= 1
    return np.cumsum(steps[:-1]) > 0
