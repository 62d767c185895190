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
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray
from scipy.interpolate import make_interp_spline

from adaptive_ff.identify.rows.standing import Rest, at_rest, reversals, standing, widened, with_signs_of_motion
from adaptive_ff.identify.terms import bent_friction
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

REST_REACH = 0.75
"""Cycles of the band around a rest that are not regressed: what the filters smear."""

FINE = 1000.0
"""Rate at which columns that jump are averaged around the samples of a slower log, Hz."""


class Conditioned(NamedTuple):
    """A piece of a log in the band, on a uniform grid of rows; times in s, other units SI.

    Attributes
    ----------
    time, torque, velocity, acceleration : ndarray, shape (n,)
        Filtered; the time is that of the log.
    direction, speed : ndarray, shape (n,)
        Sign and size of the velocity, filtered after the sign was taken.
    bent : dict of ndarray, shape (k, n)
        ``sgn(w) exp(-|w|/Vs)``, ``sgn(w) exp(-(w/Vs)^2)``, ``tanh(w/Vc)``, ``sgn(w) (1 - exp(-|w|/Vc))`` and
        ``w/(Vc + |w|)``, filtered, for each speed of their grid, by term.
    moves : ndarray, shape (n,)
        One where the joint moves, filtered; so are the columns above and below, but not ``torque``.
    sine, cosine : ndarray, shape (n,), or None
        Sine and cosine of the position; None where the log has a velocity only.
    moving_torque : ndarray, shape (n,)
        Torque while the joint moves.
    held : ndarray, shape (n,)
        Torque filtered by the wide filter only, to be read at rest.
    position : ndarray, shape (n,), or None
        Position filtered by the wide filter only, rad.
    slides, rests : ndarray of bool, shape (n,)
        Rows that are regressed; rows at rest, away from motion.
    period, sample_time : float
        Time between rows, and between the samples of the log, s.
    between : dict of ndarray, shape (n,) or (k, n)
        Of ``coulomb`` (the direction) and of the bent columns, what they are at the samples beyond their mean around
        them, filtered; see :mod:`adaptive_ff.identify.rows.sampled_lag`.
    reversals, stops : int
        How often the joint reverses without standing, and how often it stands.
    edges : dict of ndarray, shape (n,) or (k, n)
        Of each column of friction its impulses at the begin less those at the end of each motion; empty where the
        joint never stands. See :mod:`adaptive_ff.identify.rows.regressors`.
    mapped : dict of ndarray, shape (n,)
        Friction and forces over position and load, by term; see :mod:`adaptive_ff.identify.maps.map_columns`.
    """

    time: Array
    torque: Array
    velocity: Array
    acceleration: Array
    direction: Array
    speed: Array
    bent: dict[str, Array]
    moves: Array
    sine: Array | None
    cosine: Array | None
    moving_torque: Array
    held: Array
    position: Array | None
    slides: NDArray[np.bool_]
    rests: NDArray[np.bool_]
    period: float
    sample_time: float
    between: dict[str, Array]
    reversals: int
    stops: int
    edges: dict[str, Array]
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


class Band(NamedTuple):
    """The filters of a piece of a log, for what is regressed: while the joint moves.

    Attributes
    ----------
    corner, bandwidth, period : float
        Corner of the wide filter and of that of the regression, Hz, and sample time, s.
    kept : slice
        Samples that become rows.
    resting : ndarray of bool, shape (n,)
        Where the joint rests.
    stands : ndarray of bool, shape (n,)
        The same with what the wide filter smears.
    stops : int
        How often it stands.
    velocity : ndarray, shape (n,)
        Velocity behind the wide filter, rad/s; next to nothing, with the sign of the motion, where it stands.
    """

    corner: float
    bandwidth: float
    period: float
    kept: slice
    resting: NDArray[np.bool_]
    stands: NDArray[np.bool_]
    stops: int
    velocity: Array

    def filtered(self, values: Array) -> Array:
        """Return a series in the band, of what it is while the joint moves."""
        if self.stops == 0:
            return lowpass(values, (self.corner, self.bandwidth), self.period)[self.kept]
        return self.narrowed(lowpass(values, (self.corner,), self.period))

    def narrowed(self, wide: Array) -> Array:
        """Return the same of a series that has passed the wide filter."""
        moving = wide if self.stops == 0 else np.where(self.stands, 0.0, wide)
        return lowpass(moving, (self.bandwidth,), self.period)[self.kept]

    def at_edges(self, values: Array) -> Array:
        """Return impulses of a series where motions begin, less those where they end, in the band."""
        change = -np.diff(self.stands.astype(np.float64))
        wide = lowpass(values, (self.corner,), self.period)
        edges = np.zeros_like(wide)
        edges[1:] += np.maximum(change, 0.0) * wide[1:]
        edges[:-1] += np.minimum(change, 0.0) * wide[:-1]
        return lowpass(edges / self.period, (self.bandwidth,), self.period)[self.kept]


def band_of_motion(velocity: Array, bandwidth: float, period: float, rest: Rest) -> Band:
    """Return the filters of a piece of a log, from its velocity (rad/s) behind the wide filter."""
    cycle = 1.0 / (bandwidth * period)
    resting = at_rest(
        velocity,
        rest.slowest,
        cycle,
        math.ceil(1.0 / (rest.corner * period)) if rest.dwells else None,
        sticks=rest.sticks,
    )
    stands = standing(resting, velocity, rest, cycle, period)
    moved = with_signs_of_motion(velocity, stands)
    kept = kept_rows(velocity.size, bandwidth, period)
    return Band(
        corner=rest.corner,
        bandwidth=bandwidth,
        period=period,
        kept=kept,
        resting=resting,
        stands=stands,
        stops=len(runs(stands)),
        velocity=moved,
    )


def condition(
    log: Log, piece: Piece, bandwidth: float, period: float, rest: Rest, torque_delay: float = 0.0
) -> Conditioned:
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
    torque_delay : float, optional
        Time after its stamp at which a torque acts, s.

    Returns
    -------
    Conditioned
        Its rows.
    """
    time, motion, torque = uniform(log, piece, period)
    if torque_delay != 0.0:
        torque = transferred(torque, lambda s: np.exp(-torque_delay * s), period)
    is_position = log.position is not None
    measured = motion - motion[0] if is_position else motion
    wide = lowpass(measured, (rest.corner,), period)
    fast = differentiate(wide, period) if is_position else wide
    band = band_of_motion(fast, bandwidth, period, rest)
    moved = band.velocity
    reach = math.ceil(REST_REACH / (bandwidth * period))

    def bent(shape: Callable[[Array], Array]) -> dict[str, Array]:
        return {
            term: np.array([shape(bent_friction(term, moved, bend)) for bend in bends.tolist()])
            for term, bends in rest.speeds.items()
        }

    def at_edges() -> dict[str, Array]:
        straight = {"coulomb": np.sign(moved), "viscous": fast, "viscous_asymmetry": np.abs(fast)}
        return {name: band.at_edges(column) for name, column in straight.items()} | bent(band.at_edges)

    return Conditioned(
        time[band.kept],
        lowpass(torque, (rest.corner, bandwidth), period)[band.kept],
        *_motion(measured, wide, band, is_position=is_position),
        band.filtered(np.sign(moved)),
        band.filtered(np.abs(moved)),
        bent(band.filtered),
        np.ones(time[band.kept].size) if band.stops == 0 else band.narrowed(np.ones_like(fast)),
        band.filtered(np.sin(motion)) if is_position else None,
        band.filtered(np.cos(motion)) if is_position else None,
        band.filtered(torque),
        lowpass(torque, (rest.corner,), period)[band.kept],
        wide[band.kept] + motion[0] if is_position else None,
        ~(widened(band.resting, reach) | band.stands)[band.kept],
        ~widened(~band.resting, reach)[band.kept],
        band.kept.step * period,
        period,
        _between_samples(rest, band),
        reversals(fast, band.stands, rest),
        band.stops,
        at_edges() if band.stops else {},
    )


def moving_torque(log: Log, piece: Piece, bandwidth: float, period: float, rest: Rest, torque_delay: float) -> Array:
    """Return the torque of a piece while the joint moves, in the band, with a delay; see ``condition``.

    It is all of a piece that is regressed and depends on the delay.
    """
    _, motion, torque = uniform(log, piece, period)
    fast = wide_velocity(motion, rest.corner, period, is_position=log.position is not None)
    band = band_of_motion(fast, bandwidth, period, rest)
    return band.filtered(transferred(torque, lambda s: np.exp(-torque_delay * s), period))


def _motion(measured: Array, wide: Array, band: Band, *, is_position: bool) -> tuple[Array, Array]:
    """Return velocity and acceleration in the band, of a motion as it was measured and behind the wide filter."""
    smooth = lowpass(measured, (band.corner, band.bandwidth), band.period) if band.stops == 0 else wide
    first = differentiate(smooth, band.period)
    pair = (first, differentiate_twice(smooth, band.period)) if is_position else (smooth, first)
    if band.stops == 0:
        return pair[0][band.kept], pair[1][band.kept]
    ended = (np.pad(one[REACH:-REACH], REACH, mode="edge") for one in pair)  # there is no difference at the ends
    velocity, acceleration = (band.narrowed(one) for one in ended)
    return velocity, acceleration


def transferred(values: Array, response: Callable[[Any], Any], period: float) -> Array:
    """Apply a transfer function to a series: exact where it is band-limited, and smooth in a lag of either sign.

    The series is continued by its mirror image, so that it does not jump where its end meets its start.
    """
    mirrored = np.concatenate([values, values[::-1]])
    s = 2j * math.pi * np.fft.rfftfreq(mirrored.size, period)
    changed: Array = np.fft.irfft(np.fft.rfft(mirrored) * response(s), mirrored.size)[: values.size]
    return changed


def kept_rows(size: int, bandwidth: float, period: float) -> slice:
    """Return which samples of a piece become rows: not those at its ends, and as many as the band needs."""
    edge = math.ceil(EDGE / (bandwidth * period)) + REACH
    return slice(edge, size - edge, max(1, math.floor(1.0 / (ROWS_PER_CYCLE * bandwidth * period))))


def velocity_between(fast: Array, period: float) -> Array | None:
    """Return velocities around each sample, shape (n, times); None for a fast log, which does without."""
    times = math.ceil(FINE * period - 1e-9)
    if times <= 1:
        return None
    place = np.arange(fast.size)
    offsets = (np.arange(times) + 0.5) / times - 0.5
    fine: Array = make_interp_spline(place, fast, k=3)((place[:, np.newaxis] + offsets).ravel())
    return fine.reshape(fast.size, times)


def _between_samples(rest: Rest, band: Band) -> dict[str, Array]:
    """Return what columns that jump are at the samples beyond their mean around them; nothing of a fast log."""
    fast = band.velocity
    fine = velocity_between(fast, band.period)
    if fine is None:
        return {}

    def beyond(shape: Callable[[Array], Array]) -> Array:
        return band.filtered(shape(fast) - np.mean(shape(fine), axis=1))

    made = {"coulomb": beyond(np.sign)}
    for term, bends in rest.speeds.items():
        made[term] = np.array([beyond(partial(bent_friction, term, bend=bend)) for bend in bends.tolist()])
    return made
