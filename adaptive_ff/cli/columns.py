"""Columns of a recorded log, chosen on the command line."""

import math
import shlex
import warnings
from collections.abc import Mapping
from contextlib import suppress
from pathlib import Path
from typing import TYPE_CHECKING, NamedTuple

import adaptive_ff
from adaptive_ff.cli.options import Columns, MeasuredColumns
from adaptive_ff.errors import InputError

if TYPE_CHECKING:
    from adaptive_ff.logs.formats import Content
    from adaptive_ff.logs.log import Log


class Chosen(NamedTuple):
    """Columns by role, factors by column, the period where there is no time, and whether the torque is a current."""

    columns: dict[str, str]
    scales: dict[str, float]
    period: float | None
    is_current: bool

    def read(self, path: Path, extra: Mapping[str, str] | None = None) -> "Log":
        """Read a log, with further columns by the name that they get."""
        return adaptive_ff.read_log(path, **self.columns, period=self.period, extra=extra, scale=self.scales)

    @property
    def sentence(self) -> str:
        """Says which columns were taken."""
        taken = (f"{role.replace('_', ' ')} {column}" for role, column in self.columns.items())
        return f"Columns: {', '.join(taken)}."


def chosen_columns(
    log: Path,
    given: Columns,
    *,
    linear: bool,
    ending: str = "",
    further: Mapping[str, str] | None = None,
    takes_current: bool = True,
    voltage: str | None = None,
    resistance: float | None = None,
) -> Chosen:
    """Return the columns that are named, else those of usual names; warn of units without a factor.

    The torque of a group without a torque constant may have any unit, and a current will do as the torque where that is
    said. In place of a torque a motor's voltage and resistance (ohm) may stand. ``ending`` is that of the options that
    name columns, for messages; ``further`` holds further columns by role.
    """
    from adaptive_ff.logs.columns import is_current, read_scales, with_units

    (columns, content), factors = _by_role(log, given, voltage, ending), read_scales(given.scale or [])
    if not isinstance(given, MeasuredColumns):
        motion = {role: column for role, column in columns.items() if role in ("time", "position")}
        warn_of_units(with_units(content, motion), motion, factors, linear=linear)
        return Chosen(columns, factors, given.period, False)
    constant, torque, together = given.torque_constant, columns["torque"], {**columns, **(further or {})}
    scales = _with_torque_constant(factors, torque, constant, resistance, is_voltage=voltage is not None)
    named = with_units(content, together)
    in_amperes = constant is None and is_current(named["torque"], factors.get(torque))
    if in_amperes and not takes_current:
        raise InputError(
            f"{log}: the column {torque} seems to be a current in A; give --torque-constant, in N m/A (N/A)"
        )
    warn_of_units(named, together, factors, linear=linear)
    return Chosen(columns, scales, given.period, in_amperes)


def _by_role(log: Path, given: Columns, voltage: str | None, ending: str) -> "tuple[dict[str, str], Content]":
    """Return the column of each role, where none is named, the one of a usual name; and what the file holds."""
    from adaptive_ff.logs.columns import usual_column
    from adaptive_ff.logs.formats import read_content

    velocity = given.velocity if isinstance(given, MeasuredColumns) else None
    for one, other, names in (
        (given.time, given.period, "--time and --period"),
        (given.position, velocity, f"--position{ending} and --velocity{ending}"),
        (voltage, given.torque, "--voltage and --torque"),
    ):
        if one is not None and other is not None:
            raise InputError(f"{names} are both given; give one of them")
    chosen = {"time": given.time, "position": given.position, "velocity": velocity, "torque": voltage or given.torque}
    columns = {role: column for role, column in chosen.items() if column is not None}
    content = read_content(log, ())
    if given.period is not None:
        with suppress(InputError):
            clock = usual_column(log, content, ("time",))[1]
            warnings.warn(f"the column {clock} is not read, as --period = {given.period:g} s is given", stacklevel=2)
    motions = ("position", "velocity") if isinstance(given, MeasuredColumns) else ("position",)
    for roles in (("time",), motions, ("torque",)):
        if not any(role in columns for role in roles) and not (roles == ("time",) and given.period is not None):
            role, column = usual_column(log, content, roles, ending)
            columns[role] = column
    known = {} if given.known_torque is None else {"known_torque": given.known_torque}
    return columns | known, content


def _with_torque_constant(
    scales: Mapping[str, float], torque: str, constant: float | None, resistance: float | None, *, is_voltage: bool
) -> dict[str, float]:
    """Return the factors by column with that of a current, N m/A (N/A), or of a voltage, in that of the torque."""
    for option, value in (("--torque-constant", constant), ("--resistance", resistance)):
        if value is not None and (not math.isfinite(value) or value == 0.0):
            raise InputError(f"{option} = {value:g} is not allowed: it must be finite and not zero")
    if is_voltage and (constant is None or resistance is None or resistance < 0.0):
        raise InputError(
            "--voltage takes --resistance, in ohm, positive, and --torque-constant, in N m/A (N/A), as well"
        )
    if resistance is not None and not is_voltage:
        raise InputError("--resistance is that of a motor whose voltage is given; give --voltage, too")
    if constant is None:
        return dict(scales)
    return {**scales, torque: constant / (resistance or 1.0) * scales.get(torque, 1.0)}


def warn_of_units(
    named: Mapping[str, str], columns: Mapping[str, str], scales: Mapping[str, float], *, linear: bool
) -> None:
    """Warn where a column says another unit than the one it is taken in, or another axis, and no factor was given.

    ``named`` and ``columns`` hold the columns by role, with their unit and without.
    """
    from adaptive_ff.logs.columns import foreign_unit

    taken = "linear" if linear else "rotary"
    for role, column in columns.items():
        unit = foreign_unit(named[role], role.rpartition("_")[2], linear=linear)
        if unit is None or column in scales:
            continue
        said = f"{unit.name}, but is taken as {unit.taken}: give --scale {shlex.quote(f'{column}={unit.factor}')}"
        if not unit.factor:
            axis = "--linear, or axis = 'linear' in a scenario, is for axes in m and N"
            said = f"{unit.name}, but the axis is taken as {taken}; {axis}"
        warnings.warn(f"the column {column} seems to be in {said}", stacklevel=2)
