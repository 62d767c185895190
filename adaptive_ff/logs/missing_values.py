"""Rows in which a column has no value: empty cells, words, infinities.

A row without its torque is worth no more than a row that is missing, and a missing row is bridged. So where few such
rows follow each other they are left out; longer stretches stay, and the log is cut there.
"""

from collections.abc import Iterator

import numpy as np
from numpy.typing import NDArray

from adaptive_ff.errors import counted
from adaptive_ff.logs.defects import bridged, median_step
from adaptive_ff.logs.log import Array, Log

LONGEST = 4
"""Most rows without a value one after the other that are left out."""

MANY = 0.1
"""Share of the rows without a value from which on a column may be the reason that nothing of a log can be used."""


def without_missing_values(log: Log) -> tuple[Log, list[str]]:
    """Return a log without the short stretches in which a column has no finite number, and what was left out."""
    missing = _missing(log)
    if not np.any(missing):
        return log, []
    left = np.zeros(log.time.size, dtype=np.bool_)
    for start, stop in bridged(log.time, missing, median_step(log)):
        if stop - start <= LONGEST:
            left[start:stop] = True
    count = int(np.count_nonzero(left))
    if not count:
        return log, []
    numbers = {name: int(np.count_nonzero(left & ~np.isfinite(values))) for name, values in _series(log)}
    lacking = [f"{name}, {counted(number, 'time')}" for name, number in numbers.items() if number]
    columns = lacking[0].rpartition(",")[0] if len(lacking) == 1 else " and ".join(lacking)
    return log.part(~left), [f"{counted(count, 'row')} left out: no finite number in {columns}"]


def lacking_column(log: Log) -> str:
    """Return a part of a sentence that names the column with fewest finite numbers, if that is what a log lacks."""
    counts = [(int(np.count_nonzero(~np.isfinite(values))), name) for name, values in _series(log)]
    number, name = max(counts, key=lambda pair: pair[0])
    if number < MANY * log.time.size:
        return ""
    return f": {name} has no finite number in {number} of {counted(log.time.size, 'row')}"


def _missing(log: Log) -> NDArray[np.bool_]:
    """Return the rows in which a series has no finite number."""
    missing = np.zeros(log.time.size, dtype=np.bool_)
    for _, values in _series(log):
        missing |= ~np.isfinite(values)
    return missing


def _series(log: Log) -> Iterator[tuple[str, Array]]:
    """Return the series of a log with what they are called."""
    roles = {"time": log.time, "torque": log.torque, "position": log.position, "velocity": log.velocity}
    for role, values in roles.items():
        if values is not None:
            yield _called(log, role, role), values
    for name, values in log.extra.items():
        yield _called(log, f"extra {name}" if f"extra {name}" in log.columns else name, name.replace("_", " ")), values


def _called(log: Log, role: str, name: str) -> str:
    column = log.columns.get(role)
    return f"the {name}" if column is None else f"the column {column} of the {name}"
