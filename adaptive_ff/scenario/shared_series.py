"""Series that several scenarios fraction, computed once and kept as long as there is room.

A sweep, a matrix and a comparison ask for the same motion several times: where the scenario is checked, where the drive
is sized, where a run begins. What is kept is read-only; who wants to hand it to compiled code takes a copy, for a
read-only array is another type there and everything would be compiled anew.
"""

from collections import OrderedDict
from collections.abc import Callable, Hashable
from threading import Lock

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]

ROOM = 32_000_000
"""Bytes that all series kept may fill; a longer one is computed each time."""


class SharedSeries:
    """Series by key in a room of some bytes; the one that was not asked for longest goes first."""

    def __init__(self, room: int = ROOM) -> None:
        self._room = room
        self._filled = 0
        self._kept: OrderedDict[Hashable, Array] = OrderedDict()
        self._lock = Lock()

    def get(self, key: Hashable, compute: Callable[[], Array]) -> Array:
        """Return the series of a key, read-only, computed where it is not kept."""
        with self._lock:
            if key in self._kept:
                self._kept.move_to_end(key)
                return self._kept[key]
        series = compute()
        series.flags.writeable = False
        if series.nbytes <= self._room:
            with self._lock:
                if key not in self._kept:  # another thread may have been faster
                    self._kept[key] = series
                    self._filled += series.nbytes
                while self._filled > self._room:
                    self._filled -= self._kept.popitem(last=False)[1].nbytes
        return series

    def clear(self) -> None:
        """Keep nothing of what is kept now."""
        with self._lock:
            self._kept.clear()
            self._filled = 0
