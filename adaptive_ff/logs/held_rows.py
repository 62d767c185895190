"""Series that are sampled more slowly than the log that they are written to: each value is repeated in some rows.

A position that is held in between is none that a joint can have: its velocity would be a row of pulses. So only rows
with a new value are used. A torque that is held may be just that, or read late.
"""

from dataclasses import replace
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from adaptive_ff.logs.log import Array, Log

FEWEST_CHANGES = 50
"""Changes of a series below which nothing is said of how often it changes."""

USUAL = 0.5
"""Share of the changes that come as soon as any, to a row, from which on a series is sampled at that rate."""

SOONEST = 0.01
"""Share of the changes that may come sooner, by chance."""

COUNTS = 2.5
"""Change of a coarse encoder over its smallest one, up to which it is a count: a count that a file rounds is written as
one or two of its last digits."""

WIDE = 2.0
"""Step of the time over the usual one, from which on a log pauses there."""

EVEN = 1.5
"""Rows within which new values that are sampled evenly, by a clock of their own, lie about a straight line."""


REPEATED = 0.3
"""Share of the rows that repeat the row before in all series, from which on they are taken for no new samples."""


def without_repeated_rows(log: Log) -> tuple[Log, list[str]]:
    """Return a log without rows in which neither motion nor torque is new, and what was done.

    A logger that asks faster than the machine answers writes the same sample several times, in no fixed rhythm. While
    the joint stands, rows stay as far apart as new ones are otherwise, so that there is no gap.
    """
    same = (log.torque[1:] == log.torque[:-1]) & (log.motion[1:] == log.motion[:-1])
    if same.size == 0 or float(np.mean(same)) < REPEATED:
        return log, []
    new = np.unique(np.concatenate([[0], np.flatnonzero(~same) + 1, [same.size]]))
    steps = np.diff(log.time[new])
    if new.size < FEWEST_CHANGES or not np.all(np.isfinite(log.time)) or np.any(np.diff(log.time) <= 0.0):
        return log, []
    usual = float(np.median(steps))
    kept = [new]
    for place in np.flatnonzero(steps > WIDE * usual):
        begin, end = log.time[new[place]], log.time[new[place + 1]]
        between = np.searchsorted(log.time, np.arange(begin + usual, end - 0.5 * usual, usual))
        kept.append(between[(between > new[place]) & (between < new[place + 1])])
    rows = np.unique(np.concatenate(kept))
    if rows.size > (1.0 - 0.5 * REPEATED) * log.time.size:
        return log, []
    left = log.time.size - rows.size
    said = f"{left} rows left out: they repeat the sample before, which comes every {1e3 * usual:.4g} ms"
    return log.part(rows), [said]


class Held(NamedTuple):
    """Rows of a series that is held.

    Attributes
    ----------
    rows : ndarray of int
        Rows with a new value; where it stays the same for longer, rows as far apart.
    every : float
        Rows from one new value to the next, in the mean of the usual ones.
    """

    rows: NDArray[np.int64]
    every: float


def find_held(values: Array) -> Held | None:
    """Return the rows of a series that have a new value, where these come at a slower rate; else None.

    A coarse encoder repeats its value, too, but then changes by one count. So of a series that changes in no two rows
    one after the other, most changes must be larger than the smallest one.
    """
    with np.errstate(invalid="ignore", over="ignore"):
        steps = np.abs(np.diff(values))
    places = np.flatnonzero((steps > 0.0) & np.isfinite(steps)) + 1
    if places.size < FEWEST_CHANGES:
        return None
    apart = np.diff(places)
    soonest = int(np.quantile(apart, SOONEST, method="lower"))
    usual = apart[(apart >= soonest) & (apart <= soonest + 1)]
    sizes = steps[places - 1]
    is_coarse = float(np.mean(sizes > COUNTS * np.min(sizes))) < USUAL
    if soonest < 2 or usual.size < USUAL * apart.size or is_coarse:
        return None
    every = float(np.mean(usual))
    ends = np.append(places[1:], values.size)
    counts = np.maximum(np.ceil((ends - 0.5 * every - places) / every).astype(np.int64), 0)
    before = np.repeat(np.cumsum(counts) - counts, counts)
    rows = np.repeat(places, counts) + every * (np.arange(counts.sum()) - before)
    return Held(np.unique(np.round(rows).astype(np.int64)), every)


def without_held_rows(log: Log) -> tuple[Log, list[str]]:
    """Return a log without the rows in which its motion is held, and what was found, a sentence each."""
    name = "velocity" if log.position is None else "position"
    motion, torque = find_held(log.motion), find_held(log.torque)
    said = []
    if torque is not None and (motion is None or torque.every > EVEN * motion.every):
        late = 0.5 * (torque.every - 1.0) * float(np.median(np.diff(log.time)))
        said.append(
            f"the torque changes in one of {torque.every:.3g} rows only: if the drive does not hold it, it is only "
            f"read so seldom, so that it is late by {1e3 * late:.3g} ms in the mean: give --torque-delay={-late:.3g}"
        )
    if motion is None:
        return log, said
    if torque is None:  # else what is faster than the motion is read would seem to be slow
        log = replace(log, torque=_mean(log.torque, round(motion.every)))
    sentence = f"the {name} changes in one of {motion.every:.3g} rows only, as it is sampled more slowly than the log"
    said.append(f"{sentence}; the rows between are left out, and samples are counted without them")
    return replace(log.part(motion.rows), time=_even_times(log.time, motion.rows)), said


def _mean(values: Array, width: int) -> Array:
    """Return the means over so many samples around each; of an even number, both ends count half."""
    weights = np.ones(width if width % 2 else width + 1)
    if width % 2 == 0:
        weights[[0, -1]] = 0.5
    reach = weights.size // 2
    means: Array = np.convolve(np.pad(values, reach, mode="edge"), weights / weights.sum(), mode="valid")
    return means


def _even_times(time: Array, rows: NDArray[np.int64]) -> Array:
    """Return the times of rows, or those of a clock between the rows where they are as even as one would leave them."""
    place = np.arange(rows.size)
    line = np.polynomial.Polynomial.fit(place, rows, 1)(place)
    if float(np.ptp(rows - line)) > EVEN:
        return time[rows]
    place = np.clip(line, 0.0, time.size - 1.0)
    before = np.minimum(place.astype(np.int64), time.size - 2)
    pauses = time[before + 1] - time[before] > WIDE * float(np.median(np.diff(time)))
    times: Array = np.where(pauses, time[rows], np.interp(place, np.arange(time.size), time))
    return times
