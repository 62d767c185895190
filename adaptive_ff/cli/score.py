"""Command ``adaptive-ff score``."""

from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from adaptive_ff.cli.columns import chosen_columns, columns_taken, read_columns, warn_of_units
from adaptive_ff.cli.options import (
    OUT,
    Formats,
    GearRatio,
    JsonCopy,
    KnownTorque,
    Linear,
    LogFile,
    Period,
    Position,
    PositionHats,
    PositionPeriod,
    Report,
    Scale,
    Time,
    Torque,
    TorqueDelay,
    known_periods,
    picture_formats,
)
from adaptive_ff.cli.places import places
from adaptive_ff.cli.terminal import Printer, error_console, warn

if TYPE_CHECKING:
    from rich.table import Table

    from adaptive_ff.identify.score import Score


def score_command(
    train: LogFile,
    test: Annotated[Path, typer.Argument(help="Another log of the joint, of the same columns.", show_default=False)],
    time: Time = None,
    period: Period = None,
    position: Position = None,
    torque: Torque = None,
    known_torque: KnownTorque = None,
    scale: Scale = None,
    torque_delay: TorqueDelay = None,
    position_period: PositionPeriod = None,
    gear_ratio: GearRatio = None,
    position_hats: PositionHats = 0,
    linear: Linear = False,
    out: Annotated[Path, typer.Option(help="Folder for score.json and score.png.")] = OUT,
    json: JsonCopy = None,
    formats: Formats = "png",
    report: Report = False,
) -> None:
    """Identify one log, and simulate another one with that model from its torque alone, in open loop."""
    from adaptive_ff.files import write_result
    from adaptive_ff.identify.score import score_log
    from adaptive_ff.logs.columns import read_scales, with_units
    from adaptive_ff.report.drawing import write_figures
    from adaptive_ff.report.html_page import NAME, write_report

    drawn = picture_formats(formats)
    columns = chosen_columns(train, time, period, position, None, torque, known_torque)
    scales = read_scales(scale or [])
    motion = {role: column for role, column in columns.items() if role in ("time", "position")}
    warn_of_units(with_units(train, motion), motion, scales, linear=linear)  # the torque may have any unit
    logs = [read_columns(path, columns, period, scales) for path in (train, test)]
    with places(out, json) as (stage, beside):
        score = score_log(
            *logs,
            linear=linear,
            torque_delay=torque_delay,
            position_periods=known_periods(position_period, gear_ratio),
            position_hats=position_hats,
        )
        figures, shown = score.plot(None), _shown(score, columns)
        write_figures(figures, stage, drawn)
        if report:
            write_report(stage / NAME, f"Model of {train}, simulated on {test}", shown, figures)
        for file in (stage / "score.json", *beside.values()):
            write_result(file, {**score.to_dict(), "columns": columns})
    warn(error_console(), score.cautions)
    console = Printer()
    console.show(shown)
    console.say(f"score.json and its picture are in {out}")


def _shown(score: "Score", columns: dict[str, str]) -> "list[Table | str]":
    from adaptive_ff.report.parameter_tables import parameters_table
    from adaptive_ff.report.score_plots import score_lines

    return [parameters_table(score.found), columns_taken(columns), *score_lines(score)]
