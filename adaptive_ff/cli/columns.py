"""Columns of a recorded log, chosen on the command line."""

import math
import re
import shlex
import warnings
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, NamedTuple

from adaptive_ff.errors import InputError

if TYPE_CHECKING:
    from adaptive_ff.logs.log import Log


CURRENT = re.compile(r"(current|amp(ere)?s?|(^|_)i_?q(_|$)|_A$)(\[\d+\])?", re.IGNORECASE)
"""Name of a column that is a current."""


def chosen_columns(
    log: Path,
    time: str | None,
    period: float | None,
    position: str | None,
    velocity: str | None,
    torque: str | None,
    known_torque: str | None = None,
    ending: str = "",
) -> dict[str, str]:
    """Return the column of each role; where none is named, the one of a usual name.

    The ending is that of the options that name them, for messages.
    """
    from adaptive_ff.logs.columns import column_names, usual_column

    if time is not None and period is not None:
        raise InputError("--time and --period are both given; give one of them")
    if position is not None and velocity is not None:
        raise InputError(f"--position{ending} and --velocity{ending} are both given; give one of them")
    chosen = {"time": time, "position": position, "velocity": velocity, "torque": torque}
    columns = {role: column for role, column in chosen.items() if column is not None}
    names: list[str] | None = None
    for roles in (("time",), ("position", "velocity"), ("torque",)):
        if any(role in columns for role in roles) or (roles == ("time",) and period is not None):
            continue
        names = column_names(log) if names is None else names
        role, column = usual_column(log, names, roles, ending)
        columns[role] = column
    return columns if known_torque is None else {**columns, "known_torque": known_torque}


def columns_taken(columns: Mapping[str, str]) -> str:
    """Return a sentence that says which columns were taken."""
    return "Columns: " + ", ".join(f"{role.replace('_', ' ')} {column}" for role, column in columns.items()) + "."


def with_torque_constant(
    scales: Mapping[str, float],
    columns: Mapping[str, str],
    torque_constant: float | None,
    resistance: float | None = None,
    *,
    is_voltage: bool = False,
) -> dict[str, float]:
    """Return the factors by column with that of a current, N m/A (N/A), or of a voltage, in that of the torque."""
    for option, value in (("--torque-constant", torque_constant), ("--resistance", resistance)):
        if value is not None and (not math.isfinite(value) or value == 0.0):
            raise InputError(f"{option} = {value:g} is not allowed: it must be finite and not zero")
    if is_voltage and (torque_constant is None or resistance is None or resistance < 0.0):
        raise InputError(
            "--voltage takes --resistance, in ohm, positive, and --torque-constant, in N m/A (N/A), as well"
        )
    if resistance is not None and not is_voltage:
        raise InputError("--resistance is that of a motor whose voltage is given; give --voltage, too")
    if torque_constant is None:
        return dict(scales)
    factor = torque_constant / (resistance or 1.0)
    return {**scales, columns["torque"]: factor * scales.get(columns["torque"], 1.0)}


def is_current(column: str) -> bool:
    """Tell whether the name of a column says that it is a current."""
    from adaptive_ff.logs.column_units import says_amperes

    return CURRENT.search(column) is not None or says_amperes(column)


class Factors(NamedTuple):
    """What the columns of a log are multiplied by.

    Attributes
    ----------
    scales : dict of str to float
        Factors by column, with the torque constant in that of the torque.
    is_current : bool
        Whether the column of the torque is a current that no factor turns into a torque.
    """

    scales: dict[str, float]
    is_current: bool


def column_factors(
    path: Path,
    columns: Mapping[str, str],
    scale: Sequence[str],
    torque_constant: float | None,
    *,
    linear: bool,
    further: Mapping[str, str] | None = None,
    takes_current: bool = True,
    resistance: float | None = None,
    is_voltage: bool = False,
) -> Factors:
    """Return the factors that a user gave, and warn of units that columns say and no factor was given for.

    Parameters
    ----------
    path : Path
        The log, whose columns may have a row of units.
    columns, further : mapping of str to str
        Column by role, and those that a replay has beside them.
    scale : sequence of str
        Factors as ``--scale`` takes them.
    torque_constant : float or None
        N m/A (N/A).
    linear : bool
        Whether the joint is a linear axis.
    takes_current : bool, optional
        Whether a current will do as the torque.
    resistance : float, optional
        Of a motor whose voltage is given, ohm.
    is_voltage : bool, optional
        Whether the torque is a voltage.

    Raises
    ------
    InputError
        A factor is none, or the torque is a current where it must not be.
    """
    from adaptive_ff.logs.columns import read_scales, with_units

    given = read_scales(scale)
    scales = with_torque_constant(given, columns, torque_constant, resistance, is_voltage=is_voltage)
    named = with_units(path, {**columns, **(further or {})})
    is_current = torque_constant is None and is_in_amperes(named["torque"], given.get(columns["torque"]))
    if is_current and not takes_current:
        raise InputError(
            f"{path}: the column {columns['torque']} seems to be a current in A; give --torque-constant, in N m/A (N/A)"
        )
    warn_of_units(named, {**columns, **(further or {})}, given, linear=linear)
    return Factors(scales, is_current)


def is_in_amperes(named: str, factor: float | None) -> bool:
    """Tell whether a column, named with its unit, is a current that the factor which a user gave makes no torque of.

    One that turns milliamperes into amperes, or the sign, makes none.
    """
    from adaptive_ff.logs.column_units import MILLIAMPERES, foreign_unit

    if not is_current(named):
        return False
    unit = foreign_unit(named, "torque", linear=False)
    into_amperes = 1e-3 if unit is not None and unit.name == MILLIAMPERES else 1.0
    return factor is None or abs(factor) == into_amperes


def warn_of_units(
    named: Mapping[str, str], columns: Mapping[str, str], scales: Mapping[str, float], *, linear: bool
) -> None:
    """Warn where a column says another unit than the one it is taken in, or another axis, and no factor was given.

    Parameters
    ----------
    named, columns : mapping of str to str
        Column by role, with its unit and without.
    scales : mapping of str to float
        Factors that the user gave, by column.
    linear : bool
        Whether the joint is a linear axis.
    """
    from adaptive_ff.logs.column_units import foreign_unit, unit_of_other_axis

    taken = "linear" if linear else "rotary"
    for role, column in columns.items():
        if column in scales:
            continue
        series = role.rpartition("_")[2]
        other = unit_of_other_axis(named[role], series, linear=linear)
        if other is not None:
            warnings.warn(
                f"the column {column} seems to be in {other}, but the axis is taken as {taken}; --linear, or axis = "
                "'linear' in a scenario, is for axes in m and N",
                stacklevel=2,
            )
            continue
        unit = foreign_unit(named[role], series, linear=linear)
        if unit is not None:
            warnings.warn(
                f"the column {column} seems to be in {unit.name}, but is taken as {unit.taken}: give "
                f"--scale {shlex.quote(f'{column}={unit.factor}')}",
                stacklevel=2,
            )


def read_columns(
    path: Path,
    columns: Mapping[str, str],
    period: float | None,
    scales: Mapping[str, float],
    extra: Mapping[str, str] | None = None,
) -> "Log":
    """Read a log with columns by role, and further ones by the name that they get."""
    from adaptive_ff.logs.log import read_log

    return read_log(
        path,
        torque=columns["torque"],
        position=columns.get("position"),
        velocity=columns.get("velocity"),
        time=columns.get("time"),
        period=period,
        extra=extra,
        scale=scales,
        known_torque=columns.get("known_torque"),
    )
