"""Command ``adaptive-ff identify``."""

import os
import warnings
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from adaptive_ff.cli.columns import chosen_columns, column_factors, columns_taken, read_columns
from adaptive_ff.cli.options import (
    OUT,
    Formats,
    GearRatio,
    JsonCopy,
    KnownTorque,
    Linear,
    LoadFriction,
    LogFile,
    Period,
    Position,
    PositionHats,
    PositionPeriod,
    Report,
    Scale,
    Time,
    Torque,
    TorqueConstant,
    TorqueDelay,
    Velocity,
    known_periods,
    picture_formats,
)
from adaptive_ff.cli.places import of_earlier_runs, places
from adaptive_ff.cli.terminal import Printer, error_console, progress_bars, warn, warn_of_skips
from adaptive_ff.errors import InputError

if TYPE_CHECKING:
    from rich.table import Table

    from adaptive_ff.identify.result import LogIdentification

SCENARIO, REFERENCE = "scenario.toml", "reference.csv"
"""Files of the identified joint."""

HELD_OUT = 0.25
"""Default of ``--held-out``; that of ``identify_log``, which the tests compare."""


def identify_command(
    log: LogFile,
    time: Time = None,
    period: Period = None,
    position: Position = None,
    velocity: Velocity = None,
    torque: Torque = None,
    known_torque: KnownTorque = None,
    scale: Scale = None,
    bandwidth: Annotated[float | None, typer.Option(help="Band of the regression, Hz; chosen if not given.")] = None,
    held_out: Annotated[float, typer.Option(help="Share of the log, at its end, to validate on.")] = HELD_OUT,
    validate: Annotated[
        Path | None, typer.Option(help="Another log, of the same columns, to validate on; all of LOG is then fitted.")
    ] = None,
    torque_delay: TorqueDelay = None,
    torque_constant: TorqueConstant = None,
    model: Annotated[
        str,
        typer.Option(
            help="Family of models: coulomb-viscous, symmetric, offset, directions, gravity or "
            "gravity-directions; auto takes the one that predicts held-out data best."
        ),
    ] = "auto",
    position_period: PositionPeriod = None,
    gear_ratio: GearRatio = None,
    position_hats: PositionHats = 0,
    load_friction: LoadFriction = False,
    linear: Linear = False,
    out: Annotated[Path, typer.Option(help="Folder for plots, identification.json and a scenario.")] = OUT,
    json: JsonCopy = None,
    formats: Formats = "png",
    report: Report = False,
) -> None:
    """Identify inertia and friction of a joint from a recorded log."""
    from adaptive_ff.files import write_result
    from adaptive_ff.identify.identification import identify_log
    from adaptive_ff.report.drawing import write_figures
    from adaptive_ff.report.html_page import NAME, write_report
    from adaptive_ff.report.identification_plots import PICTURES

    drawn = picture_formats(formats)
    columns = chosen_columns(log, time, period, position, velocity, torque, known_torque)
    scales, is_current = column_factors(log, columns, scale or [], torque_constant, linear=linear)
    given = read_columns(log, columns, period, scales)
    other = None if validate is None else read_columns(validate, columns, period, scales)
    with places(out, json) as (stage, beside):
        with progress_bars(error_console()) as progress:
            progress.add_task("identify", total=None)
            found = identify_log(
                given,
                bandwidth=bandwidth,
                held_out=held_out,
                validation=other,
                torque_delay=torque_delay,
                linear=linear,
                is_current=is_current,
                model=model,
                position_periods=known_periods(position_period, gear_ratio),
                position_hats=position_hats,
                load_friction=load_friction,
            )
        refused = _write_scenario(found, stage)
        figures, shown = found.plot(None), _shown(found, columns, refused, out)
        write_figures(figures, stage, drawn)
        if report:
            scenario = {} if refused else {SCENARIO: (stage / SCENARIO).read_text(encoding="utf-8")}
            write_report(stage / NAME, f"Joint identified from {log}", shown, figures, scenario)
        result = {**found.to_dict(), "columns": columns, "scenario": SCENARIO if refused is None else None}
        for file in (stage / "identification.json", *beside.values()):
            write_result(file, result)
        earlier = of_earlier_runs(out, stage, PICTURES, [NAME])
    _print(found, shown, out, refused)
    Printer().show(earlier)


def _write_scenario(found: "LogIdentification", stage: Path) -> str | None:
    """Write the scenario and its reference; where it cannot be, say why."""
    from adaptive_ff.files import write_csv
    from adaptive_ff.identify.words.scenario_text import reference_columns, scenario_text
    from adaptive_ff.scenario.scenario import load_scenario

    files = stage / SCENARIO, stage / REFERENCE
    try:
        text = scenario_text(found, REFERENCE)
        files[0].write_text(text, encoding="utf-8")
        write_csv(files[1], reference_columns(found))
        with warnings.catch_warnings(action="ignore"):  # compare says them again
            load_scenario(files[0])
    except InputError as error:
        for file in files:
            file.unlink(missing_ok=True)
        return str(error).replace(str(stage) + os.sep, "")
    return None


def _shown(found: "LogIdentification", columns: dict[str, str], refused: str | None, out: Path) -> "list[Table | str]":
    from adaptive_ff.report.parameter_tables import map_table, parameters_table

    unwritten = [] if refused is None else [f"No scenario is written: {refused}{_left_behind(out)}"]
    tables = [table for table in (parameters_table(found), map_table(found)) if table is not None]
    return [*tables, columns_taken(columns), *found.verdict, *unwritten]


def _left_behind(out: Path) -> str:
    """Say that a scenario which is there already is none of this log; it stays, as it may have been edited."""
    there = [name for name in (SCENARIO, REFERENCE) if (out / name).exists()]
    if not there:
        return ""
    verb = "is" if len(there) == 1 else "are"
    return f". The {' and '.join(there)} in {out} {verb} of an earlier log, not of this one"


def _of_current(found: "LogIdentification") -> list[str]:
    """Warn that a scenario is in amperes where compare and simulate read newtons."""
    from adaptive_ff.identify.units import LINEAR, ROTARY, is_linear, is_of_current

    if not is_of_current(found.units):
        return []
    taken = LINEAR if is_linear(found.units) else ROTARY
    return [
        f"the torque of the log is a current, so {SCENARIO} has A and {found.units['inertia']} where it says "
        f"{taken['torque']} and {taken['inertia']}; for these give --torque-constant, in {taken['torque']}/A"
    ]


def _print(found: "LogIdentification", shown: "list[Table | str]", out: Path, refused: str | None) -> None:
    errors = error_console()
    warn(errors, [*found.cautions, *([] if refused else _of_current(found))])
    warn_of_skips(errors, found.skipped, "identification.json")
    console = Printer()
    console.show(shown)
    scenario = "" if refused else f", {SCENARIO} and {REFERENCE}"
    console.say(f"Plots, identification.json{scenario} are in {out}")
