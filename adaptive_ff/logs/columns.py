"""Columns and factors as they are named on a command line, and what names of columns say of their units.

A name says its unit at its end: ``q_deg``, ``Speed [rpm]``, ``current_mA``.
"""

import math
import re
from collections.abc import Mapping, Sequence
from contextlib import suppress
from pathlib import Path
from typing import NamedTuple

from adaptive_ff.errors import InputError
from adaptive_ff.logs.formats import Content
from adaptive_ff.logs.log import PICKED, Log

USUAL = {
    "time": ("time", "t", "timestamp"),
    "position": ("position", "q"),
    "velocity": ("measured", "velocity", "w"),
    "torque": ("torque", "u", "effort", "current"),
}
"""Names that columns have where none are given; words with capitals, too, as ``Time``. A ``T`` may be a torque."""

FASTEST_JOINT = 100.0  # speed, rad/s, from which degrees are suspected
BETWEEN = r"[\s*.·]?"  # the factors of a unit
BEFORE = r"(?:^|[\s_.,:/\[({])"
MILLIAMPERES = "mA"
ROTARY, LINEAR, ANY = (False,), (True,), (False, True)

TAKEN = {"time": ("s", "s"), "position": ("rad", "m"), "velocity": ("rad/s", "m/s"), "torque": ("N m", "N")}
"""Units in which columns are taken, of rotary joints and of linear axes.

In brackets they tell the axis; an ``m`` that is not in brackets may be one of a motor.
"""

UNITS = (
    ("time", ANY, "milliseconds", "1e-3", "ms|msec|millis|milliseconds"),
    ("time", ANY, "microseconds", "1e-6", "us|µs|μs|usec|micros|microseconds"),
    ("time", ANY, "nanoseconds", "1e-9", "ns|nsec|nanos|nanoseconds"),
    ("time", ANY, "minutes", "60", "min|minutes"),
    ("position", ROTARY, "millidegrees", "pi/180/1000", ".*mdeg"),
    ("position", ROTARY, "degrees", "pi/180", ".*(?:deg(?:rees?)?|°)"),
    ("position", ROTARY, "milliradians", "1e-3", "mrad"),
    ("position", ROTARY, "turns", "2*pi", "revs?|revolutions|turns?"),
    ("position", ROTARY, "counts", "2*pi/COUNTS_OF_A_TURN", "counts?|cnts?|incs?|increments|ticks?|pulses"),
    ("position", LINEAR, "counts", "1/COUNTS_OF_A_METRE", "counts?|cnts?|incs?|increments|ticks?|pulses"),
    ("position", LINEAR, "millimetres", "1e-3", "mm|millimet(?:er|re)s?"),
    ("position", LINEAR, "micrometres", "1e-6", "um|µm|μm"),
    ("velocity", ROTARY, "millidegrees per second", "pi/180/1000", ".*mdeg(?:/s(?:ec)?|_(?:per_)?s)?"),
    ("velocity", ROTARY, "degrees per second", "pi/180", ".*(?:deg(?:rees?)?|°)(?:/s(?:ec)?|_(?:per_)?s)?|dps"),
    ("velocity", ROTARY, "revolutions per minute", "pi/30", r"rpm|1/min|u/min|min\^?-1|rev/min|r/min|upm"),
    ("velocity", ROTARY, "revolutions per second", "2*pi", "rps|rev/s|rev/sec"),
    ("velocity", ROTARY, "milliradians per second", "1e-3", "mrad/s|mrad_s"),
    ("velocity", LINEAR, "millimetres per second", "1e-3", "mm/s|mm_s"),
    ("velocity", LINEAR, "metres per minute", "1/60", "m/min"),
    ("torque", ROTARY, "mN m", "1e-3", f"mn{BETWEEN}m|n{BETWEEN}mm"),
    ("torque", ROTARY, "N cm", "1e-2", f"n{BETWEEN}cm"),
    ("torque", ROTARY, "kN m", "1e3", f"kn{BETWEEN}m"),
    ("torque", LINEAR, "kN", "1e3", "kn"),
    ("torque", ANY, "per cent", "RATED/100", "%|pct|percent"),
    ("torque", ANY, "per mille", "RATED/1000", "‰|per_?mille?|promille"),
    ("torque", ANY, MILLIAMPERES, "1e-3", "ma|milliamp(?:ere)?s?"),
)
"""Units by role and kind of axis: in words, the factor as ``--scale`` takes it, in capitals what only the user knows,
and how they are written: in brackets or apart from the rest of the name, degrees as its end as well."""

CURRENT = re.compile(r"current|amp(ere)?s?|(^|_)i_?q(_|$)|_a$|[\[(]a([ _.]?(rms|eff))?[\])]$")
"""Name of a column that is a current, in A; an ``a`` after a blank may be a letter of a joint."""


class Unit(NamedTuple):
    """A unit that a column is in instead of the one that is taken, in words, and the factor between them.

    The factor is empty for a unit that only the other kind of axis, linear or rotary, has.
    """

    name: str
    taken: str
    factor: str


def usual_column(path: Path, content: Content, roles: Sequence[str], ending: str = "") -> tuple[str, str]:
    """Return role and column of the first role (keys of ``USUAL``) that has a column of a usual name.

    ``ending`` is that of the options that name columns, for messages.

    Raises
    ------
    InputError
        No column has a usual name.
    """
    for role in roles:
        for name in USUAL[role]:
            long = len(name) > 1
            written = [column for column in content.shapes if column == name or (long and column.casefold() == name)]
            if written:
                return role, name if name in written else written[0]
    options = " or ".join(f"--{role}{ending}" for role in roles)
    usual = " or ".join(name for role in roles for name in USUAL[role])
    raise InputError(f"{path}: {options} must name a column, as none is called {usual}; there are {content.listed()}")


def with_units(content: Content, columns: Mapping[str, str]) -> dict[str, str]:
    """Return names of columns by role, with the units in brackets that a row below the header gives."""
    named = {column: f"{column} [{unit.strip('[](){} ')}]" for column, unit in content.units.items()}
    return {role: named.get(column, column) for role, column in columns.items()}


def foreign_unit(column: str, role: str, *, linear: bool) -> Unit | None:
    """Return the unit that the name of a column says, where it is not the one that the column is taken in.

    The role is ``time``, ``position``, ``velocity`` or that of a torque.
    """
    known, plain = role if role in TAKEN else "torque", _bare(column).casefold()
    own, other = TAKEN[known][linear], TAKEN[known][not linear]
    for axis in (linear, not linear):
        for of_role, axes, name, factor, written in UNITS:
            if of_role == known and axis in axes and re.search(BEFORE + rf"(?:{written})[\])}}]?$", plain):
                return Unit(name, "A" if name == MILLIAMPERES else own, factor if axis == linear else "")
    of_other_axis = re.search(rf"[\[(]{other.lower().replace(' ', BETWEEN)}[\])]$", plain)
    return Unit(other, own, "") if of_other_axis and other != own else None


def is_current(column: str, factor: float | None = None) -> bool:
    """Tell whether the name of a column says that it is a current, and its factor makes no torque of it.

    A factor that turns milliamperes into amperes, or the sign, makes none.
    """
    unit = foreign_unit(column, "torque", linear=False)
    amperes = 1e-3 if unit is not None and unit.name == MILLIAMPERES else 1.0
    named = amperes == 1e-3 or bool(CURRENT.search(_bare(column).casefold()))
    return named and (factor is None or abs(factor) == amperes)


def in_degrees(log: Log, speed: float, *, linear: bool) -> list[str]:
    """Ask whether the motion of a log is in degrees, or in revolutions per minute, if its largest speed (rad/s) is."""
    if linear or speed <= FASTEST_JOINT:
        return []
    units = {"degrees": "pi/180"} | ({"revolutions per minute": "pi/30"} if log.position is None else {})
    advice = log.scaling("motion", *units.values())
    return [f"the joint reaches {speed:.3g} rad/s: is the motion in {' or '.join(units)}? Then {advice}"]


def _bare(column: str) -> str:
    """Return the name of a column without what picks a series of it."""
    return PICKED.sub("", column.strip()).strip()


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
        scales[name] = _factor(factor)
        if not math.isfinite(scales[name]) or scales[name] == 0.0:
            rule = "the factor must be numbers and pi joined by * and /, finite and not zero"
            raise InputError(f"--scale {text} is not allowed: {rule}")
    return scales


def _factor(text: str) -> float:
    """Return a product of numbers and pi; NaN for what is none."""
    value = 1.0
    with suppress(ValueError, ZeroDivisionError):
        for operator, operand in re.findall(r"(^|[*/])([^*/]*)", text):
            bare = operand.strip()
            number = {"pi": math.pi, "-pi": -math.pi}.get(bare) or float(bare)
            value = value / number if operator == "/" else value * number
        return value
    return math.nan
