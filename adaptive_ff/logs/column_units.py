"""Units that the name of a column says: ``q_deg``, ``Speed [rpm]``, ``current_mA``."""

import re
from typing import NamedTuple

from adaptive_ff.logs.log import Log

PLACE = re.compile(r"(\[\d+\])?$")
"""Which series of an array is picked, at the end of the name of a column."""

BEFORE, AFTER = r"(?:^|[\s_.,:/\[({])", r"[\])}]?$"
"""What is around a unit at the end of a name: it is in brackets, or apart from the rest."""

FASTEST_JOINT = 100.0
"""Speed, rad/s, from which degrees are suspected."""


class Unit(NamedTuple):
    """A unit that a column is in instead of the one that is taken, in words, and the factor between them.

    The factor is written as ``--scale`` takes it, in capitals what only the user knows.
    """

    name: str
    taken: str
    factor: str


COUNTED = r"counts?|cnts?|incs?|increments|ticks?|pulses"
ANYWHERE = r".*(?:deg(?:rees?)?|°)"  # need not be apart from the rest of the name
MILLIAMPERES = "mA"
TIMES = {
    "milliseconds": ("ms|msec|millis|milliseconds", "1e-3"),
    "microseconds": ("us|µs|μs|usec|micros|microseconds", "1e-6"),
    "nanoseconds": ("ns|nsec|nanos|nanoseconds", "1e-9"),
    "minutes": ("min|minutes", "60"),
}
EITHER = {
    "per cent": ("%|pct|percent", "RATED/100"),
    "per mille": ("‰|per_?mille?|promille", "RATED/1000"),
    MILLIAMPERES: ("ma|milliamp(?:ere)?s?", "1e-3"),
}
UNITS: dict[tuple[str, bool], dict[str, tuple[str, str]]] = {
    ("time", False): TIMES,
    ("time", True): TIMES,
    ("position", False): {
        "millidegrees": (".*mdeg", "pi/180/1000"),
        "degrees": (ANYWHERE, "pi/180"),
        "milliradians": ("mrad", "1e-3"),
        "turns": ("revs?|revolutions|turns?", "2*pi"),
        "counts": (COUNTED, "2*pi/COUNTS_OF_A_TURN"),
    },
    ("position", True): {
        "millimetres": ("mm|millimet(?:er|re)s?", "1e-3"),
        "micrometres": ("um|µm|μm", "1e-6"),
        "counts": (COUNTED, "1/COUNTS_OF_A_METRE"),
    },
    ("velocity", False): {
        "millidegrees": (".*mdeg", "pi/180/1000"),
        "degrees per second": (f"{ANYWHERE}|deg/s|deg/sec|°/sec|deg_s|deg_per_s|dps|°/s", "pi/180"),
        "revolutions per minute": (r"rpm|1/min|u/min|min\^?-1|rev/min|r/min|upm", "pi/30"),
        "revolutions per second": ("rps|rev/s|rev/sec", "2*pi"),
        "milliradians per second": ("mrad/s|mrad_s", "1e-3"),
    },
    ("velocity", True): {
        "millimetres per second": ("mm/s|mm_s", "1e-3"),
        "metres per minute": ("m/min", "1/60"),
    },
    ("torque", False): {
        "mN m": (r"mnm|mn[\s*.·]m|nmm|n[\s*.·]mm", "1e-3"),
        "N cm": (r"ncm|n[\s*.·]cm", "1e-2"),
        "kN m": (r"knm|kn[\s*.·]m", "1e3"),
        **EITHER,
    },
    ("torque", True): {"kN": ("kn", "1e3"), **EITHER},
}
"""Units by role, and by whether the axis is linear: how they are written, and their factor."""

TAKEN = {
    "time": ("seconds", "seconds"),
    "position": ("radians", "metres"),
    "velocity": ("rad/s", "m/s"),
    "torque": ("N m", "N"),
}
"""Units in which columns are taken, of rotary joints and of linear axes."""

OF_BOTH = {*TIMES, *EITHER, "counts"}
"""Units that columns of rotary joints and of linear axes have."""

OWN = {
    False: {"position": "rad", "velocity": "rad/s", "torque": r"n[\s*.·]?m"},
    True: {"position": "m", "velocity": "m/s", "torque": "n"},
}
"""Units that tell the axis, by whether it is linear, where they are in brackets; an ``m`` that is not may be a letter
of a motor."""

AMPERES = re.compile(r"[\[(]a([ _.]?(rms|eff))?[\])]$")
"""How names of columns end that are currents in A; an ``a`` that is not in brackets may be a letter of a joint."""


def foreign_unit(column: str, role: str, *, linear: bool) -> Unit | None:
    """Return the unit that the name of a column says, where it is not the one that the column is taken in.

    The role is ``time``, ``position``, ``velocity`` or that of a torque.
    """
    role = role if role in TAKEN else "torque"
    for unit, (spellings, factor) in UNITS[role, linear].items():
        if _ends_with(column, spellings):
            return Unit(unit, "A" if unit == MILLIAMPERES else TAKEN[role][linear], factor)
    return None


def unit_of_other_axis(column: str, role: str, *, linear: bool) -> str | None:
    """Return the unit that the name of a column says where only the other kind of axis, linear or rotary, has it."""
    unit = foreign_unit(column, role, linear=not linear)
    if unit is not None:
        return None if unit.name in OF_BOTH else unit.name
    own = OWN[not linear].get(role)
    found = own and re.search(rf"[\[(]({own})[\])]$", PLACE.sub("", column.strip()).strip(), re.IGNORECASE)
    return found[1] if found else None


def says_amperes(column: str) -> bool:
    """Tell whether the name of a column ends with ampere, or milliampere."""
    return AMPERES.search(_plain(column)) is not None or _ends_with(column, EITHER[MILLIAMPERES][0])


def in_degrees(log: Log, speed: float, *, linear: bool) -> list[str]:
    """Ask whether the motion of a log is in degrees, or in revolutions per minute, if its largest speed (rad/s) is.

    Where the name of its column says another unit, that is asked instead.
    """
    if linear or speed <= FASTEST_JOINT:
        return []
    column, said, other = log.columns.get(log.moving, ""), None, None
    if column not in log.factors:
        said = foreign_unit(column, log.moving, linear=False)
        other = unit_of_other_axis(column, log.moving, linear=False)
    unit, factors = "degrees", ["pi/180"]
    if said is not None:
        unit, factors = said.name, [said.factor]
    elif log.position is None:
        unit, factors = "degrees, or in revolutions per minute", ["pi/180", "pi/30"]
    advice = f"the axis is linear, and {other} are none of a rotary one" if other else log.scaling("motion", *factors)
    return [f"the joint reaches {speed:.3g} rad/s: is the motion in {other or unit}? Then {advice}"]


def _plain(column: str) -> str:
    return PLACE.sub("", column.strip()).strip().casefold()


def _ends_with(column: str, spellings: str) -> bool:
    return re.search(f"{BEFORE}(?:{spellings}){AFTER}", _plain(column)) is not None
