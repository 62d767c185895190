"""Arguments and options that several commands share."""

import math
from pathlib import Path
from typing import Annotated

import typer

from adaptive_ff.errors import InputError

SCENARIO_HELP = "Scenario: a TOML file, or a name that adaptive-ff scenarios lists; the built-in one by default."
OUT = Path("results")
"""Default of ``--out``."""

ScenarioFile = Annotated[Path | None, typer.Argument(help=SCENARIO_HELP)]
OwnControllers = Annotated[
    list[str] | None,
    typer.Option(
        "--own",
        metavar="[NAME=]FILE.py:OBJECT",
        help="Own controller: a class, a factory or an object with a method step. May be given several times.",
    ),
]
JsonCopy = Annotated[
    Path | None, typer.Option("--json", help="Write the result there, too; - for standard output, without tables.")
]

Formats = Annotated[str, typer.Option("--format", help="Formats of the pictures: png, pdf, svg, or several: png,pdf.")]
"""Parsed by ``picture_formats``."""

Report = Annotated[
    bool,
    typer.Option(
        "--report", help="Also write report.html: tables, pictures that zoom, input and versions in one file."
    ),
]

KNOWN_FORMATS = ("png", "pdf", "svg")


def picture_formats(text: str) -> tuple[str, ...]:
    """Return the formats of pictures that an option names.

    Raises
    ------
    InputError
        One is not known.
    """
    names = tuple(dict.fromkeys(part.strip().lower() for part in text.split(",") if part.strip()))
    for name in names:
        if name not in KNOWN_FORMATS:
            raise InputError(f"--format = {name!r} is not known; there are {', '.join(KNOWN_FORMATS)}")
    if not names:
        raise InputError(f"--format is empty; there are {', '.join(KNOWN_FORMATS)}")
    return names


LogFile = Annotated[
    Path, typer.Argument(help="CSV, NPZ, MAT, HDF5, Parquet, MCAP or ROS bag file.", show_default=False)
]
Time = Annotated[str | None, typer.Option(help="Column of the time, s.")]
Period = Annotated[float | None, typer.Option(help="Constant sample time, s, instead of a column.")]
Position = Annotated[str | None, typer.Option(help="Column of the position, rad; NAME[3] is a table's 4th.")]
Velocity = Annotated[str | None, typer.Option(help="Column of the velocity, rad/s, instead of a position.")]
Torque = Annotated[str | None, typer.Option(help="Column of the drive's torque, N m.")]
TorqueConstant = Annotated[
    float | None,
    typer.Option(help="Torque by current, N m/A (N/A), where the column of the torque is a current in A."),
]
Voltage = Annotated[
    str | None,
    typer.Option(
        help="Column of the motor's voltage, V, instead of a torque; of a PWM duty with --scale NAME=SUPPLY. Takes "
        "--resistance and --torque-constant."
    ),
]
Resistance = Annotated[float | None, typer.Option(help="Resistance of the motor, ohm, for --voltage.")]
Details = Annotated[bool, typer.Option("--details", help="Also say how the numbers came about.")]
TorqueDelay = Annotated[
    float | None,
    typer.Option(help="Time after its stamp at which a torque acts, s; half a period where it is held."),
]
KnownTorque = Annotated[
    str | None, typer.Option(help="Column of a torque that is known (gravity, coupling), N m; it is subtracted.")
]
PositionPeriod = Annotated[
    list[float] | None,
    typer.Option(help="Known period of friction, or of a force, over position, rad (m). May be given several times."),
]
GearRatio = Annotated[
    float | None,
    typer.Option(help="Turns of the motor in one of the joint: a turn of the motor is then a known period, too."),
]
PositionHats = Annotated[
    int, typer.Option(help="Hats, 2 or more, of a map over the positions of the log, where no period is known.")
]
LoadFriction = Annotated[
    bool, typer.Option("--load-friction", help="Friction may rise with the torque of --known-torque.")
]


def known_periods(periods: list[float] | None, gear_ratio: float | None) -> tuple[float, ...]:
    """Return the periods that are given, and that of a turn of the motor.

    Raises
    ------
    InputError
        The gear ratio is no positive number.
    """
    if gear_ratio is None:
        return tuple(periods or ())
    if not (math.isfinite(gear_ratio) and gear_ratio > 0.0):
        raise InputError(f"--gear-ratio = {gear_ratio:g} is not allowed: it must be positive")
    return (*(periods or ()), 2.0 * math.pi / gear_ratio)


Scale = Annotated[
    list[str] | None, typer.Option(help="NAME=FACTOR for a column in other units, such as q=pi/180 or u=-1/48.")
]
Linear = Annotated[bool, typer.Option("--linear", help="A linear axis: units are m, N and kg.")]
