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


EVEN = 1.5
"""Rows within which new values that are sampled evenly, by a clock of their own, lie about a straight line."""


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
    is_coarse = float(np.mean(sizes > 1.5 * np.min(sizes))) < USUAL
    if soonest < 2 or usual.size < USUAL * apart.size or is_coarse:
        return None
    every = float(np.mean(usual))
    ends = np.append(places[1:], values.size)
    between = [np.arange(start, end - 0.5 * every, every) for start, end in zip(places, ends, strict=True)]
    rows = np.unique(np.round(np.concatenate(between)).astype(np.int64))
    return Held(rows, every)


def without_held_rows(log: Log) -> tuple[Log, list[str]]:
    """Return a log without the rows in which its motion is held, and what was found, a sentence each."""
    name = "velocity" if log.position is None else "position"
    held = find_held(log.motion)
    if held is not None:
        sentence = f"the {name} changes in one of {held.every:.3g} rows only, as it is sampled more slowly than the log"
        part = log.part(held.rows)
        return replace(part, time=_even_times(log.time, held.rows)), [f"{sentence}; the rows between are left out"]
    held = find_held(log.torque)
    if held is None:
        return log, []
    late = 0.5 * (held.every - 1.0) * float(np.median(np.diff(log.time)))
    return log, [
        f"the torque changes in one of {held.every:.3g} rows only: if the drive does not hold it, it is only read so "
        f"seldom, so that it is late by {1e3 * late:.3g} ms in the mean: give --torque-delay={-late:.3g}"
    ]


def _even_times(time: Array, rows: NDArray[np.int64]) -> Array:
    """Return the times of rows, or those of a clock between the rows where they are as even as one would leave them."""
    place = np.arange(rows.size)
    line = np.polynomial.Polynomial.fit(place, rows, 1)(place)
    if float(np.ptp(rows - line)) > EVEN:
        return time[rows]
    times: Array = np.interp(np.clip(line, 0.0, time.size - 1.0), np.arange(time.size), time)
    return times
