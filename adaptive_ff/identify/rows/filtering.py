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

from adaptive_ff.identify.rows.band import Band, band_of_motion, transferred, uniform, velocity_between, wide_velocity
from adaptive_ff.identify.rows.path_lag import Bending, OverPath
from adaptive_ff.identify.rows.standing import Rest, reversals, widened
from adaptive_ff.identify.terms import JUMPING, bent_friction
from adaptive_ff.logs.defects import Piece
from adaptive_ff.logs.derivatives import REACH, Array, differentiate, differentiate_twice, lowpass
from adaptive_ff.logs.log import Log

REST_REACH = 0.75
"""Cycles of the band around a rest that are not regressed: what the filters smear."""


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
    path_slopes : dict of ndarray, shape (n,) or (k, n)
        Derivatives of the columns that follow over a path by its logarithm, by term; empty where friction jumps.
    bristle_rate : ndarray, shape (n,), or None
        How fast the direction of friction changes that follows over a path, 1/s, filtered; None where it jumps.
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
    path_slopes: Mapping[str, Array] = {}
    bristle_rate: Array | None = None


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
    over = over_path(moved, period, rest.bending)
    direction = np.sign(moved) if over is None else over.at_samples(np.sign)

    def bent(shape: Callable[[Array], Array]) -> dict[str, Array]:
        return {
            term: np.array([shape(bent_along(term, bend, moved, over)) for bend in bends.tolist()])
            for term, bends in rest.speeds.items()
        }

    def at_edges() -> dict[str, Array]:
        straight = {"coulomb": direction, "viscous": fast, "viscous_asymmetry": np.abs(fast)}
        return {name: band.at_edges(column) for name, column in straight.items()} | bent(band.at_edges)

    return Conditioned(
        time[band.kept],
        lowpass(torque, (rest.corner, bandwidth), period)[band.kept],
        *_motion(measured, wide, band, is_position=is_position),
        band.filtered(direction),
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
        _between_samples(rest, band, over),
        reversals(fast, band.stands, rest),
        band.stops,
        at_edges() if band.stops else {},
        path_slopes={} if over is None else _path_slopes(rest, band, over),
        bristle_rate=None if over is None else band.filtered(over.rate()),
    )


def over_path(velocity: Array, period: float, bending: Bending | None) -> OverPath | None:
    """Return what follows over a path along a velocity (rad/s); None where friction jumps."""
    if bending is None:
        return None
    fine = velocity_between(velocity, period)
    if fine is None:
        fine = velocity[:, np.newaxis]
    return OverPath(fine, period / fine.shape[1], bending)


def bent_along(term: str, bend: float, velocity: Array, over: OverPath | None) -> Array:
    """Return friction that bends at a speed; what of it jumps follows over a path where there is one."""
    if over is None or term not in JUMPING:
        return bent_friction(term, velocity, bend)
    return over.at_samples(partial(bent_friction, term, bend=bend))


def _path_slopes(rest: Rest, band: Band, over: OverPath) -> dict[str, Array]:
    """Return the derivatives by the logarithm of the path."""
    made = {"coulomb": band.filtered(over.slope(np.sign))}
    for term in JUMPING:
        slopes = [over.slope(partial(bent_friction, term, bend=bend)) for bend in rest.speeds[term].tolist()]
        made[term] = np.array([band.filtered(slope) for slope in slopes])
    return made


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


def _between_samples(rest: Rest, band: Band, over: OverPath | None) -> dict[str, Array]:
    """Return what columns that jump are at the samples beyond their mean around them; nothing of a fast log."""
    fast = band.velocity
    fine = velocity_between(fast, band.period)
    if fine is None:
        return {}

    def beyond(shape: Callable[[Array], Array], *, jumps: bool) -> Array:
        if over is not None and jumps:
            return band.filtered(over.beyond(shape))
        return band.filtered(shape(fast) - np.mean(shape(fine), axis=1))

    made = {"coulomb": beyond(np.sign, jumps=True)}
    for term, bends in rest.speeds.items():
        shapes = [partial(bent_friction, term, bend=bend) for bend in bends.tolist()]
        made[term] = np.array([beyond(shape, jumps=term in JUMPING) for shape in shapes])
    return made
