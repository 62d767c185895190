"""Options of the commands: each declared once, as a field of the group whose fields are the arguments that it fills."""

import functools
import inspect
import math
from collections.abc import Callable
from dataclasses import dataclass, fields, is_dataclass
from enum import StrEnum
from pathlib import Path
from typing import Annotated, Any

import typer

from adaptive_ff.errors import InputError

KNOWN_FORMATS = ("png", "pdf", "svg")

STANDARD_OUTPUT = Path("-")  # what stands for standard output instead of a file


class TableForm(StrEnum):
    """How tables are printed."""

    TEXT = "text"
    MARKDOWN = "markdown"
    CSV = "csv"


CONTROLLER_NAMES = (
    *("pi", "pi_inertia", "fixed", "oracle", "oracle_tuned", "disturbance_observer", "extended_state"),
    *("kalman_disturbance", "observed_nominal", "observed_batch", "adaptive_paper", "adaptive_unsupervised"),
    *("adaptive", "canudas", "canudas_measured", "feedback_error", "lugre_observer", "lugre_gradient"),
    *("friction_observer", "lee_tomizuka", "maxwell_adaptive", "radial_basis", "super_twisting", "repetitive"),
)
FORM_NAMES, SOURCE_NAMES = ("coulomb", "stribeck", "lagged"), ("nominal", "stale", "true", "batch")
METRIC_NAMES = (
    *("rms_error", "max_error", "rms_error_start", "rms_error_settled", "max_error_settled", "torque_variation"),
    *("rms_position_error", "max_position_error", "rms_position_error_settled", "max_position_error_settled"),
)
"""Names that help lists before anything heavy is loaded; a test compares them with those that there are."""


@dataclass
class Common:
    """Options of every command that runs something."""

    quiet: Annotated[bool, typer.Option("--quiet", "-q", help="Print nothing but warnings and errors.")] = False
    tables: Annotated[TableForm, typer.Option(help="How tables are printed.")] = TableForm.TEXT


SETTINGS = Common()  # of the command that runs; a process runs one at a time


@dataclass
class Output(Common):
    """Where and how results are written."""

    out: Annotated[Path, typer.Option(help="Folder for all that is written.")] = Path("results")
    json: Annotated[
        Path | None, typer.Option("--json", help="Write the result there, too; - for standard output, without tables.")
    ] = None
    formats: Annotated[
        str, typer.Option("--format", help="Formats of the pictures: png, pdf, svg, or several: png,pdf.")
    ] = "png"
    report: Annotated[
        bool,
        typer.Option(
            "--report", help="Also write report.html: tables, pictures that zoom, input and versions in one file."
        ),
    ] = False

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

    mcap: Annotated[
        Path | None,
        typer.Option(
            help="Write the series there as MCAP, for PlotJuggler and Foxglove, with a layout for the former beside."
        ),
    ] = None


def named_parts(text: str, known: tuple[str, ...], refusal: str) -> tuple[str, ...]:
    """Return the names in a text, separated by commas, each once; ``InputError`` for one that is not known."""
    names = tuple(dict.fromkeys(part.strip().lower() for part in text.split(",") if part.strip()))
    for name in names:
        if name not in known:
            raise InputError(refusal.format(name=name, known=", ".join(known)))
    return names


def command(function: Callable[..., Any]) -> Callable[..., Any]:
    """Return a command in whose place of each group stand the options of the group.

    A parameter that is annotated with a dataclass gets the fields of it as options; their defaults are those of the
    parameter's default, else of the dataclass.
    """
    groups: dict[str, Any] = {}
    parameters: list[inspect.Parameter] = []
    keyword = inspect.Parameter.KEYWORD_ONLY
    for name, parameter in inspect.signature(function).parameters.items():
        kind = parameter.annotation
        if not is_dataclass(kind):
            parameters.append(parameter.replace(kind=keyword))
            continue
        groups[name] = kind
        made: Any = kind() if parameter.default is inspect.Parameter.empty else parameter.default  # type: ignore[operator]
        for one in fields(kind):
            default, annotation = getattr(made, one.name), one.type
            parameters.append(inspect.Parameter(one.name, keyword, default=default, annotation=annotation))
    common = not any(issubclass(kind, Common) for kind in groups.values())
    if common:
        parameters += [
            inspect.Parameter(one.name, keyword, default=one.default, annotation=one.type) for one in fields(Common)
        ]

    @functools.wraps(function)
    def wrapped(**given: Any) -> Any:
        filled = {
            name: kind(**{one.name: given.pop(one.name) for one in fields(kind)}) for name, kind in groups.items()
        }
        kept = Common(**{one.name: given.pop(one.name) for one in fields(Common)}) if common else None
        for one in (kept, *filled.values()):
            if isinstance(one, Common):
                to_standard_output = isinstance(one, Output) and one.json == STANDARD_OUTPUT
                SETTINGS.quiet, SETTINGS.tables = one.quiet or to_standard_output, one.tables
            if isinstance(one, Output):
                _ = one.drawn  # refused before anything runs
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
    str | None,
    typer.Option(help="Address of a Dask scheduler, such as tcp://host:8786, whose workers do the runs."),
]
TorqueDelay = Annotated[
    float | None,
    typer.Option(help="Time after its stamp at which a torque acts, s; half a period where it is held."),
]
TorqueConstant = Annotated[
    float | None,
    typer.Option(help="Torque by current, N m/A (N/A), where the column of the torque is a current in A."),
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

    time: Annotated[str | None, typer.Option(help="Column of the time, s.")] = None
    period: Annotated[float | None, typer.Option(help="Constant sample time, s, instead of a column.")] = None
    position: Annotated[str | None, typer.Option(help="Column of the position, rad; NAME[3] is a table's 4th.")] = None
    torque: Annotated[str | None, typer.Option(help="Column of the drive's torque, N m.")] = None
    known_torque: KnownTorque = None
    scale: Scale = None


@dataclass
class MeasuredColumns(Columns):
    """Columns of a log that may have a velocity in the place of a position, and a current in that of a torque."""

    velocity: Annotated[str | None, typer.Option(help="Column of the velocity, rad/s, instead of a position.")] = None
    torque_constant: TorqueConstant = None


@dataclass
class LogColumns:
    """Columns of the log of a command that takes a simulated recording otherwise."""

    time_column: Annotated[str | None, typer.Option("--time-column", "--time", help="Column of the log's time, s.")] = (
        None
    )
    position_column: Annotated[str | None, typer.Option(help="Column of its position, rad.")] = None
    velocity_column: Annotated[
        str | None, typer.Option(help="Column of its velocity, rad/s, instead of a position.")
    ] = None
    torque_column: Annotated[str | None, typer.Option(help="Column of its drive's torque, N m.")] = None
    known_torque: KnownTorque = None
    scale: Scale = None
    torque_constant: TorqueConstant = None

    def measured(self) -> MeasuredColumns:
        """Return them by the names of other commands."""
        return MeasuredColumns(**{name.removesuffix("_column"): value for name, value in vars(self).items()})


@dataclass
class OverPosition:
    """What is known of friction and force over position."""

    position_period: Annotated[
        list[float] | None,
        typer.Option(
            help="Known period of friction, or of a force, over position, rad (m). May be given several times."
        ),
    ] = None
    gear_ratio: Annotated[
        float | None,
        typer.Option(help="Turns of the motor in one of the joint: a turn of the motor is then a known period, too."),
    ] = None
    position_hats: Annotated[
        int, typer.Option(help="Hats, 2 or more, of a map over the positions of the log, where no period is known.")
    ] = 0

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

    position: Annotated[
        float | None,
        typer.Option("--position", "--max-position", help="Largest distance of the motion from its start, rad."),
    ] = None
    velocity: Annotated[
        float | None, typer.Option("--velocity", "--max-velocity", help="Largest velocity, rad/s; chosen if not given.")
    ] = None
    acceleration: Annotated[
        float | None, typer.Option("--acceleration", "--max-acceleration", help="Largest acceleration, rad/s^2.")
    ] = None
    torque: Annotated[
        float | None,
        typer.Option("--torque", "--max-torque", help="Largest torque, N m; 0.7 of the drive's if not given."),
    ] = None
