"""Logs of machines: a torque and a motion over time, chosen by name from a file.

A column is named as the file names it. From an array of two dimensions, ``NAME[3]`` picks the fourth series (counted
from zero, as in Python), across whichever side of the array is the shorter one. ``STRUCT.MEMBER`` reaches into structs
of MAT files, groups of HDF5 files and structured arrays. Columns of times and durations become seconds.
"""

import math
import re
import shlex
from collections.abc import Mapping
from contextlib import suppress
from dataclasses import dataclass, field, replace
from itertools import combinations
from pathlib import Path
from types import NoneType
from typing import Any

import numpy as np

from adaptive_ff.errors import InputError, check_kind, checked_path, counted
from adaptive_ff.logs.formats import Content, read_content
from controllers.arrays import NDArray
from controllers.checks import check_numbers

Array = NDArray[np.float64]

PICKED = re.compile(r"\[(\d+)\]\Z")  # which series of an array, at the end of the name of a column
KINDS = {"U": "text", "S": "text", "c": "complex numbers", "m": "months or years, which are no time in seconds"}
KNOWN = "known torque"  # role of the column of a torque that is subtracted


@dataclass(frozen=True, eq=False)
class Log:
    """A recorded motion with the torque that drove it; nothing is repaired, values need not be finite.

    Attributes
    ----------
    name : str
        Where it comes from, for messages.
    time, torque : ndarray, shape (n,)
        Times of the samples, s, and torque (force) of the drive, N m (N).
    position, velocity : ndarray, shape (n,), or None
        Position, rad (m), or velocity, rad/s (m/s); one of them is there.
    extra : dict of ndarray, shape (n,)
        Further series by name, such as a recorded feedforward; under ``KNOWN`` what was taken from the torque.
    columns, factors : dict
        Column of the file by role (``time``, ``torque``, ...), and factor by column, for messages.
    """

    name: str
    time: Array
    torque: Array
    position: Array | None = None
    velocity: Array | None = None
    extra: dict[str, Array] = field(default_factory=dict)
    columns: dict[str, str] = field(default_factory=dict)
    factors: dict[str, float] = field(default_factory=dict)

    def __post_init__(self) -> None:
        """Raise a ValueError for series that are none, or of different lengths."""
        check_kind("extra", self.extra, Mapping, "series by name")
        if self.position is None and self.velocity is None:
            raise ValueError(f"{self.name}: position and velocity are both missing; a log has one of them")
        for role, series in self.series.items():
            if getattr(series, "dtype", np.dtype(object)).kind not in "fiu" or series.ndim != 1:
                raise ValueError(f"{self.name}: {role} must be a one-dimensional array of numbers")
            if series.size != self.time.size:
                raise ValueError(f"{self.name}: {role} has {series.size} samples; it must have {self.time.size}")

    @property
    def series(self) -> dict[str, Array]:
        """All series by role, or by name."""
        motion = {"position": self.position, "velocity": self.velocity}
        there = {role: values for role, values in motion.items() if values is not None}
        return {"time": self.time, "torque": self.torque, **there, **self.extra}

    @property
    def moving(self) -> str:
        """Role of the motion: the position, or the velocity where there is none."""
        return "velocity" if self.position is None else "position"

    @property
    def motion(self) -> Array:
        """The position, or the velocity where there is none."""
        return self.series[self.moving]

    def is_same_record(self, other: "Log") -> bool:
        """Tell whether another log holds the same torque and motion, whatever it is called."""
        pairs = (self.torque, other.torque), (self.motion, other.motion)
        return all(np.array_equal(own, others, equal_nan=True) for own, others in pairs)

    def part(self, chosen: slice | NDArray[np.bool_] | NDArray[np.int64]) -> "Log":
        """Return the log of some of the samples."""
        cut: dict[str, Any] = {role: series[chosen] for role, series in self.series.items() if role not in self.extra}
        return replace(self, **cut, extra={name: series[chosen] for name, series in self.extra.items()})

    def scaling(self, role: str, *factors: str) -> str:
        """Say how to scale a series, or the motion, by one of some factors."""
        role = self.moving if role == "motion" else role
        column = self.columns.get(role)
        if column is None:
            return f"scale the {role} by {' or '.join(factors)}"
        given = f"{self.factors[column]:.9g}*" if column in self.factors else ""
        return "give " + " or ".join(f"--scale {shlex.quote(f'{column}={given}{factor}')}" for factor in factors)


def read_log(
    path: str | Path,
    *,
    torque: str,
    position: str | None = None,
    velocity: str | None = None,
    time: str | None = None,
    period: float | None = None,
    extra: Mapping[str, str] | None = None,
    scale: Mapping[str, float] | None = None,
    known_torque: str | None = None,
) -> Log:
    """Read a log.

    Parameters
    ----------
    path : str or Path
        CSV with a header line (separated by commas, semicolons or tabs), NPZ, MAT, HDF5 (and MAT 7.3; needs h5py),
        Parquet (needs pyarrow) or MCAP (needs mcap, mcap-ros2-support).
    torque : str
        Column of the drive's torque, N m.
    position, velocity : str, optional
        Column of the position (rad) or of the velocity (rad/s): one of them.
    time : str, optional
        Column of the time, s; of times, such as ISO 8601 in text, or of durations.
    period : float, optional
        Constant sample time, s, where there is no column of time.
    extra : mapping of str to str, optional
        Further columns: the name they get in ``Log.extra``, and their column.
    scale : mapping of str to float, optional
        Factor by column, as it is named above, that turns its values into the units given here.
    known_torque : str, optional
        Column of a torque that is known, such as gravity or coupling from a model, N m; it is taken from the drive's.

    Returns
    -------
    Log
        The series, as they are in the file but for the factors.

    Raises
    ------
    InputError
        The file cannot be read, a column is not there (the message lists those that are), series differ in length, or
        an argument is not allowed.
    TypeError
        An argument is of another kind.
    """
    file = checked_path("path", path)
    given = {"torque": torque, "time": time, "position": position, "velocity": velocity, KNOWN: known_torque}
    for argument, mapping in (("extra", extra), ("scale", scale)):
        check_kind(argument, mapping, (Mapping, NoneType), "by name, such as {'NAME': ...}")
    further, factors = dict(extra or {}), dict(scale or {})
    for argument, column in {**given, **{f"extra[{name!r}]": one for name, one in further.items()}}.items():
        kinds = (str, NoneType) if argument in given and argument != "torque" else str
        check_kind("known_torque" if argument == KNOWN else argument, column, kinds, "the name of a column")
    for one, other, needed in (
        (position, velocity, "a position or a velocity must be named"),
        (time, period, "a column of time or a period must be given"),
    ):
        if (one is None) == (other is None):
            raise InputError(f"{file}: {needed}, one of them")
    if period is not None:
        check_numbers(period=period)
        if not (math.isfinite(period) and period > 0.0):
            raise InputError(f"{file}: period = {period:g} s is not allowed: it must be positive")
    columns = {role: column for role, column in given.items() if column is not None}
    for (first, column), (role, other) in combinations(columns.items(), 2):
        if column == other:
            raise InputError(f"{file}: the column {column} is given as {first} and as {role}; each must have its own")
    columns |= {f"extra {name}": column for name, column in further.items()}
    for name, factor in factors.items():
        if name not in columns.values():
            used = ", ".join(dict.fromkeys(columns.values()))
            raise InputError(f"{file}: scale: {name} is no column that is used; these are {used}")
        check_numbers(**{f"scale[{name!r}]": factor})
        if not (math.isfinite(factor) and factor != 0.0):
            raise InputError(f"{file}: scale: {name} = {factor:g} is not allowed: it must be finite and not zero")
    arrays = [PICKED.sub("", column) for column in columns.values()]
    content = read_content(file, dict.fromkeys([*columns.values(), *arrays]))
    series = {role: _series(file, content, column, factors.get(column, 1.0)) for role, column in columns.items()}
    size = series["torque"].size
    for role, values in series.items():
        if values.size != size:
            has = f"{columns[role]} has {counted(values.size, 'sample')}"
            raise InputError(f"{file}: {has}, {torque} has {size}; they must be alike")
    named = {name: series[f"extra {name}"] for name in further}
    clock, driven = series.get("time", (period or 0.0) * np.arange(size, dtype=np.float64)), series["torque"]
    if KNOWN in series:
        named[KNOWN], driven = series[KNOWN], driven - series[KNOWN]
    return Log(str(file), clock, driven, series.get("position"), series.get("velocity"), named, columns, factors)


def check_log(name: str, log: Any) -> None:
    """Raise a TypeError for what is no log, such as the path of one."""
    check_kind(name, log, Log, "a Log: read_log(path, time=..., position=..., torque=...) reads a file")


def _series(file: Path, content: Content, column: str, factor: float) -> Array:
    """Return a column as numbers, scaled; without a copy where that is possible."""
    name, *place = PICKED.split(column)
    wrong = ""
    array: NDArray[Any] = np.empty(0)
    if column in content.arrays:
        array = np.atleast_1d(np.squeeze(content.arrays[column]))
        pick = f"to pick a series of it write {column}[0]" if array.ndim == 2 else "it must have one axis or two"
        wrong = f"{column} has shape {content.shapes[column]}; {pick}" if array.ndim != 1 else ""
    elif name in content.arrays:
        table, chosen = content.arrays[name], int(place[0])
        count = min(table.shape, default=0)
        if table.ndim == 1:
            wrong = f"{name} is a single series: write {name}, not {column}"
        elif table.ndim != 2 or chosen >= count:
            wrong = f"{name} has shape {table.shape}; {column} must count one of its {count} series from 0"
        else:
            array = table[:, chosen] if table.shape[1] == count else table[chosen]
    else:
        wrong = f"there is no column {column}; there are {content.listed()}"
    if array.dtype.kind == "M":  # times, in seconds from the first one
        known = array[~np.isnat(array)]
        array = array - (known[0] if known.size else np.datetime64("NaT"))
    with suppress(TypeError):  # months are not all alike
        array = array / np.timedelta64(1, "s") if array.dtype.kind == "m" else array
    if array.dtype.kind not in "iufb":
        wrong = wrong or f"{column} holds {KINDS.get(array.dtype.kind, str(array.dtype))}; it must hold real numbers"
    if wrong:
        raise InputError(f"{file}: {wrong}")
    values: Array = np.ascontiguousarray(array, dtype=np.float64)
    if values.size and not np.any(np.isfinite(values)):
        raise InputError(f"{file}: {column} holds no finite number")
    return values if factor == 1.0 else values * factor
