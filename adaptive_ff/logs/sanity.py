"""Whether a log can be what it is taken for: times in seconds, without pauses, a position in radians that never jumps.

What is certain is mended or refused with one line; what is probable is said.
"""

import math
from dataclasses import replace
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from adaptive_ff.errors import InputError
from adaptive_ff.logs.clipping import clipped_torque
from adaptive_ff.logs.clock import with_clear_clock
from adaptive_ff.logs.column_units import foreign_unit, unit_of_other_axis
from adaptive_ff.logs.defects import GAP, Skipped, median_step, runs
from adaptive_ff.logs.held_rows import without_held_rows, without_repeated_rows
from adaptive_ff.logs.log import Array, Log
from adaptive_ff.logs.missing_values import without_missing_values
from adaptive_ff.logs.outliers import without_outliers
from adaptive_ff.logs.sample_rate import with_one_rate

SLOWEST = 1.0
"""Sample time, s, from which the time is taken to be in milliseconds, microseconds or nanoseconds."""

FASTEST = 1e-5
"""Shortest sample time, s, of a log of a joint: 100 kHz, above the rate of current loops."""

FASTEST_JOINT = 100.0
"""Speed, rad/s, from which degrees are suspected."""

WRAP_WITHIN = 0.05
"""Relative difference of a jump from a turn up to which it counts as a wrap."""

JUMP = 20.0
"""A step of the position that is so many times the largest of its neighbours, and of nearly all, is a jump."""


class Sound(NamedTuple):
    """A log that was looked through.

    Attributes
    ----------
    log : Log
        The log, wraps undone, without rows that have the time of the row before, lack a value, hold their motion or
        are far off; see :mod:`adaptive_ff.logs.clock`, :mod:`adaptive_ff.logs.missing_values`,
        :mod:`adaptive_ff.logs.held_rows` and :mod:`adaptive_ff.logs.outliers`.
    said : list of str
        What was done or is probably wrong, a sentence each.
    jumps : list of Skipped
        Where the position jumps: the log is to be cut there; no sample is skipped.
    """

    log: Log
    said: list[str]
    jumps: list[Skipped]


def in_degrees(log: Log, speed: float, *, linear: bool) -> list[str]:
    """Ask whether the motion of a log is in degrees, or in revolutions per minute, if its largest speed (rad/s) is.

    Where the name of its column says another unit, that is asked instead.
    """
    if linear or speed <= FASTEST_JOINT:
        return []
    role = "velocity" if log.position is None else "position"
    column, said, other = log.columns.get(role, ""), None, None
    if column not in log.factors:
        said = foreign_unit(column, role, linear=False)
        other = unit_of_other_axis(column, role, linear=False)
    unit, factors = "degrees", ["pi/180"]
    if said is not None:
        unit, factors = said.name, [said.factor]
    elif log.position is None:
        unit, factors = "degrees, or in revolutions per minute", ["pi/180", "pi/30"]
    advice = f"the axis is linear, and {other} are none of a rotary one" if other else log.scaling("motion", *factors)
    return [f"the joint reaches {speed:.3g} rad/s: is the motion in {other or unit}? Then {advice}"]


def look_through(log: Log, *, linear: bool = False) -> Sound:
    """Look a log through.

    Parameters
    ----------
    log : Log
        The log.
    linear : bool, optional
        Whether it is a linear axis, whose position does not wrap.

    Raises
    ------
    InputError
        The sample time is a second or more.
    """
    log, said = with_clear_clock(log)
    log, repeated = without_repeated_rows(log)
    said += repeated
    log, rates, ends = with_one_rate(log, median_step(log))  # of the clock as it was recorded
    log, missing = without_missing_values(log)
    log, wrapped = _unwrapped(log, linear=linear)
    log, off = without_outliers(log)
    said += clipped_torque(log.torque)  # a torque beyond the limit for a row would hide it
    rows = log.time.size
    log, held = without_held_rows(log)
    if log.time.size < rows:  # a value that was held for several rows is one now
        log, again = without_outliers(log)
        held += again
    said += [*missing, *wrapped, *off, *held]
    step = median_step(log)
    if step >= SLOWEST:
        raise InputError(
            f"{log.name}: the sample time is {step:.4g} s; it must be less than {SLOWEST:g} s: "
            f"{_other_clock(log, step)}"
        )
    pauses = find_pauses(log.time, step)
    paused = pauses[~np.isin(log.time[pauses - 1], ends)]
    said += rates
    if paused.size:
        said.append(_pauses_sentence(log.time, paused))
    jumps: list[Skipped] = []
    if log.position is not None:
        jumps = [jump for jump in find_jumps(log.position) if jump.start not in pauses]
        if jumps:
            said.append(f"the position jumps {_times(len(jumps))} within one sample; the log is cut there")
    return Sound(log, said, jumps)


def _unwrapped(log: Log, *, linear: bool) -> tuple[Log, list[str]]:
    """Return a log whose position does not wrap, and what was done."""
    if log.position is None or linear:
        return log, []
    position, wraps = without_wraps(log.position)
    if not wraps:
        return log, []
    return replace(log, position=position), [f"the position wraps {_times(wraps)} by a turn; that is undone"]


def _other_clock(log: Log, step: float) -> str:
    """Ask for the unit of a clock of some sample time, s, that is too long; of those with which it would not be."""
    units = {"milliseconds": "1e-3", "microseconds": "1e-6", "nanoseconds": "1e-9"}
    fitting = {unit: factor for unit, factor in units.items() if FASTEST <= step * float(factor) < SLOWEST} or units
    return f"is the time in {' or '.join(fitting)}? Then {log.scaling('time', *fitting.values())}"


def _times(count: int) -> str:
    return "once" if count == 1 else f"{count} times"


def find_pauses(time: Array, step: float) -> NDArray[np.int64]:
    """Return the samples before which a clock of some median step, s, leaves a gap."""
    with np.errstate(invalid="ignore", over="ignore"):
        steps = np.diff(time)
        return np.flatnonzero((steps > GAP * step) & (steps < np.inf)) + 1


def _pauses_sentence(time: Array, pauses: NDArray[np.int64]) -> str:
    lengths = time[pauses] - time[pauses - 1]
    longest = int(np.argmax(lengths))
    often = "once" if pauses.size == 1 else f"{pauses.size} times, the longest"
    begin = time[pauses[longest] - 1]
    return f"the recording pauses {often} for {lengths[longest]:.3g} s after {begin:.6g} s; the log is cut there"


def without_wraps(position: Array) -> tuple[Array, int]:
    """Return a position in radians with its wraps by a turn undone, and their number."""
    with np.errstate(invalid="ignore"):
        steps = np.diff(position)
        turn = 2.0 * math.pi
        wraps = np.abs(np.abs(steps) - turn) < WRAP_WITHIN * turn
    usual = _usual_step(steps)
    if not np.any(wraps) or usual > WRAP_WITHIN * turn:
        return position, 0  # at such speed a turn in a sample may be motion
    undone = position.copy()
    undone[1:] -= turn * np.cumsum(np.where(wraps, np.sign(steps), 0.0))
    return undone, int(np.count_nonzero(wraps))


def find_jumps(position: Array) -> list[Skipped]:
    """Return the places before which a position jumps within one sample; of a jump there and back, both."""
    with np.errstate(invalid="ignore"):
        steps = np.abs(np.diff(position))
    if steps.size < 3:
        return []
    usual = _usual_step(steps)
    with np.errstate(invalid="ignore"):
        large = steps > JUMP * usual if usual > 0.0 else np.zeros(steps.size, dtype=np.bool_)
    places = [place + 1 for start, stop in runs(large) if stop - start <= 2 for place in range(start, stop)]
    return [
        Skipped(place, place, f"the position jumps by {float(position[place] - position[place - 1]):.3g}")
        for place in places
    ]


def _usual_step(steps: Array) -> float:
    """Return the step that nearly no other exceeds."""
    known = np.abs(steps[np.isfinite(steps)])
    return float(np.quantile(known, 0.99)) if known.size else 0.0
