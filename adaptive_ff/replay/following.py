"""How far ahead of its recorded reference a joint moves, or behind it, and the reference as it was followed.

The torque of a log belongs to the motion that was made. Where that runs ahead of the recorded reference by a constant
time (an interpolator behind the record, a drive that is fed too much) or follows it with a constant delay (a position
loop), friction turns where the joint does, not where the recorded reference does, and no feedforward from that
reference can meet it. What a controller knows beforehand is when its plan will be followed, so a replay takes the
reference at that time. It is found from the motion alone; no torque enters.
"""

from dataclasses import replace

import numpy as np
from scipy import signal

from adaptive_ff.errors import sentence
from adaptive_ff.logs.defects import Piece
from adaptive_ff.logs.derivatives import Array, lowpass
from adaptive_ff.logs.log import Log
from adaptive_ff.logs.sanity import in_degrees
from adaptive_ff.replay.fixed import MOST
from adaptive_ff.replay.parts import REFERENCE_POSITION, REFERENCE_VELOCITY, has_reference, reference_velocity
from adaptive_ff.replay.settings import FARTHEST

SAMPLES = 2.0
"""Least time, in sample times. Less may come of what a stamp means, and of how a velocity is made of positions."""

EXPLAINED = 0.5
"""Share of the squared tracking error (of the velocity, but for a constant factor) that the time must explain."""

FOLLOWED = 0.5
"""Share of the squared velocity that the reference must explain, but for a constant factor."""

FOREIGN = 2.0
"""Motion over its reference, or the other way round, from which on they are in different units."""


def motion_lead(log: Log, pieces: list[Piece], period: float, band: float) -> float:
    """Return by how much the measured motion runs ahead of the reference, s; zero where that is not distinct.

    It is the nearest minimum of the squared difference between the measured velocity and the reference at a later time,
    times the factor that fits best: the ratio of a gear may be known to some percent only.

    Parameters
    ----------
    log : Log
        The log.
    pieces : list of Piece
        Its pieces without defect; the longest is used.
    period : float
        Sample time, s.
    band : float
        Band that both velocities are filtered to, without delay, Hz.
    """
    if not has_reference(log):
        return 0.0
    piece = _longest(pieces)
    plan, motion = _plan(log, piece, period, band), _motion(log, piece, period, band)
    reach = min(round(FARTHEST / period), plan.size // 4)
    if reach < 1:
        return 0.0
    samples, explained = nearest_minimum(unlike(plan, motion, reach))
    if abs(samples) < SAMPLES or explained < EXPLAINED:
        return 0.0
    return samples * period


def _longest(pieces: list[Piece]) -> Piece:
    """Return the longest piece, or as many samples of it as are looked at."""
    longest = max(pieces, key=lambda piece: piece.size)
    return Piece(longest.start, min(longest.stop, longest.start + MOST))


def _plan(log: Log, piece: Piece, period: float, band: float) -> Array:
    """Return the reference velocity of a piece in a band (Hz), rad/s."""
    return lowpass(reference_velocity(log, piece, piece.start, piece.stop, period, band), (band,), period)


def _motion(log: Log, piece: Piece, period: float, band: float) -> Array:
    """Return the measured velocity of a piece in a band (Hz), rad/s."""
    part, origin = slice(piece.start, piece.stop), log.motion[piece.start]
    motion = lowpass(log.motion[part] - origin, (band,), period)
    return motion + origin if log.position is None else np.gradient(motion, log.time[part])


def doubts(log: Log, pieces: list[Piece], period: float, band: float, *, linear: bool) -> list[str]:
    """Return a sentence where the motion seems to be in other units, or has little to do with the recorded reference.

    Parameters
    ----------
    log : Log
        The log; its reference as it was followed.
    pieces : list of Piece
        Its pieces without defect; the longest is used.
    period : float
        Sample time, s.
    band : float
        Band that both velocities are filtered to, without delay, Hz.
    linear : bool
        Whether the joint is a linear axis.
    """
    piece = _longest(pieces)
    motion = _motion(log, piece, period, band)
    said = [sentence(words) for words in in_degrees(log, float(np.max(np.abs(motion))), linear=linear)]
    return said + _not_followed(_plan(log, piece, period, band), motion) if has_reference(log) else said


def _not_followed(plan: Array, motion: Array) -> list[str]:
    """Return a sentence where a measured velocity has little to do with a reference (rad/s), or is in other units."""
    along, planned, moved = float(plan @ motion), float(plan @ plan), float(motion @ motion)
    if planned == 0.0 or moved == 0.0:
        return []  # nothing moves in what is compared
    if along**2 < FOLLOWED * planned * moved:
        return [
            f"The joint did not follow the recorded reference, which has {100.0 * along**2 / (planned * moved):.0f} % "
            "of the motion in it: it may be another quantity or of another joint, and what is fed forward from it says "
            "nothing of the machine."
        ]
    times = along / planned
    if 1.0 / FOREIGN < times < FOREIGN:
        return []
    return [
        f"The measured velocity is {times:.3g} times the recorded reference: one of them is in other units, or has the "
        "other sign."
    ]


def unlike(plan: Array, motion: Array, reach: int) -> Array:
    """Return the squares that a plan leaves of a motion when it is taken later by ``-reach`` to ``reach`` samples.

    Of the motion the ends are left out, so that all shifts are compared on the same samples. The plan is scaled to fit.

    Parameters
    ----------
    plan, motion : ndarray, shape (n,)
        Velocities, rad/s.
    reach : int
        Samples.

    Returns
    -------
    ndarray, shape (2 reach + 1,)
        Squares left.
    """
    inner = motion[reach : motion.size - reach]
    products = signal.correlate(plan, inner, mode="valid")
    sums = np.concatenate([[0.0], np.cumsum(plan * plan)])
    squares = sums[inner.size :] - sums[: -inner.size]
    fitted = np.divide(products**2, squares, out=np.zeros_like(products), where=squares > 0.0)
    left: Array = float(inner @ inner) - fitted
    return left


def nearest_minimum(left: Array) -> tuple[float, float]:
    """Return the place of the minimum downhill from the middle, from there, and the share by which it is lower.

    Both are zero where the slope goes on to an end: what follows nothing has no time.
    """
    middle = left.size // 2
    step = 1 if left[middle + 1] < left[middle - 1] else -1
    place = middle
    while 0 < place < left.size - 1 and left[place + step] < left[place]:
        place += step
    if place == middle or not 0 < place < left.size - 1:
        return 0.0, 0.0
    before, least, after = left[place - 1 : place + 2]
    bend = before - 2.0 * least + after
    vertex = 0.5 * (before - after) / bend if bend > 0.0 else 0.0
    return float(place - middle + vertex), float(1.0 - least / left[middle])


def as_followed(log: Log, pieces: list[Piece], lead: float) -> Log:
    """Return a log whose reference is taken later by a time, s.

    Beyond an end of a piece the velocity is that of the end: a reference velocity stays, a reference position goes on.
    A position that stayed would stop at once, and the inertia would be braked by a torque that nobody needs.

    Parameters
    ----------
    log : Log
        The log.
    pieces : list of Piece
        Its pieces without defect.
    lead : float
        Time by which the motion runs ahead of the reference, s.
    """
    if lead == 0.0 or not has_reference(log):
        return log
    name = REFERENCE_VELOCITY if REFERENCE_VELOCITY in log.extra else REFERENCE_POSITION
    followed = log.extra[name].copy()
    for piece in pieces:
        part = slice(piece.start, piece.stop)
        time = log.time[part]
        followed[part] = np.interp(time + lead, time, log.extra[name][part])
        if name == REFERENCE_POSITION:
            followed[part] += beyond(time, log.extra[name][part], lead)
    return replace(log, extra={**log.extra, name: followed})


def beyond(time: Array, position: Array, lead: float) -> Array:
    """Return how far a position that is taken later has gone from the end that it is beyond, with the velocity there.

    Parameters
    ----------
    time : ndarray, shape (n,)
        Time of a piece, s.
    position : ndarray, shape (n,)
        Position, rad.
    lead : float
        Time by which it is taken later, s.

    Returns
    -------
    ndarray, shape (n,)
        Path, rad; zero where the later time is in the piece.
    """
    before, after = np.minimum(time + lead - time[0], 0.0), np.maximum(time + lead - time[-1], 0.0)
    first, last = ((position[k + 1] - position[k]) / (time[k + 1] - time[k]) for k in (0, -2))
    path: Array = first * before + last * after
    return path
