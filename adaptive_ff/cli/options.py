"""Options of the commands: each declared once, as a field of the group whose fields are the arguments that it fills.

The comment beside a field, or above it, is the help of its option, unless that has one of its own.
"""

import functools
import inspect
import math
import re
from collections.abc import Callable
from dataclasses import dataclass, fields, is_dataclass
from enum import StrEnum
from pathlib import Path
from typing import Annotated, Any, get_args, get_origin

import typer

from adaptive_ff.errors import InputError

DESCRIBED = re.compile(r"^((?: {4}# .*\n)*) {4}(\w+): [^#\n]*?(?: *# (.*))?$", re.MULTILINE)
"""Comments above a field, its name, and the comment beside it."""

KNOWN_FORMATS = ("png", "pdf", "svg")

STANDARD_OUTPUT = Path("-")  # what stands for standard output instead of a file


class TableForm(StrEnum):
    """How tables are printed."""

    TEXT = "text"
    MARKDOWN = "markdown"
    CSV = "csv"


@dataclass
class Common:
    """Options of every command that runs something."""

    quiet: Annotated[bool, typer.Option("--quiet", "-q")] = False  # print nothing but warnings and errors
    tables: TableForm = TableForm.TEXT  # how tables are printed


SETTINGS = Common()  # of the command that runs; a process runs one at a time


@dataclass
class Output(Common):
    """Where and how results are written."""

    out: Path = Path("results")  # folder for all that is written
    # write the result there, too; - for standard output, without tables
    json: Annotated[Path | None, typer.Option("--json")] = None
    # formats of the pictures: png, pdf, svg, or several: png,pdf
    formats: Annotated[str, typer.Option("--format")] = "png"
    # also write report.html: tables, pictures that zoom, input and versions in one file
    report: Annotated[bool, typer.Option("--report")] = False

    @functools.cached_property
    def drawn(self) -> tuple[str, ...]:
        """Formats of the pictures; one that is not known, or none, raises ``InputError``."""
        names = named_parts(self.formats, KNOWN_FORMATS, "--format = {name!r} is not known; there are {known}")
        if not names:
            raise InputError(f"--format is empty; there are {', '.join(KNOWN_FORMATS)}")
        return names


@dataclass
class ViewerOutput(Output):
    """The same, with the series for viewers."""

    # write the series there as MCAP, for PlotJuggler and Foxglove, with a layout for the former beside
    mcap: Path | None = None


def named_parts(text: str, known: tuple[str, ...], refusal: str) -> tuple[str, ...]:
    """Return the names in a text, separated by commas, each once; ``InputError`` for one that is not known."""
    names = tuple(dict.fromkeys(part.strip().lower() for part in text.split(",") if part.strip()))
    for name in names:
        if name not in known:
            raise InputError(refusal.format(name=name, known=", ".join(known)))
    return names


@functools.cache
def _source(file: str) -> str:
    return Path(file).read_text(encoding="utf-8")


def described(owner: Any) -> dict[str, str]:
    """Return the comments of the fields of a class, or of the parameters of a function, by name."""
    try:
        source = _source(inspect.getfile(owner))
    except (OSError, TypeError):  # it is not at hand
        return {}
    # inspect.getsource would parse the whole file each time
    body = re.search(rf"^(?:class|def) {owner.__name__}\b.*\n(?:[ )].*\n|\n)*", source, re.MULTILINE)
    found = DESCRIBED.findall(body[0]) if body else []
    texts = {name: beside or " ".join(re.findall("# (.*)", above)) for above, name, beside in found}
    return {name: f"{text[0].upper()}{text[1:]}." for name, text in texts.items() if text}


def _option(name: str, kind: Any, default: Any, texts: dict[str, str]) -> inspect.Parameter:
    """Return an option as a parameter; its comment is its help where it has none."""
    if get_origin(kind) is not Annotated:
        kind = Annotated[kind, typer.Option()]
    declared = get_args(kind)[1]
    declared.help = declared.help or texts.get(name)
    return inspect.Parameter(name, inspect.Parameter.KEYWORD_ONLY, default=default, annotation=kind)


def command(function: Callable[..., Any]) -> Callable[..., Any]:
    """Return a command in whose place of each group stand the options of the group.

    A parameter that is annotated with a dataclass gets the fields of it as options; their defaults are those of the
    parameter's default.
    """
    groups: dict[str, Any] = {}
    parameters: list[inspect.Parameter] = []
    own = described(function)
    for name, parameter in inspect.signature(function).parameters.items():
        kind, default = parameter.annotation, parameter.default
        if is_dataclass(kind):
            groups[name], bases = kind, reversed(type(default).__mro__[:-1])
            texts = {field: text for base in bases for field, text in described(base).items()}
            parameters += [_option(one.name, one.type, getattr(default, one.name), texts) for one in fields(kind)]
        else:
            parameters.append(_option(name, kind, default, own))

    @functools.wraps(function)
    def wrapped(**given: Any) -> Any:
        filled = {
            name: kind(**{one.name: given.pop(one.name) for one in fields(kind)}) for name, kind in groups.items()
        }
        chosen = next((one for one in filled.values() if isinstance(one, Common)), Common())
        SETTINGS.quiet, SETTINGS.tables = chosen.quiet, chosen.tables
        if isinstance(chosen, Output):
            _ = chosen.drawn  # refused before anything runs
            SETTINGS.quiet |= chosen.json == STANDARD_OUTPUT
        try:
            return function(**given, **filled)
        finally:
            SETTINGS.quiet, SETTINGS.tables = False, TableForm.TEXT

    wrapped.__signature__ = inspect.Signature(parameters)  # type: ignore[attr-defined]
    wrapped.__annotations__ = {one.name: one.annotation for one in parameters}
    return wrapped


ScenarioFile = Annotated[
    Path | None,
    typer.Argument(
        help="Scenario: a TOML file, or a name that adaptive-ff scenarios lists; the built-in one by default."
    ),
]
LogFile = Annotated[
    Path, typer.Argument(help="CSV, NPZ, MAT, HDF5, Parquet, MCAP or ROS bag file.", show_default=False)
]
OwnControllers = Annotated[
    list[str] | None,
    typer.Option(
        "--own",
        metavar="[NAME=]FILE.py:OBJECT",
        help="Own controller: a class, a factory or an object with a method step. May be given several times.",
    ),
]
Scheduler = Annotated[
    str | None, typer.Option(help="Address of a Dask scheduler, such as tcp://host:8786, whose workers do the runs.")
]
TorqueDelay = Annotated[
    float | None, typer.Option(help="Time after its stamp at which a torque acts, s; half a period where it is held.")
]
TorqueConstant = Annotated[
    float | None, typer.Option(help="Torque by current, N m/A (N/A), where the column of the torque is a current in A.")
]
KnownTorque = Annotated[
    str | None, typer.Option(help="Column of a torque that is known (gravity, coupling), N m; it is subtracted.")
]
Scale = Annotated[
    list[str] | None, typer.Option(help="NAME=FACTOR for a column in other units, such as q=pi/180 or u=-1/48.")
]
Linear = Annotated[bool, typer.Option("--linear", help="A linear axis: units are m, N and kg.")]


@dataclass
class Columns:
    """Columns of a log, by role; of a usual name where none is given."""

    time: str | None = None  # column of the time, s
    period: float | None = None  # constant sample time, s, instead of a column
    position: str | None = None  # column of the position, rad; NAME[3] is a table's 4th
    torque: str | None = None  # column of the drive's torque, N m
    known_torque: KnownTorque = None
    scale: Scale = None


@dataclass
class MeasuredColumns(Columns):
    """Columns of a log that may have a velocity in the place of a position, and a current in that of a torque."""

    velocity: str | None = None  # column of the velocity, rad/s, instead of a position
    torque_constant: TorqueConstant = None


@dataclass
class LogColumns:
    """Columns of the log of a command that takes a simulated recording otherwise."""

    time_column: Annotated[str | None, typer.Option("--time-column", "--time")] = None  # column of the log's time, s
    position_column: str | None = None  # column of its position, rad
    velocity_column: str | None = None  # column of its velocity, rad/s, instead of a position
    torque_column: str | None = None  # column of its drive's torque, N m
    known_torque: KnownTorque = None
    scale: Scale = None
    torque_constant: TorqueConstant = None

    def measured(self) -> MeasuredColumns:
        """Return them by the names of other commands."""
        return MeasuredColumns(**{name.removesuffix("_column"): value for name, value in vars(self).items()})


@dataclass
class OverPosition:
    """What is known of friction and force over position."""

    # known period of friction, or of a force, over position, rad (m). May be given several times
    position_period: list[float] | None = None
    # turns of the motor in one of the joint: a turn of the motor is then a known period, too
    gear_ratio: float | None = None
    position_hats: int = 0  # hats, 2 or more, of a map over the positions of the log, where no period is known

    def arguments(self) -> dict[str, Any]:
        """Return them as the identification takes them; ``InputError`` where the gear ratio is no positive number."""
        periods, ratio = tuple(self.position_period or ()), self.gear_ratio
        if ratio is not None:
            if not (math.isfinite(ratio) and ratio > 0.0):
                raise InputError(f"--gear-ratio = {ratio:g} is not allowed: it must be positive")
            periods = (*periods, 2.0 * math.pi / ratio)
        return {"position_periods": periods, "position_hats": self.position_hats}


@dataclass
class Limits:
    """Limits of an exciting motion."""

    # largest distance of the motion from its start, rad
    position: Annotated[float | None, typer.Option("--position", "--max-position")] = None
    # largest velocity, rad/s; chosen if not given
    velocity: Annotated[float | None, typer.Option("--velocity", "--max-velocity")] = None
    # largest acceleration, rad/s^2
    acceleration: Annotated[float | None, typer.Option("--acceleration", "--max-acceleration")] = None
    # largest torque, N m; 0.7 of the drive's if not given
    torque: Annotated[float | None, typer.Option("--torque", "--max-torque")] = None
