"""A log in parts, as the controller of a replay sees it.

A torque is given as its mean over a period, between samples, as the controller's equations need it: with the sample
``k`` and a delay of ``d`` periods after the stamp, that over the period that ends at ``k`` lies at ``k - 1/2 - d``
between the samples. Samples that are measured are joined by straight lines; a command that is held has a delay of half
a period, and its mean is the sample itself.
"""

import math
from collections.abc import Iterator
from typing import NamedTuple

import numpy as np

from adaptive_ff.logs.defects import Piece
from adaptive_ff.logs.derivatives import Array, lowpass
from adaptive_ff.logs.log import Log
from adaptive_ff.replay.settings import ReplaySettings
from adaptive_ff.replay.watching import Seen

PART = 50_000
"""Samples that are worked on at once."""

REFERENCE_VELOCITY, REFERENCE_POSITION, RECORDED = "reference_velocity", "reference_position", "feedforward"
"""Names in ``Log.extra`` of the reference and of the feedforward that the machine itself had."""

SHARP = 1e-6
"""Share of a period within which a time is that of a sample: clocks are rounded."""

SETTLING = 20.0
"""Cycles of a filter's corner after which its start is forgotten (to 1e-20)."""


class Part(NamedTuple):
    """A part of a piece of a log.

    Attributes
    ----------
    start : int
        First sample.
    begins, ends : bool
        Whether it is the first, the last of its piece.
    time : ndarray, shape (n,)
        Time of the log, s.
    seen : Seen
        What the controller sees.
    needed : ndarray, shape (n,)
        Mean torque over the period that begins with the sample, N m; not a number where it is not known.
    recorded : ndarray, shape (n,), or None
        The recorded feedforward over the same period, N m.
    """

    start: int
    begins: bool
    ends: bool
    time: Array
    seen: Seen
    needed: Array
    recorded: Array | None


def split_log(log: Log, pieces: list[Piece], settings: ReplaySettings, band: float, size: int = PART) -> Iterator[Part]:
    """Go through a log in parts.

    Parameters
    ----------
    log : Log
        The log.
    pieces : list of Piece
        Pieces without defect.
    settings : ReplaySettings
        Sample time, delay of the torque and rest of the reference.
    band : float
        Band that the motion is filtered to where it stands for a reference, Hz.
    size : int, optional
        Samples in a part.
    """
    shift = settings.torque_delay / settings.period
    recorded = log.extra.get(RECORDED)
    start_path = settings.start_path if has_reference(log) else math.inf  # what is slow in a motion is noise
    for piece in pieces:
        gone = 0.0
        for start in range(piece.start, piece.stop, size):
            stop = min(start + size, piece.stop)
            torque = mean_torque(log.torque, piece, start, stop + 1, shift)
            before = max(piece.start, start - 1)
            reference = reference_velocity(log, piece, before, stop + 1, settings.period, band)
            paths = paths_gone(reference, settings.period, gone)
            gone = float(paths[stop - 1 - before])
            reference = with_rest(reference, paths[1:], settings.rest_speed, start_path)[start - before :]
            elapsed = np.full(stop - start, settings.period)
            first = max(start, piece.start + 1)
            elapsed[first - start :] = np.diff(log.time[first - 1 : stop])
            position = np.full(stop - start, np.nan) if log.position is None else log.position[start:stop]
            yield Part(
                start,
                start == piece.start,
                stop == piece.stop,
                log.time[start:stop],
                Seen(reference[:-1], reference[1:], log.motion[start:stop], torque[:-1], elapsed, position),
                torque[1:],
                None if recorded is None else mean_torque(recorded, piece, start + 1, stop + 1, shift),
            )


def mean_torque(torque: Array, piece: Piece, start: int, stop: int, shift: float) -> Array:
    """Return the mean torque over the periods that end at samples ``start`` to ``stop - 1``; the shift is in periods.

    It is not a number where it is not in the piece.
    """
    whole = math.floor(start - 0.5 - shift + SHARP)
    rest = max(0.0, start - 0.5 - shift - whole)
    rest = 0.0 if rest < SHARP else rest
    low = max(0, piece.start - whole)
    high = min(stop - start, piece.stop - whole - (1 if rest > 0.0 else 0))
    mean = np.full(stop - start, np.nan)
    if high > low:
        mean[low:high] = (1.0 - rest) * torque[whole + low : whole + high]
        if rest > 0.0:
            mean[low:high] += rest * torque[whole + low + 1 : whole + high + 1]
    return mean


def reference_velocity(log: Log, piece: Piece, start: int, stop: int, period: float, band: float) -> Array:
    """Return the reference velocity at samples ``start`` to ``stop - 1``; not a number beyond the end of the piece.

    A recorded reference position is differentiated by central differences: a reference is known beforehand. Without
    one the measured motion, filtered without delay, stands for it.
    """
    result = np.full(stop - start, np.nan)
    count = min(stop, piece.stop) - start
    if REFERENCE_VELOCITY in log.extra:
        result[:count] = log.extra[REFERENCE_VELOCITY][start : start + count]
        return result
    reach = 1 if REFERENCE_POSITION in log.extra else math.ceil(SETTLING / (band * period)) + 1
    first, last = max(piece.start, start - reach), min(piece.stop, start + count + reach)
    values, time = log.extra.get(REFERENCE_POSITION, log.motion)[first:last], log.time[first:last]
    if REFERENCE_POSITION not in log.extra:
        origin = values[0] if log.position is not None else 0.0
        values = lowpass(values - origin, (band,), period)
    if REFERENCE_POSITION in log.extra or log.position is not None:
        values = np.gradient(values, time)
    result[:count] = values[start - first : start - first + count]
    return result


def has_reference(log: Log) -> bool:
    """Tell whether a log has a reference of its own."""
    return REFERENCE_VELOCITY in log.extra or REFERENCE_POSITION in log.extra


def paths_gone(reference: Array, period: float, gone: float) -> Array:
    """Return how far a reference has gone without reversing or standing still, rad, signed: before it, and after each.

    Parameters
    ----------
    reference : ndarray, shape (n,)
        Reference, rad/s.
    period : float
        Sample time, s.
    gone : float
        How far it had gone before, rad.

    Returns
    -------
    ndarray, shape (n + 1,)
        The given path, and the path after each sample.
    """
    sign = np.sign(np.concatenate([[gone], reference]))
    summed = np.cumsum(np.concatenate([[gone], reference * period]))
    begins = np.concatenate([[False], sign[1:] != sign[:-1]])
    first = np.maximum.accumulate(np.where(begins, np.arange(sign.size), 0))
    before = np.concatenate([[0.0], summed])[first]  # nothing was gone where the given path begins
    paths: Array = summed - before
    return paths


def with_rest(reference: Array, paths: Array, rest_speed: float, start_path: float) -> Array:
    """Return a reference that stands still where it is slow, but for where it starts.

    A machine that comes to rest may then push either way. One that starts needs the torque to break away before it
    moves, so a slow reference that speeds up counts as soon as it has gone so far that the sensor could see it: what it
    does before, perhaps in the other direction, is no motion of the joint.

    Parameters
    ----------
    reference : ndarray, shape (n,)
        Reference, rad/s; the one before the first is taken to be equal.
    paths : ndarray, shape (n,)
        How far it has gone in its direction, see ``paths_gone``, rad.
    rest_speed : float
        Speed below which it rests while it slows down, rad/s.
    start_path : float
        Path from which on it counts as moving while it speeds up, rad.
    """
    speed = np.abs(reference)
    starting = (np.diff(speed, prepend=speed[0]) > 0.0) & (np.abs(paths) >= start_path)
    return np.where((speed < rest_speed) & ~starting, 0.0, reference)


def largest_reference(log: Log, pieces: list[Piece], period: float, band: float) -> float:
    """Return the largest speed of the reference, rad/s."""
    largest = 0.0
    for piece in pieces:
        for start in range(piece.start, piece.stop, PART):
            stop = min(start + PART, piece.stop)
            speeds = np.abs(reference_velocity(log, piece, start, stop, period, band))
            largest = max(largest, float(np.max(speeds)))
    return largest
