"""Rows of a log that have the time of the row before: of a rounded clock, or rows that were written more than once."""

from collections.abc import Iterator
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from adaptive_ff.errors import counted
from adaptive_ff.logs.defects import GAP, runs
from adaptive_ff.logs.log import Array, Log

FEWEST = 0.05
"""Share of such rows from which on a clock may count as rounded; fewer are dropped, which loses next to nothing."""

EVEN = 1.5
"""Ticks within which the times of evenly sampled rows lie about a straight line: one of rounding, and some jitter."""

GOES_ON = 0.5
"""Motion within a tick, over that from tick to tick, from which on the rows of a tick were sampled one after the other.

Rows that were written twice show no motion, or noise of the torque alone.
"""

USUAL = 0.99
"""Share of the steps of the motion that count; the largest may be jumps or wraps."""


def with_clear_clock(log: Log) -> tuple[Log, list[str]]:
    """Return a log in which no row has the time of the row before, and what was done for that, a sentence each.

    Parameters
    ----------
    log : Log
        The log.

    Returns
    -------
    log : Log
        The log with new times, where rows that are evenly sampled have the times of a rounded clock; else without the
        rows whose time is that of the row before. The log itself where there is none.
    said : list of str
        What was done.
    """
    again = np.zeros(log.time.size, dtype=np.bool_)
    again[1:] = (log.time[1:] == log.time[:-1]) & np.isfinite(log.time[1:])
    count = int(np.count_nonzero(again))
    if not count or not np.any(log.time[1:] > log.time[:-1]):  # a clock that stands all along is refused elsewhere
        return log, []
    rebuilt = _even_times(log.time) if count >= FEWEST * again.size and _goes_on(log.motion, again) else None
    if rebuilt is not None:
        times, period = rebuilt
        done = f"the rows look evenly sampled, so their times are rebuilt, {1e3 * period:.4g} ms apart"
        return replace(log, time=times), [f"{_have(count)} the time of the one before, as of a rounded clock; {done}"]
    series = [log.torque, log.position, log.velocity, *log.extra.values()]
    same = again.copy()
    same[1:] &= np.all([values[1:] == values[:-1] for values in series if values is not None], axis=0)
    copies = int(np.count_nonzero(same))
    said = []
    if copies:
        said.append(f"{counted(copies, 'row')} left out: the same as the one before, time included")
    if count > copies:
        said.append(f"{counted(count - copies, 'row')} left out: with the time of the row before, but other values")
    return log.part(~again), said


def _have(count: int) -> str:
    return f"{counted(count, 'row')} {'has' if count == 1 else 'have'}"


def _goes_on(motion: Array, again: NDArray[np.bool_]) -> bool:
    """Tell whether a joint moves between rows of the same time as it does between the others."""
    with np.errstate(invalid="ignore", over="ignore"):
        steps = np.abs(np.diff(motion))
    known = np.isfinite(steps)
    within, between = steps[known & again[1:]], steps[known & ~again[1:]]
    if not (within.size and between.size):
        return False
    usual = float(np.quantile(steps[known], USUAL))
    with np.errstate(over="ignore"):
        return float(np.mean(np.minimum(within, usual))) > GOES_ON * float(np.mean(np.minimum(between, usual)))


def _even_times(time: Array) -> tuple[Array, float] | None:
    """Return equal steps through the times of a rounded clock, and the step, s; None where rows are not evenly sampled.

    A clock that goes back or leaves a gap is followed from there anew.
    """
    with np.errstate(invalid="ignore", over="ignore"):
        steps = np.diff(time)
    forward = steps[(steps > 0.0) & (steps < np.inf)]
    if not forward.size:
        return None
    tick = float(np.median(forward))
    stretches = list(_stretches(steps, tick))
    if not stretches:
        return None
    longest = max(stretches, key=lambda part: part.stop - part.start)
    # Where the clock ticks, its time is right within a row; between, within a tick, which may be thousands of rows.
    ticks = np.flatnonzero(np.diff(time[longest]) > 0.0) + 1
    if ticks.size < 2:
        return None
    since = time[longest][ticks] - time[longest.start]
    period = float(np.polynomial.polynomial.polyfit(ticks, since, 1)[1])
    times = time.copy()
    for part in stretches:
        line = period * np.arange(part.stop - part.start)
        apart = time[part] - time[part.start] - line
        low, high = float(np.min(apart)), float(np.max(apart))
        if high - low > EVEN * tick:
            return None
        times[part] = time[part.start] + 0.5 * (low + high) + line
    return times, period


def _stretches(steps: Array, tick: float) -> Iterator[slice]:
    """Return where a clock of some steps goes on without a gap, two samples or more."""
    with np.errstate(invalid="ignore"):
        goes_on = (steps >= 0.0) & (steps <= GAP * tick)
    return (slice(start, stop + 1) for start, stop in runs(goes_on))
