"""What is wrong with a log is mended where it is certain, and said: step by step, each with its own sentences."""

import math
from collections.abc import Callable
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray
from scipy import ndimage

from adaptive_ff.errors import InputError, counted
from adaptive_ff.logs.defects import TUNING, bridged, median_step, runs, steps_of, usual_step
from adaptive_ff.logs.log import Array, Log

Done = tuple[Log, list[str]]
"""A log after a step, and what is said of it."""


def clean(log: Log, *, linear: bool = False) -> Done:
    """Return a log without what no machine does, and what is said of it; the position of a linear axis does not wrap.

    Raises
    ------
    InputError
        The clock does not go forward, or the sample time is a second or more.
    """
    said, written = [], median_step(log)
    for step in STEPS:
        if not (linear and step is without_wraps):
            log, more = step(log)
            said += more
    period = median_step(log)
    if period < TUNING.slowest and min(period, written) < TUNING.slow:
        return log, said
    units = {"milliseconds": "1e-3", "microseconds": "1e-6", "nanoseconds": "1e-9"}
    likely = {unit: one for unit, one in units.items() if TUNING.fastest <= period * float(one) < TUNING.slowest}
    fitting = likely or units
    wrong = f"is the time in {' or '.join(fitting)}? Then {log.scaling('time', *fitting.values())}"
    if period >= TUNING.slowest:
        must = f"it must be less than {TUNING.slowest:g} s"
        raise InputError(f"{log.name}: the sample time is {period:.4g} s; {must}: {wrong}")
    return log, [*said, f"the sample time is {period:.4g} s: {wrong}"]


def with_clear_clock(log: Log) -> Done:
    """Leave out rows with the time of the row before; where they are of a rounded clock, rebuild its times instead."""
    ticks = steps_of(log.time)
    again = np.append(False, ticks == 0.0)
    count = int(again.sum())
    if not count or not np.any(ticks > 0.0):  # a clock that stands all along is refused elsewhere
        return log, []
    rebuilt = _even_clock(log.time) if count >= TUNING.few * again.size and _goes_on(log.motion, again[1:]) else None
    if rebuilt is not None:
        have = f"{counted(count, 'row')} {'has' if count == 1 else 'have'}"
        done = f"the rows look evenly sampled, so their times are rebuilt, {1e3 * rebuilt[1]:.4g} ms apart"
        return replace(log, time=rebuilt[0]), [f"{have} the time of the one before, as of a rounded clock; {done}"]
    same = np.append(False, np.all([series[1:] == series[:-1] for series in log.series.values()], axis=0))
    return left_out(log, again, f"with the time of the row before; {np.sum(again & ~same)} have other values")


def _goes_on(motion: Array, again: NDArray[np.bool_]) -> bool:
    """Tell whether a joint moves within a tick half as far as between ticks; rows written twice show noise alone."""
    moved, within = np.abs(steps_of(motion)), again[np.isfinite(steps_of(motion))]
    moved = moved[np.isfinite(moved)]
    if within.all() or not within.any():
        return False
    moved = np.minimum(moved, np.quantile(moved, 0.99))  # the largest may be jumps or wraps
    return bool(np.mean(moved[within]) > 0.5 * np.mean(moved[~within]))


def _even_clock(time: Array) -> tuple[Array, float] | None:
    """Return even times through those of a rounded clock, and their step, s; None where rows are not evenly sampled.

    A clock that goes back or leaves a gap is followed from there anew.
    """
    steps = steps_of(time)
    tick = float(np.median(steps[(steps > 0.0) & (steps < np.inf)]))
    parts = [slice(start, stop + 1) for start, stop in runs((steps >= 0.0) & (steps <= TUNING.gap * tick))]
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
    if places.size < TUNING.changes or np.median(apart) < 2 or np.mean(sizes > TUNING.counts * np.min(sizes)) < 0.5:
        return 1.0
    return float(np.mean(apart[apart <= 1.5 * np.median(apart)]))


def without_repeated_rows(log: Log) -> Done:
    """Leave out rows that repeat the sample before, as where a log is written faster than the machine answers.

    Where the joint stands, rows stay as far apart as new ones are otherwise, so that there is no gap. A torque that is
    measured in between is averaged, so that its ripple does not fold into the motion.
    """
    every = rows_between(log.motion)
    moved, turned = steps_of(log.motion) != 0.0, steps_of(log.torque) != 0.0
    held = every > 1.0
    places = np.flatnonzero(moved if held else moved | turned) + 1
    if places.size < TUNING.changes:
        return log, []
    every = every if held else float(np.median(np.diff(places)))
    rows = _filled(places, every, log.time.size)
    if not held and rows.size > (1.0 - TUNING.repeated) * log.time.size:
        return log, []
    if held and np.mean(~turned) < 0.5 * np.mean(~moved):  # the torque is measured in between
        width = round(every)
        weights = np.ones(width) if width % 2 else np.array([0.5, *np.ones(width - 1), 0.5])
        log = replace(log, torque=ndimage.convolve1d(log.torque, weights / width, mode="nearest"))
    said = (
        f"the {log.moving if held else 'sample'} changes in one of {every:.3g} rows only, as it is sampled more slowly "
        "than the log; the rows between are left out, and samples are counted without them"
    )
    early = np.polynomial.Polynomial.fit(np.arange(rows.size), rows, 1)(np.arange(rows.size)) - rows
    is_even = np.ptp(early) <= 1.5  # as a clock between the rows would leave them
    time = log.time[rows] + early * float(np.median(np.diff(log.time))) if is_even else log.time[rows]
    return replace(log.part(rows), time=time), [said]


def _filled(places: NDArray[np.int64], usual: float, size: int) -> NDArray[np.int64]:
    """Return rows of new values, and such as far apart as usual where there is none for long."""
    apart = np.diff(places, append=size)
    counts = np.where(apart > 4.0 * usual, np.ceil(apart / usual - 0.5).astype(np.int64), 1)
    further = np.arange(counts.sum()) - np.repeat(np.cumsum(counts) - counts, counts)
    return np.unique(np.round(np.repeat(places, counts) + usual * further).astype(np.int64))


def without_missing_values(log: Log) -> Done:
    """Leave out rows in which a column has no finite number, where few follow each other; longer stretches stay."""
    missing = {_called(log, role): ~np.isfinite(values) for role, values in log.series.items()}
    left = bridged(log.time, np.any(list(missing.values()), axis=0), TUNING.missing)
    numbers = {name: int(np.sum(left & one)) for name, one in missing.items() if np.any(left & one)}
    each = [f"{name}, {counted(number, 'time')}" for name, number in numbers.items()]
    return left_out(log, left, f"no finite number in {' and '.join(each if each[1:] else numbers)}")


def lacking_column(log: Log) -> str:
    """Return a part of a sentence that names the column with fewest finite numbers, if that is what a log lacks."""
    number, name = max((np.count_nonzero(~np.isfinite(one)), _called(log, role)) for role, one in log.series.items())
    if number < 0.1 * log.time.size:
        return ""
    return f": {name} has no finite number in {number} of {counted(log.time.size, 'row')}"


def _called(log: Log, role: str) -> str:
    """Return what a series is called."""
    column, shown = log.columns.get(role, log.columns.get(f"extra {role}")), role.replace("_", " ")
    return f"the {shown}" if column in (None, shown) else f"the column {column} of the {shown}"


def without_wraps(log: Log) -> Done:
    """Undo the wraps of a position by a turn."""
    if log.position is None:
        return log, []
    steps, turn = steps_of(log.position), 2.0 * math.pi
    wraps = np.abs(np.abs(steps) - turn) < TUNING.wrap * turn
    if not np.any(wraps) or usual_step(steps) > TUNING.wrap * turn:
        return log, []  # at such speed a turn in a sample may be motion
    position = log.position.copy()
    position[1:] -= turn * np.cumsum(np.where(wraps, np.sign(steps), 0.0))
    said = f"the position wraps {counted(int(wraps.sum()), 'time')} by a turn; that is undone"
    return replace(log, position=position), [said]


def at_limit(log: Log) -> Done:
    """Say where many rows of a torque are exactly at its largest or smallest value, unless it is a torque in steps."""
    known = log.torque[np.isfinite(log.torque)]
    values, counts = np.unique(known, return_counts=True)
    if values.size < TUNING.changes:
        return log, []
    counts[values == 0.0] = 0  # the drive is off
    frequent = TUNING.often * np.max(counts[1:-1])
    ends = {values[end]: counts[end] for end in (0, -1) if counts[end] > frequent}
    fraction = sum(ends.values()) / known.size
    if fraction < TUNING.at_limit:
        return log, []
    shown = " or ".join(f"{end:.4g}" for end in ends)
    return log, [
        f"the torque is exactly {shown} in {100.0 * fraction:.0f} % of the rows: if what records it cuts it off there, "
        "inertia and friction come out wrong; if it is the limit of the drive and the column is what acted, they do not"
    ]


def without_spikes(log: Log) -> Done:
    """Leave out the rows in which a series is far off for a few rows; none where the clock would leave a gap."""
    said: list[str] = []
    for role in [role for role in ("position", "velocity", "torque") if role in log.series]:
        left = bridged(log.time, _is_off(log, role), TUNING.spike)
        if left.any():
            first = int(np.argmax(left))
            where = f"first at {log.time[first]:.6g} s, where it is {log.series[role][first]:.3g}"
            why = f"the {role} is far off there, and back within {TUNING.spike} rows, {where}"
            log, more = left_out(log, left, why)
            said += more
    return log, said


def _is_off(log: Log, role: str) -> NDArray[np.bool_]:
    """Tell which rows are outliers of the Hampel filter (R. K. Pearson, IEEE Trans. Control Syst. Technol. 10, 2002).

    They are far from the median of the rows around, over the median of these distances and the usual step; so noise,
    few counts, slopes and jumps that stay are none. A torque or a velocity may really come and go within a few rows: of
    these only what is far outside the range of all others counts, and of torques only what the joint did not feel.
    """
    values, width = log.series[role], 2 * TUNING.spike + 1
    known, moved = np.isfinite(values), np.abs(steps_of(values))
    moved = moved[(moved > 0.0) & (moved < np.inf)]  # a joint may rest for most of a log
    if not moved.size:
        return ~known & known
    limit = TUNING.far * float(np.quantile(moved, TUNING.usual))
    if role != "position":
        ends = np.quantile(values[known], (TUNING.rarest, 1.0 - TUNING.rarest))
        limit = max(limit, TUNING.outside * float(np.ptp(ends)))
    with np.errstate(invalid="ignore", over="ignore"):
        away = np.where(known, np.abs(values - ndimage.median_filter(values, width)), 0.0)
    off = np.asarray(away > np.maximum(limit, TUNING.far * ndimage.median_filter(away, width)))
    return off & ~_is_felt(log) if role == "torque" and off.any() else off


def _is_felt(log: Log) -> NDArray[np.bool_]:
    """Tell where the velocity changes by more than anywhere else, as an impulse of the torque changes it."""
    velocity = log.motion if log.position is None else np.diff(log.motion, append=log.motion[-1])
    rows = TUNING.averaged
    before, behind = rows // 2 + 1, rows // 2 + 1 + TUNING.spike
    mean = np.convolve(velocity, np.full(rows, 1.0 / rows), mode="same")
    padded = np.pad(mean, (before, behind), mode="edge")
    changes = np.abs(padded[before + behind :] - padded[: -before - behind])
    known = changes[np.isfinite(changes)]
    return np.asarray(changes > TUNING.felt * np.quantile(known, 0.9)) if known.size else changes > np.inf


def left_out(log: Log, rows: NDArray[np.bool_], why: str) -> Done:
    """Return a log without some rows, and their number with the reason; nothing if there are none."""
    count = int(rows.sum())
    return (log.part(~rows), [f"{counted(count, 'row')} left out: {why}"]) if count else (log, [])


STEPS: tuple[Callable[[Log], Done], ...] = (
    with_clear_clock,
    without_repeated_rows,
    without_missing_values,
    without_wraps,
    without_spikes,
    at_limit,
)
"""Steps in order."""
