"""What is wrong with a log is mended where it is certain, and said: one table of steps, each with its own sentence."""

import math
from collections.abc import Callable
from dataclasses import replace
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from adaptive_ff.errors import InputError, counted
from adaptive_ff.logs.defects import GAP, Skipped, bridged, longest_step, median_step, runs, steps_of
from adaptive_ff.logs.log import Array, Log
from adaptive_ff.logs.spikes import without_spikes

SLOWEST, FASTEST = 1.0, 1e-5
"""Sample times, s: from the first on the clock does not count seconds; a shorter one than the second no joint's has."""

FEW = 0.05
"""Fraction of rows with the time of the row before from which on a clock may be rounded; fewer are dropped."""

REPEATED, CHANGES = 0.3, 50
"""Fraction of rows that repeat the row before, and fewest changes, from which on a series is sampled more slowly."""

COUNTS = 2.5
"""Change of a coarse encoder over its smallest one, up to which it is a count, as a file rounds it."""

MISSING = 4
"""Most rows without a value one after the other that are left out; more cut the log."""

RATE = 50
"""Steps of the clock, one after the other, that leave gaps: another sample rate."""

WRAP, JUMP = 0.05, 20.0
"""Relative difference from a turn up to which a step is a wrap; step over nearly all others that is a jump."""

AT_LIMIT, OFTEN, CHANGING = 0.05, 5.0, 0.5
"""Fraction of rows at an end of the torque that make a limit, times the most frequent value between; fraction of the
rows between in which it changes."""

Step = Callable[[Log], tuple[Log, list[str]]]


class Row(NamedTuple):
    """What a step did: its name, the rows that it left out, and a sentence."""

    step: str
    left_out: int
    said: str


class Cleaned(NamedTuple):
    """A log that was cleaned, what each step did, and where its position jumps: there it is to be cut."""

    log: Log
    rows: list[Row]
    jumps: list[Skipped]

    @property
    def said(self) -> list[str]:
        """Sentences of the steps."""
        return [row.said for row in self.rows]


def clean(log: Log, *, linear: bool = False) -> Cleaned:
    """Return a log without what no machine does; the position of a linear axis does not wrap.

    Raises
    ------
    InputError
        The clock does not go forward, or the sample time is a second or more.
    """
    rows = []
    for name, step in STEPS.items():
        if name == "wraps" and linear:
            continue
        before = log.time.size
        log, said = step(log)
        rows += [Row(name, before - log.time.size, sentence) for sentence in said]
    period = median_step(log)
    if period >= SLOWEST:
        units = {"milliseconds": "1e-3", "microseconds": "1e-6", "nanoseconds": "1e-9"}
        fitting = {unit: factor for unit, factor in units.items() if FASTEST <= period * float(factor) < SLOWEST}
        fitting = fitting or units
        raise InputError(
            f"{log.name}: the sample time is {period:.4g} s; it must be less than {SLOWEST:g} s: "
            f"is the time in {' or '.join(fitting)}? Then {log.scaling('time', *fitting.values())}"
        )
    pauses = find_pauses(log.time)
    jumps = [] if log.position is None else [one for one in find_jumps(log.position) if one.start not in pauses]
    if jumps:
        rows.append(Row("jumps", 0, f"the position jumps {_times(len(jumps))} within one sample; the log is cut there"))
    return Cleaned(log, rows, jumps)


def _times(count: int) -> str:
    return "once" if count == 1 else f"{count} times"


def with_clear_clock(log: Log) -> tuple[Log, list[str]]:
    """Leave out rows with the time of the row before; where they are of a rounded clock, rebuild its times instead."""
    ticks = steps_of(log.time)
    again = np.append(False, ticks == 0.0)
    count = int(np.count_nonzero(again))
    if not count or not np.any(ticks > 0.0):  # a clock that stands all along is refused elsewhere
        return log, []
    rebuilt = _even_clock(log.time) if count >= FEW * again.size and _goes_on(log.motion, again) else None
    if rebuilt is not None:
        have = f"{counted(count, 'row')} {'has' if count == 1 else 'have'}"
        done = f"the rows look evenly sampled, so their times are rebuilt, {1e3 * rebuilt[1]:.4g} ms apart"
        return replace(log, time=rebuilt[0]), [f"{have} the time of the one before, as of a rounded clock; {done}"]
    same = again[1:] & np.all([series[1:] == series[:-1] for series in log.series.values()], axis=0)
    copies = int(np.count_nonzero(same))
    other = "with the time of the row before, but other values"
    what = {"the same as the one before, time included": copies, other: count - copies}
    return log.part(~again), [f"{counted(rows, 'row')} left out: {said}" for said, rows in what.items() if rows]


def _goes_on(motion: Array, again: NDArray[np.bool_]) -> bool:
    """Tell whether a joint moves within a tick half as far as between ticks; rows written twice show noise alone."""
    moved = np.abs(steps_of(motion))
    known = np.isfinite(moved)
    within, between = known & again[1:], known & ~again[1:]
    if not within.any() or not between.any():
        return False
    moved = np.minimum(moved, np.quantile(moved[known], 0.99))  # the largest may be jumps or wraps
    return bool(np.mean(moved[within]) > 0.5 * np.mean(moved[between]))


def _even_clock(time: Array) -> tuple[Array, float] | None:
    """Return even times through those of a rounded clock, and their step, s; None where rows are not evenly sampled.

    A clock that goes back or leaves a gap is followed from there anew.
    """
    steps = steps_of(time)
    tick = float(np.median(steps[(steps > 0.0) & (steps < np.inf)]))
    parts = [slice(start, stop + 1) for start, stop in runs((steps >= 0.0) & (steps <= GAP * tick))]
    longest = max(parts, key=lambda part: part.stop - part.start)
    # Where the clock ticks, its time is right within a row; between, within a tick, which may be thousands of rows.
    ticks = np.flatnonzero(np.diff(time[longest]) > 0.0) + 1
    if ticks.size < 2:
        return None
    period = float(np.polynomial.polynomial.polyfit(ticks, time[longest][ticks] - time[longest.start], 1)[1])
    times = time.copy()
    for part in parts:
        line = time[part.start] + period * np.arange(part.stop - part.start)
        apart = time[part] - line
        if float(np.ptp(apart)) > 1.5 * tick:
            return None
        times[part] = line + 0.5 * (np.min(apart) + np.max(apart))
    return times, period


def rows_between(values: Array) -> float:
    """Return the rows from one new value of a series to the next, in the mean of the usual ones; 1 if each is new.

    A coarse encoder repeats its value, too, but then changes by one count; a value that is held changes by more.
    """
    steps = np.abs(steps_of(values))
    places = np.flatnonzero((steps > 0.0) & np.isfinite(steps))
    apart, sizes = np.diff(places), steps[places]
    if places.size < CHANGES or np.median(apart) < 2 or np.mean(sizes > COUNTS * np.min(sizes)) < 0.5:
        return 1.0
    return float(np.mean(apart[apart <= 1.5 * np.median(apart)]))


def without_repeated_rows(log: Log) -> tuple[Log, list[str]]:
    """Leave out rows that repeat the sample before, as where a log is written faster than the machine answers.

    Where the joint stands, rows stay as far apart as new ones are otherwise, so that there is no gap. A torque that is
    measured in between is averaged, so that its ripple does not fold into the motion.
    """
    every, of_torque = rows_between(log.motion), rows_between(log.torque)
    moved, turned = steps_of(log.motion) != 0.0, steps_of(log.torque) != 0.0
    said = []
    if of_torque > 1.5 * every:
        late = 0.5 * (of_torque - 1.0) * float(np.median(np.diff(log.time)))
        said.append(
            f"the torque changes in one of {of_torque:.3g} rows only: if the drive does not hold it, it is only read "
            f"so seldom, so that it is late by {1e3 * late:.3g} ms in the mean: give --torque-delay={-late:.3g}"
        )
    held = every > 1.0
    new = moved if held else moved | turned
    places = np.flatnonzero(new) + 1
    if not held and (new.size == 0 or np.mean(new) > 1.0 - REPEATED or places.size < CHANGES):
        return log, said
    usual = every if held else float(np.median(np.diff(places)))
    apart = np.diff(np.append(places, log.time.size))
    counts = np.where(apart > 4.0 * usual, np.ceil(apart / usual - 0.5).astype(np.int64), 1)
    further = np.arange(counts.sum()) - np.repeat(np.cumsum(counts) - counts, counts)
    rows = np.unique(np.round(np.repeat(places, counts) + usual * further).astype(np.int64))
    if held:
        if np.mean(~turned) < 0.5 * np.mean(~moved):  # the torque is measured in between
            width = round(every)
            weights = np.ones(width) if width % 2 else np.array([0.5, *np.ones(width - 1), 0.5])
            padded = np.pad(log.torque, weights.size // 2, mode="edge")
            log = replace(log, torque=np.convolve(padded, weights / width, mode="valid"))
        said.append(
            f"the {log.moving} changes in one of {every:.3g} rows only, as it is sampled more slowly than the log; the "
            "rows between are left out, and samples are counted without them"
        )
        return replace(log.part(rows), time=_even_times(log.time, rows)), said
    if rows.size > (1.0 - 0.5 * REPEATED) * log.time.size:
        return log, said
    comes = f"it comes every {1e3 * float(np.median(np.diff(log.time[rows]))):.4g} ms"
    said.append(f"{log.time.size - rows.size} rows left out: they repeat the sample before; {comes}")
    return log.part(rows), said


def _even_times(time: Array, rows: NDArray[np.int64]) -> Array:
    """Return the times of rows, or those of a clock between the rows where they are as even as one would leave them."""
    place = np.arange(rows.size)
    line = np.polynomial.Polynomial.fit(place, rows, 1)(place)
    if float(np.ptp(rows - line)) > 1.5:
        return time[rows]
    place = np.clip(line, 0.0, time.size - 1.0)
    before = np.minimum(place.astype(np.int64), time.size - 2)
    pauses = time[before + 1] - time[before] > 2.0 * float(np.median(np.diff(time)))
    return np.where(pauses, time[rows], np.interp(place, np.arange(time.size), time))


def find_pauses(time: Array) -> NDArray[np.int64]:
    """Return the samples before which a clock leaves a gap."""
    steps = steps_of(time)
    return np.flatnonzero((steps > longest_step(time)) & (steps < np.inf)) + 1


def without_gaps(log: Log) -> tuple[Log, list[str]]:
    """Say where the recording pauses; leave out stretches that are so slow that each of their steps is a gap."""
    said, is_pause, left = [], np.zeros(log.time.size, dtype=np.bool_), np.zeros(log.time.size, dtype=np.bool_)
    is_pause[find_pauses(log.time)] = True
    slow = [(start, stop) for start, stop in runs(is_pause) if stop - start >= RATE]
    for start, stop in slow:
        left[start : stop - (stop < log.time.size)] = True
        is_pause[start:stop] = False
    if slow:
        start, stop = slow[0]
        often = "" if len(slow) == 1 else f" in {len(slow)} stretches, the first"
        slower = 1e3 * float(np.median(np.diff(log.time[start - 1 : stop])))
        said.append(
            f"{counted(int(left.sum()), 'row')} left out: the sample time changes{often} to {slower:.4g} ms instead of "
            f"{1e3 * median_step(log):.4g} ms at {log.time[start - 1]:.6g} s; identify such a part as a log of its own"
        )
    pauses = np.flatnonzero(is_pause)
    if pauses.size:
        lengths = log.time[pauses] - log.time[pauses - 1]
        longest = int(np.argmax(lengths))
        often = _times(pauses.size) + ("" if pauses.size == 1 else ", the longest")
        begin = log.time[pauses[longest] - 1]
        said.append(
            f"the recording pauses {often} for {lengths[longest]:.3g} s after {begin:.6g} s; the log is cut there"
        )
    return (log.part(~left) if slow else log), said


def without_missing_values(log: Log) -> tuple[Log, list[str]]:
    """Leave out rows in which a column has no finite number, where few follow each other; longer stretches stay."""
    missing = {_called(log, role): ~np.isfinite(values) for role, values in log.series.items()}
    left = np.zeros(log.time.size, dtype=np.bool_)
    for start, stop in bridged(log.time, np.any(list(missing.values()), axis=0)):
        left[start:stop] = stop - start <= MISSING
    if not left.any():
        return log, []
    numbers = {name: int(np.count_nonzero(left & lacking)) for name, lacking in missing.items()}
    lacking = [f"{name}, {counted(number, 'time')}" for name, number in numbers.items() if number]
    columns = lacking[0].rpartition(",")[0] if len(lacking) == 1 else " and ".join(lacking)
    return log.part(~left), [f"{counted(int(left.sum()), 'row')} left out: no finite number in {columns}"]


def lacking_column(log: Log) -> str:
    """Return a part of a sentence that names the column with fewest finite numbers, if that is what a log lacks."""
    number, name = max((np.count_nonzero(~np.isfinite(one)), _called(log, role)) for role, one in log.series.items())
    if number < 0.1 * log.time.size:
        return ""
    return f": {name} has no finite number in {number} of {counted(log.time.size, 'row')}"


def _called(log: Log, role: str) -> str:
    """Return what a series is called."""
    column, shown = log.columns.get(role, log.columns.get(f"extra {role}")), role.replace("_", " ")
    return f"the {shown}" if column is None else f"the column {column} of the {shown}"


def without_wraps(log: Log) -> tuple[Log, list[str]]:
    """Undo the wraps of a position by a turn."""
    if log.position is None:
        return log, []
    steps, turn = steps_of(log.position), 2.0 * math.pi
    wraps = np.abs(np.abs(steps) - turn) < WRAP * turn
    if not np.any(wraps) or _usual_step(steps) > WRAP * turn:
        return log, []  # at such speed a turn in a sample may be motion
    position = log.position.copy()
    position[1:] -= turn * np.cumsum(np.where(wraps, np.sign(steps), 0.0))
    said = f"the position wraps {_times(int(np.count_nonzero(wraps)))} by a turn; that is undone"
    return replace(log, position=position), [said]


def find_jumps(position: Array) -> list[Skipped]:
    """Return the places before which a position jumps within one sample; of a jump there and back, both."""
    steps = steps_of(position)
    usual = _usual_step(steps)
    if steps.size < 3 or not usual:
        return []
    large = runs(np.abs(steps) > JUMP * usual)
    places = [place for start, stop in large if stop - start <= 2 for place in range(start, stop)]
    return [Skipped(place + 1, place + 1, f"the position jumps by {steps[place]:.3g}") for place in places]


def _usual_step(steps: Array) -> float:
    """Return the step that nearly no other exceeds."""
    known = np.abs(steps[np.isfinite(steps)])
    return float(np.quantile(known, 0.99)) if known.size else 0.0


def at_limit(log: Log) -> tuple[Log, list[str]]:
    """Say where many rows of a torque are exactly at its largest or smallest value, unless it is a torque in steps."""
    known = log.torque[np.isfinite(log.torque)]
    low, high = np.min(known, initial=np.inf), np.max(known, initial=-np.inf)
    between = (known != low) & (known != high)
    if not np.any(between[1:]):
        return log, []
    frequent = np.max(np.unique(known[between & (known != 0.0)], return_counts=True)[1], initial=0)
    stays = {end: sum(b - a for a, b in runs(known == end) if b - a >= 3) for end in (low, high) if end != 0.0}
    ends = {end: count for end, count in stays.items() if count > OFTEN * frequent}
    fraction = sum(ends.values()) / known.size
    if fraction < AT_LIMIT or np.mean((known[1:] != known[:-1])[between[1:]]) < CHANGING:
        return log, []
    shown = " or ".join(f"{end:.4g}" for end in sorted(ends))
    return log, [
        f"the torque is exactly {shown} in {100.0 * fraction:.0f} % of the rows: if what records it cuts it off there, "
        "inertia and friction come out wrong; if it is the limit of the drive and the column is what acted, they do not"
    ]


STEPS: dict[str, Step] = {
    "duplicate stamps": with_clear_clock,
    "repeated rows": without_repeated_rows,
    "gaps": without_gaps,
    "missing values": without_missing_values,
    "wraps": without_wraps,
    "spikes": without_spikes,
    "limits": at_limit,
}
"""Steps by name, in order."""
