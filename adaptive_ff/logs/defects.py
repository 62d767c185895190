"""Defects of a log, and the pieces between them that can be used."""

import math
from collections.abc import Sequence
from itertools import pairwise
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from adaptive_ff.errors import InputError, counted
from adaptive_ff.logs.log import Array, Log

GAP = 5.5
"""A step of the clock longer than this many median steps is a gap: nothing is known of what was between."""


BACK_SHARE = 0.1
"""Share of the steps of a clock that go back from which on the samples are not in order."""

MANY = 1_000_000
"""Samples of a long log that are looked at together."""


class Piece(NamedTuple):
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


def median_step(log: Log) -> float:
    """Return the median step of the clock, s, of those that go forward; of a long log, of a million of them.

    Raises
    ------
    InputError
        There is one sample only, or the clock does not go forward in nearly all steps that move it.
    """
    if log.time.size < 2:
        raise InputError(f"{log.name}: {counted(log.time.size, 'sample')} cannot be used; there must be 2 at least")
    every = max(1, math.ceil(log.time.size / MANY))
    with np.errstate(invalid="ignore", over="ignore"):
        steps = log.time[1::every] - log.time[:-1:every]
        forward = steps[(steps > 0.0) & (steps < np.inf)]
        back = int(np.count_nonzero(steps < 0.0))
    if forward.size == 0 or back > BACK_SHARE * (back + forward.size):
        raise InputError(f"{log.name}: {_first_step_back(log)}; times must increase from sample to sample")
    return float(np.median(forward))


def _first_step_back(log: Log) -> str:
    """Say where the clock first does not go forward."""
    with np.errstate(invalid="ignore", over="ignore"):
        steps = np.diff(log.time)
    wrong = np.flatnonzero(~(steps > 0.0))
    place = int(wrong[0])
    before, after = log.time[place : place + 2]
    return (
        f"the time does not go forward in {wrong.size} of {counted(steps.size, 'step')}, first from {before:.6g} s in "
        f"sample {place} to {after:.6g} s in sample {place + 1}"
    )


def usable_pieces(log: Log, shortest: int = 2, jumps: Sequence[Skipped] = ()) -> tuple[list[Piece], list[Skipped]]:
    """Cut a log where values are not finite, or the clock stands, jumps back or leaves a gap.

    Parameters
    ----------
    log : Log
        The log.
    shortest : int, optional
        Number of samples below which a piece is skipped.
    jumps : sequence of Skipped, optional
        Further places to cut at, before the sample where each starts.

    Returns
    -------
    pieces : list of Piece
        What can be used.
    skipped : list of Skipped
        What cannot, in order; a jump of the clock skips no sample, it only cuts, and its entry is empty.

    Raises
    ------
    InputError
        As :func:`median_step`.
    """
    step = median_step(log)
    finite = np.ones(log.time.size, dtype=np.bool_)
    for series in (log.time, log.torque, log.position, log.velocity, *log.extra.values()):
        if series is not None:
            finite &= np.isfinite(series)
    broken = np.empty(max(0, log.time.size - 1), dtype=np.bool_)
    with np.errstate(invalid="ignore", over="ignore"):
        for start in range(0, broken.size, MANY):  # no second copy of a long clock
            steps = np.diff(log.time[start : start + MANY + 1])
            broken[start : start + MANY] = ~((steps > 0.0) & (steps <= GAP * step))
    skipped = [Skipped(*run, "values that are no finite numbers") for run in runs(~finite)]
    for place in np.flatnonzero(broken & finite[1:] & finite[:-1]) + 1:
        before, after = log.time[place - 1], log.time[place]
        what = "leaves a gap" if after > before else "jumps back" if after < before else "stands still"
        skipped.append(Skipped(int(place), int(place), f"the clock {what}, from {before:.6g} s to {after:.6g} s"))
    for jump in jumps:
        if not broken[jump.start - 1] and finite[jump.start - 1 : jump.start + 1].all():
            skipped.append(jump)
        broken[jump.start - 1] = True
    pieces: list[Piece] = []
    cut = np.flatnonzero(broken) + 1
    for start, stop in runs(finite):
        inside = cut[np.searchsorted(cut, start, side="right") : np.searchsorted(cut, stop)]
        edges = [start, *(int(place) for place in inside), stop]
        for begin, end in pairwise(edges):
            if end - begin >= shortest:
                pieces.append(Piece(begin, end))
            else:
                skipped.append(
                    Skipped(begin, end, f"a piece of {counted(end - begin, 'sample')}; {shortest} are needed")
                )
    return pieces, sorted(skipped)


def runs(mask: NDArray[np.bool_]) -> list[tuple[int, int]]:
    """Return start and stop of each run of true values."""
    edges = np.flatnonzero(np.diff(mask.view(np.int8), prepend=np.int8(0), append=np.int8(0)))
    return [(int(start), int(stop)) for start, stop in edges.reshape(-1, 2)]


def bridged(time: Array, mask: NDArray[np.bool_], step: float) -> list[tuple[int, int]]:
    """Return start and stop of the runs of true values that may be left out without a gap of the clock.

    The clock has some median step, s. A run at an end of the log leaves no gap, whatever its length.
    """
    with np.errstate(invalid="ignore", over="ignore"):
        return [
            (start, stop)
            for start, stop in runs(mask)
            if start == 0 or stop == time.size or 0.0 < time[stop] - time[start - 1] <= GAP * step
        ]


def check_varies(name: str, values: Array, pieces: Sequence[Piece], meaning: str) -> None:
    """Refuse a series that is the same all over.

    Raises
    ------
    InputError
        It is.
    """
    low = min(float(values[start:stop].min()) for start, stop in pieces)
    high = max(float(values[start:stop].max()) for start, stop in pieces)
    if low == high:
        raise InputError(f"{name} is {low + 0.0:g} all over; {meaning}")  # -0 is 0
