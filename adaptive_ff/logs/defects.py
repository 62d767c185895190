"""The clock of a log, its gaps, and the segments between defects that can be used."""

from itertools import pairwise
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from adaptive_ff.errors import InputError, counted
from adaptive_ff.logs.log import Array, Log


class Tuning(NamedTuple):
    """What is taken for a defect, and what for one that is certain enough to be mended."""

    gap: float = 5.5  # step of the clock, in median steps, beyond which it leaves a gap, ...
    uneven: tuple[float, float] = (0.9, 4.0)  # ... or times that which so large a fraction of them does not exceed
    back: float = 0.1  # fraction of steps of the clock that go back from which on samples are not in order
    slow: float = 0.09  # sample time, s, from which on the clock is asked whether it counts seconds, ...
    slowest: float = 1.0  # ... from which on it does not, ...
    fastest: float = 1e-5  # ... and below which no joint's is
    few: float = 0.05  # fraction of rows with the time of the row before from which on a clock may be rounded
    repeated: float = 0.3  # fraction of rows that repeat the row before, ...
    changes: int = 50  # ... and fewest changes, or values, of a series that does not just stand or go in steps
    counts: float = 2.5  # change of a coarse encoder over its smallest one, up to which it is one count
    missing: int = 4  # rows without a value one after the other that are left out; more cut the log
    wrap: float = 0.05  # relative difference from a turn up to which a step is a wrap
    jump: float = 20.0  # step over nearly all others that is a jump
    spike: int = 3  # rows that a spike takes at most
    far: float = 4.0  # distance from the median of the rows around, over the usual one, that is far
    usual: float = 0.95  # fraction of steps that are usual
    outside: float = 1.5  # distance of a torque or a velocity over its range, but for ...
    rarest: float = 0.002  # ... this fraction at either end
    averaged: int = 5  # rows over which the velocity is a mean
    felt: float = 3.0  # its change over that which nine of ten other places do not exceed
    at_limit: float = 0.05  # fraction of rows at an end of the torque that make a limit, ...
    often: float = 5.0  # ... and times the most frequent value between


TUNING = Tuning()


class Skipped(NamedTuple):
    """What was not used: samples ``start`` to ``stop - 1``, and why."""

    start: int
    stop: int
    reason: str


def steps_of(values: Array) -> Array:
    """Return what a series changes by from sample to sample; nothing is said of values that are none."""
    with np.errstate(invalid="ignore", over="ignore"):
        return np.diff(values)


def median_step(log: Log) -> float:
    """Return the median step of the clock, s, of those that go forward.

    Raises
    ------
    InputError
        There is one sample only, or the clock does not go forward in nearly all steps that move it.
    """
    if log.time.size < 2:
        raise InputError(f"{log.name}: {counted(log.time.size, 'sample')} cannot be used; there must be 2 at least")
    steps, forward = steps_of(log.time), _forward_steps(log.time)
    back = np.count_nonzero(steps < 0.0)
    if forward.size == 0 or back > TUNING.back * (back + forward.size):
        wrong = np.flatnonzero(~(steps > 0.0))
        place = int(wrong[0])
        raise InputError(
            f"{log.name}: the time does not go forward in {wrong.size} of {counted(steps.size, 'step')}, first from "
            f"{log.time[place]:.6g} s in sample {place} to {log.time[place + 1]:.6g} s in sample {place + 1}; times "
            "must increase from sample to sample"
        )
    return float(np.median(forward))


def longest_step(time: Array) -> float:
    """Return the step of a clock beyond which it leaves a gap, s."""
    forward, (fraction, times) = _forward_steps(time), TUNING.uneven
    if not forward.size:
        return 0.0
    return max(TUNING.gap * float(np.median(forward)), times * float(np.quantile(forward, fraction)))


def usable_segments(log: Log, shortest: int = 2) -> tuple[list[range], list[Skipped]]:
    """Cut a log where values are not finite, the clock stands, jumps back or leaves a gap, and the position jumps.

    Returns the segments of at least so many samples, and what is skipped, in order; a jump of the clock skips no
    sample, it only cuts, and its entry is empty.

    Raises
    ------
    InputError
        As :func:`median_step`.
    """
    median_step(log)
    finite = np.all([np.isfinite(series) for series in log.series.values()], axis=0)
    steps, cuts = steps_of(log.time), find_jumps(log)  # a jump over a gap of the clock is none
    for place in (np.flatnonzero(~((steps > 0.0) & (steps <= longest_step(log.time)))) + 1).tolist():
        before, after = log.time[place - 1], log.time[place]
        what = "leaves a gap" if after > before else "jumps back" if after < before else "stands still"
        cuts[place] = f"the clock {what}, from {before:.6g} s to {after:.6g} s"
    segments: list[range] = []
    edges = {0, *cuts, *(np.flatnonzero(finite[1:] != finite[:-1]) + 1).tolist(), finite.size}
    short = finite.copy()
    for begin, end in pairwise(sorted(edges)):
        if finite[begin] and end - begin >= shortest:
            segments.append(range(begin, end))
            short[begin:end] = False
    reasons = {"values that are no finite numbers": ~finite, f"segments of less than {shortest} samples": short}
    skipped = [Skipped(*run, why) for why, mask in reasons.items() for run in runs(mask)]
    used = finite & ~short
    inner = (place for place in cuts if (used[place - 1] and finite[place]) or (finite[place - 1] and used[place]))
    return segments, sorted([*skipped, *(Skipped(place, place, cuts[place]) for place in inner)])


def runs(mask: NDArray[np.bool_]) -> list[tuple[int, int]]:
    """Return start and stop of each run of true values."""
    edges = np.flatnonzero(np.diff(mask.view(np.int8), prepend=np.int8(0), append=np.int8(0)))
    return [(int(start), int(stop)) for start, stop in edges.reshape(-1, 2)]


def bridged(time: Array, mask: NDArray[np.bool_], widest: int) -> NDArray[np.bool_]:
    """Return the runs of at most so many true values that may be left out without a gap of the clock.

    A run at an end of the log leaves no gap.
    """
    found, most = np.zeros_like(mask), longest_step(time)
    with np.errstate(invalid="ignore", over="ignore"):
        for start, stop in runs(mask):
            is_end = start == 0 or stop == time.size
            found[start:stop] = stop - start <= widest and (is_end or 0.0 < time[stop] - time[start - 1] <= most)
    return found


def find_jumps(log: Log) -> dict[int, str]:
    """Return the samples before which a position jumps within one step, with how far; of one there and back, both."""
    steps = steps_of(log.time[:0] if log.position is None else log.position)
    usual = usual_step(steps)
    if steps.size < 3 or not usual:
        return {}
    large = runs(np.abs(steps) > TUNING.jump * usual)
    places = [place for start, stop in large if stop - start <= 2 for place in range(start + 1, stop + 1)]
    return {place: f"the position jumps by {steps[place - 1]:.3g}" for place in places}


def usual_step(steps: Array) -> float:
    """Return the step that nearly no other exceeds."""
    known = np.abs(steps[np.isfinite(steps)])
    return float(np.quantile(known, 0.99)) if known.size else 0.0


def _forward_steps(time: Array) -> Array:
    steps = steps_of(time)
    return np.asarray(steps[(steps > 0.0) & (steps < np.inf)])
