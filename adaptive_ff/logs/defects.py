"""The clock of a log, its gaps, and the segments between defects that can be used."""

from collections.abc import Sequence
from itertools import pairwise
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from adaptive_ff.errors import InputError, counted
from adaptive_ff.logs.log import Array, Log

GAP, UNEVEN = 5.5, (0.9, 4.0)
"""A step of the clock longer than this many median steps is a gap; where steps are uneven, one longer than so many
times that which so large a fraction is not longer than."""

BACK_FRACTION = 0.1
"""Fraction of the steps of a clock that go back from which on the samples are not in order."""


class Span(NamedTuple):
    """Samples ``start`` to ``stop - 1`` of a log, without a defect among them."""

    start: int
    stop: int

    @property
    def size(self) -> int:
        """Number of samples."""
        return self.stop - self.start


class Skipped(NamedTuple):
    """What was not used: samples ``start`` to ``stop - 1``, and why."""

    start: int
    stop: int
    reason: str


def steps_of(values: Array) -> Array:
    """Return what a series changes by from sample to sample; nothing is said of values that are none."""
    with np.errstate(invalid="ignore", over="ignore"):
        return np.diff(values)


def forward_steps(time: Array) -> Array:
    """Return the steps of a clock that go forward, s."""
    steps = steps_of(time)
    return np.asarray(steps[(steps > 0.0) & (steps < np.inf)])


def median_step(log: Log) -> float:
    """Return the median step of the clock, s, of those that go forward.

    Raises
    ------
    InputError
        There is one sample only, or the clock does not go forward in nearly all steps that move it.
    """
    if log.time.size < 2:
        raise InputError(f"{log.name}: {counted(log.time.size, 'sample')} cannot be used; there must be 2 at least")
    steps, forward = steps_of(log.time), forward_steps(log.time)
    back = int(np.count_nonzero(steps < 0.0))
    if forward.size == 0 or back > BACK_FRACTION * (back + forward.size):
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
    forward, (fraction, times) = forward_steps(time), UNEVEN
    if not forward.size:
        return 0.0
    return max(GAP * float(np.median(forward)), times * float(np.quantile(forward, fraction)))


def usable_segments(log: Log, shortest: int = 2, jumps: Sequence[Skipped] = ()) -> tuple[list[Span], list[Skipped]]:
    """Cut a log where values are not finite, or the clock stands, jumps back or leaves a gap, and at given places.

    Returns the segments of at least so many samples, and what is skipped, in order; a jump of the clock skips no
    sample, it only cuts, and its entry is empty.

    Raises
    ------
    InputError
        As :func:`median_step`.
    """
    median_step(log)
    finite = np.all([np.isfinite(series) for series in log.series.values()], axis=0)
    steps = steps_of(log.time)
    broken = ~((steps > 0.0) & (steps <= longest_step(log.time)))
    skipped = [Skipped(*run, "values that are no finite numbers") for run in runs(~finite)]
    for place in (np.flatnonzero(broken & finite[1:] & finite[:-1]) + 1).tolist():
        before, after = log.time[place - 1], log.time[place]
        what = "leaves a gap" if after > before else "jumps back" if after < before else "stands still"
        skipped.append(Skipped(place, place, f"the clock {what}, from {before:.6g} s to {after:.6g} s"))
    skipped += [one for one in jumps if not broken[one.start - 1] and finite[one.start - 1 : one.start + 1].all()]
    broken[[one.start - 1 for one in jumps]] = True
    segments: list[Span] = []
    cut = np.flatnonzero(broken) + 1
    for start, stop in runs(finite):
        inside = cut[np.searchsorted(cut, start, side="right") : np.searchsorted(cut, stop)].tolist()
        for begin, end in pairwise([start, *inside, stop]):
            if end - begin >= shortest:
                segments.append(Span(begin, end))
            else:
                reason = f"a segment of {counted(end - begin, 'sample')}; {shortest} are needed"
                skipped.append(Skipped(begin, end, reason))
    return segments, sorted(skipped)


def runs(mask: NDArray[np.bool_]) -> list[tuple[int, int]]:
    """Return start and stop of each run of true values."""
    edges = np.flatnonzero(np.diff(mask.view(np.int8), prepend=np.int8(0), append=np.int8(0)))
    return [(int(start), int(stop)) for start, stop in edges.reshape(-1, 2)]


def bridged(time: Array, mask: NDArray[np.bool_]) -> list[tuple[int, int]]:
    """Return start and stop of the runs of true values that may be left out without a gap of the clock.

    A run at an end of the log leaves no gap, whatever its length.
    """
    most = longest_step(time)
    with np.errstate(invalid="ignore", over="ignore"):
        return [
            (start, stop)
            for start, stop in runs(mask)
            if start == 0 or stop == time.size or 0.0 < time[stop] - time[start - 1] <= most
        ]
