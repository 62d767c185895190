"""Columns and factors as they are named on a command line."""

import math
import re
from collections.abc import Mapping, Sequence
from pathlib import Path

from adaptive_ff.errors import InputError
from adaptive_ff.logs.formats import is_text, read_content
from adaptive_ff.logs.text_tables import table_units

USUAL = {
    "time": ("time", "t", "timestamp"),
    "position": ("position", "q"),
    "velocity": ("measured", "velocity", "w"),
    "torque": ("torque", "u", "effort", "current"),
}
"""Names that columns have where none are given; words with capitals, too, as ``Time``. A ``T`` may be a torque."""


def usual_column(path: Path, names: Sequence[str], roles: Sequence[str], ending: str = "") -> tuple[str, str]:
    """Return role and column of the first role (keys of ``USUAL``) that has a column of a usual name.

    ``ending`` is that of the options that name columns, for messages.

    Raises
    ------
    InputError
        No column has a usual name.
    """
    for role in roles:
        for name in USUAL[role]:
            written = [column for column in names if column == name or (len(name) > 1 and column.casefold() == name)]
            if written:
                return role, name if name in written else written[0]
    options = " or ".join(f"--{role}{ending}" for role in roles)
    usual = " or ".join(name for role in roles for name in USUAL[role])
    there = read_content(path, ()).listed(names)
    raise InputError(f"{path}: {options} must name a column, as none is called {usual}; there are {there}")


def column_names(path: Path) -> list[str]:
    """Return the names of all arrays of a file."""
    return list(read_content(path, ()).shapes)


def with_units(path: Path, columns: Mapping[str, str]) -> dict[str, str]:
    """Return names of columns by role, with the units in brackets that a row below the header of a text file gives."""
    units = table_units(path) if is_text(path) else {}
    named = {column: f"{column} [{unit.strip('[](){} ')}]" for column, unit in units.items()}
    return {role: named.get(column, column) for role, column in columns.items()}


def read_scales(texts: Sequence[str]) -> dict[str, float]:
    """Return factors by column, of texts such as ``q=pi/180`` or ``u=-48``: numbers and pi joined by ``*`` and ``/``.

    Raises
    ------
    InputError
        One of them is none, or names a column twice.
    """
    scales: dict[str, float] = {}
    for text in texts:
        name, equals, factor = text.rpartition("=")
        if not (equals and name):
            raise InputError(f"--scale {text} is not allowed: it must be NAME=FACTOR, such as q=pi/180")
        if name in scales:
            raise InputError(f"--scale {text} is not allowed: {name} has a factor already")
        scales[name] = _factor(text, factor)
    return scales


def _factor(text: str, factor: str) -> float:
    value, parts = 1.0, re.split(r"([*/])", factor)
    for operator, operand in zip(["*", *parts[1::2]], parts[::2], strict=True):
        bare = operand.strip()
        try:
            number = {"pi": math.pi, "-pi": -math.pi}.get(bare) or float(bare)
            value = value / number if operator == "/" else value * number
        except (ValueError, ZeroDivisionError):
            value = math.nan
    if not math.isfinite(value) or value == 0.0:
        raise InputError(
            f"--scale {text} is not allowed: the factor must be numbers and pi joined by * and /, finite and not zero"
        )
    return value
