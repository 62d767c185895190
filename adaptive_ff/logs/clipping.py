"""Whether a torque is cut off at its largest or smallest value, by the drive's limit or by what recorded it.

Of a torque that is not cut off, next to no row is exactly at an end. One that is given in steps, or switched, is often
at an end, but also at other values, or changes nowhere else.
"""

import numpy as np

from adaptive_ff.logs.defects import runs
from adaptive_ff.logs.log import Array

SHARE = 0.05
"""Share of the rows at either end together from which on a torque is said to be cut off."""

ROWS = 3
"""Rows that it stays there for at least, for these to count."""

OFTEN = 5.0
"""How often a torque must be at an end, over the most frequent of the values between."""

CHANGING = 0.5
"""Share of the rows between the ends in which the torque must differ from the row before."""


def clipped_torque(torque: Array) -> list[str]:
    """Return a sentence where many rows of a torque are exactly at its largest or smallest value."""
    known = torque[np.isfinite(torque)]
    if known.size < ROWS:
        return []
    low, high = float(np.min(known)), float(np.max(known))
    between = (known != low) & (known != high)
    if low == high or not np.any(between[1:]):
        return []
    counts = {end: _stays(known, end) for end in (low, high) if end != 0.0}  # zero is that of a drive that is off
    changes = float(np.mean((known[1:] != known[:-1])[between[1:]]))
    frequent = _most_frequent(known[between])
    ends = {end: count for end, count in counts.items() if count > OFTEN * frequent}
    share = sum(ends.values()) / known.size
    if share < SHARE or changes < CHANGING:
        return []
    shown = " or ".join(f"{end:.4g}" for end in sorted(ends))
    return [
        f"the torque is exactly {shown} in {100.0 * share:.0f} % of the rows: if what records it cuts it off there, "
        "inertia and friction come out wrong; if it is the limit of the drive and the column is what acted, they do not"
    ]


def _stays(values: Array, end: float) -> int:
    """Return the number of rows at an end, in runs that are long enough."""
    return sum(stop - start for start, stop in runs(values == end) if stop - start >= ROWS)


def _most_frequent(values: Array) -> int:
    """Return how often the most frequent value is there; but for zero, of a drive that is off."""
    counts = np.unique(values[values != 0.0], return_counts=True)[1]
    return int(np.max(counts, initial=0))
