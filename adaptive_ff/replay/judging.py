"""Judging the torques of a replay: in a band, without delay, in parts, with memory that does not grow with the log."""

import math
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from adaptive_ff.logs.derivatives import Array, lowpass
from adaptive_ff.replay.parts import SETTLING

BINS = 20_000
"""Bins that the series of a replay are thinned to."""


class Stretch:
    """Filters rows of a series without delay, part by part, as if all of it were filtered at once.

    Parameters
    ----------
    band : float or None
        Corner, Hz; None for no filter.
    period : float
        Sample time, s.
    """

    def __init__(self, band: float | None, period: float) -> None:
        self._band, self._period = band, period
        self._margin = 0 if band is None else math.ceil(SETTLING / (band * period))
        self._rows, self._given = np.empty((0, 0)), 0

    def feed(self, rows: Array, *, last: bool) -> Array:
        """Take further samples, and return the filtered ones that no later sample changes any more.

        Parameters
        ----------
        rows : ndarray, shape (series, n)
            Further samples.
        last : bool
            Whether they are the last ones: all are returned, and the next ones begin anew.
        """
        kept = np.hstack([self._rows, rows]) if self._rows.size else rows
        stop = kept.shape[1] - (0 if last else self._margin)
        if not last and stop - self._given < self._margin:  # too few yet to be worth filtering
            self._rows = kept
            return kept[:, :0]
        ready = self._filtered(kept)[:, self._given : stop]
        if last:
            self._rows, self._given = np.empty((0, 0)), 0
        else:
            first = max(0, stop - self._margin)
            self._rows, self._given = kept[:, first:].copy(), stop - first
        return ready

    def _filtered(self, rows: Array) -> Array:
        if self._band is None or rows.shape[1] < 2:
            return rows
        return np.array([lowpass(np.ascontiguousarray(row), (self._band,), self._period) for row in rows])


class Left(NamedTuple):
    """Torque left to the feedback, root mean square in the band, N m; not a number where there is no sample.

    Attributes
    ----------
    whole : float
        Over the whole log.
    second_half : float
        Over its second half, which the fixed model has not seen.
    moving : float
        Over the samples at which the reference moves.
    """

    whole: float
    second_half: float
    moving: float


class Judge:
    """Adds up the torque that each feedforward leaves, and keeps its series, thinned.

    Parameters
    ----------
    names : tuple of str
        The feedforwards.
    samples : int
        Number of samples of the log.
    band : float or None
        Band in which is judged, Hz.
    period : float
        Sample time, s.
    """

    def __init__(self, names: tuple[str, ...], samples: int, band: float | None, period: float) -> None:
        self.names = names
        self._half = samples // 2
        self._stretch = Stretch(band, period)
        self._marks: list[tuple[NDArray[np.int64], NDArray[np.bool_]]] = []
        self._squares = np.zeros((len(names), 3))
        self._counts = np.zeros(3, dtype=np.int64)
        self.needed, *self.feedforwards = (Extremes(samples) for _ in range(1 + len(names)))
        self.left = [Extremes(samples) for _ in names]

    def add(
        self, start: int, needed: Array, feedforwards: list[Array], moving: NDArray[np.bool_], *, last: bool
    ) -> None:
        """Take a part of the log.

        Parameters
        ----------
        start : int
            Its first sample.
        needed : ndarray, shape (n,)
            Torque over the period that begins with each sample, N m; samples where it is not a number do not count.
        feedforwards : list of ndarray, shape (n,)
            Feedforward over the same period, N m, in the order of the names.
        moving : ndarray of bool, shape (n,)
            Whether the reference moves.
        last : bool
            Whether the piece ends here.
        """
        rows = np.array([needed, *feedforwards])
        known = np.isfinite(rows).all(axis=0)  # they are so but at the ends of a piece
        self._marks.append((start + np.flatnonzero(known), moving[known]))
        ready = self._stretch.feed(rows[:, known], last=last)
        if ready.shape[1]:
            self._count(ready, *self._taken(ready.shape[1]))

    def _taken(self, count: int) -> tuple[NDArray[np.int64], NDArray[np.bool_]]:
        """Return place and motion of the samples that have come out of the filter."""
        place, moving = (np.concatenate(parts) for parts in zip(*self._marks, strict=True))
        self._marks = [(place[count:], moving[count:])]
        return place[:count], moving[:count]

    def _count(self, ready: Array, place: NDArray[np.int64], moving: NDArray[np.bool_]) -> None:
        self.needed.add(place, ready[0])
        masks = (slice(None), place >= self._half, moving)
        self._counts += [place.size, int(np.count_nonzero(masks[1])), int(np.count_nonzero(moving))]
        for i, given in enumerate(ready[1:]):
            left = ready[0] - given
            self.feedforwards[i].add(place, given)
            self.left[i].add(place, left)
            self._squares[i] += [float(np.sum(left[mask] ** 2)) for mask in masks]

    def result(self) -> dict[str, Left]:
        """Return the torque left by each feedforward."""
        with np.errstate(invalid="ignore"):
            rms = np.sqrt(self._squares / self._counts)
        return {name: Left(*row) for name, row in zip(self.names, rms.tolist(), strict=True)}


class Extremes:
    """Smallest and largest value of a series in each bin of samples.

    Parameters
    ----------
    samples : int
        Number of samples of the log.
    """

    def __init__(self, samples: int) -> None:
        self.width = math.ceil(samples / BINS)
        count = math.ceil(samples / self.width)
        self.low, self.high = np.full(count, np.inf), np.full(count, -np.inf)

    def add(self, place: NDArray[np.int64], values: Array) -> None:
        """Take values at places that ascend."""
        bins = place // self.width
        first = np.flatnonzero(np.diff(bins, prepend=-1))
        self.low[bins[first]] = np.minimum(self.low[bins[first]], np.minimum.reduceat(values, first))
        self.high[bins[first]] = np.maximum(self.high[bins[first]], np.maximum.reduceat(values, first))

    def series(self) -> Array:
        """Return the smallest and the largest values, shape (2, bins); not a number where nothing was added."""
        return np.where(np.isfinite(self.low), [self.low, self.high], np.nan)
