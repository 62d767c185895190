"""Command ``adaptive-ff identify``."""

import os
import warnings
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from adaptive_ff.cli.columns import chosen_columns, column_factors, columns_taken, read_columns
from adaptive_ff.cli.options import (
    OUT,
    Details,
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
    Resistance,
    Scale,
    Time,
    Torque,
    TorqueConstant,
    TorqueDelay,
    Velocity,
    Voltage,
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
    held_out: Annotated[
        float, typer.Option(help="Share of the log, at its end, that is validated on instead of fitted.")
    ] = 0.0,
    validate: Annotated[Path | None, typer.Option(help="Another log, of the same columns, to validate on.")] = None,
    torque_delay: TorqueDelay = None,
    torque_constant: TorqueConstant = None,
    voltage: Voltage = None,
    resistance: Resistance = None,
    model: Annotated[
        str,
        typer.Option(
            help="Terms: coulomb-viscous, symmetric, offset, directions, gravity or gravity-directions; auto takes "
            "gravity where it takes torque. All but coulomb-viscous may be refined."
        ),
    ] = "auto",
    position_period: PositionPeriod = None,
    gear_ratio: GearRatio = None,
    position_hats: PositionHats = 0,
    load_friction: LoadFriction = False,
    linear: Linear = False,
    write: Annotated[
        str, typer.Option(help="Files for simulators as well: mjcf, urdf, isaac, drake, or several: mjcf,urdf.")
    ] = "",
    details: Details = False,
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

    drawn, simulators = picture_formats(formats), _simulators(write)
    columns = chosen_columns(log, time, period, position, velocity, voltage or torque, known_torque)
    if voltage is not None and torque is not None:
        raise InputError("--voltage and --torque are both given; give one of them")
    scales, is_current = column_factors(
        log, columns, scale or [], torque_constant, linear=linear, resistance=resistance, is_voltage=voltage is not None
    )
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
        files = _write_simulators(found, stage, simulators)
        figures = found.plot(None)
        notes = [*_of_voltage(torque_constant, resistance, voltage, linear), *([] if refused else _of_current(found))]
        shown = _shown(found, columns, refused, out, details=details)
        write_figures(figures, stage, drawn)
        if report:
            scenario = {} if refused else {SCENARIO: (stage / SCENARIO).read_text(encoding="utf-8")}
            write_report(stage / NAME, f"Joint identified from {log}", shown, figures, scenario)
        result = {**found.to_dict(), "columns": columns, "scenario": SCENARIO if refused is None else None}
        for file in (stage / "identification.json", *beside.values()):
            write_result(file, result)
        earlier = of_earlier_runs(out, stage, PICTURES, [NAME])
    errors, console = error_console(), Printer()
    warn(errors, [*found.cautions, *notes])
    warn_of_skips(errors, found.skipped, "identification.json")
    console.show(shown)
    made = "" if refused else f", {SCENARIO}, {REFERENCE}"
    console.say(f"Plots, identification.json{made}{''.join(f', {file}' for file in files)} are in {out}")
    console.show(earlier)


def _simulators(text: str) -> list[str]:
    """Return the simulators that ``--write`` names."""
    from adaptive_ff.identify.simulators import SIMULATORS

    names = list(dict.fromkeys(part.strip().lower() for part in text.split(",") if part.strip()))
    for name in names:
        if name not in SIMULATORS:
            raise InputError(f"--write {name} is not known; allowed: {', '.join(SIMULATORS)}")
    return names


def _write_simulators(found: "LogIdentification", stage: Path, simulators: list[str]) -> list[str]:
    from adaptive_ff.identify.simulators import ENDINGS

    for name in simulators:
        (stage / ENDINGS[name]).write_text(found.simulator(name), encoding="utf-8")
    return [ENDINGS[name] for name in simulators]


def _write_scenario(found: "LogIdentification", stage: Path) -> str | None:
    """Write the scenario and its reference; where it cannot be, say why."""
    from adaptive_ff.files import write_csv
    from adaptive_ff.identify.scenario_text import reference_columns, scenario_text
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


def _shown(
    found: "LogIdentification", columns: dict[str, str], refused: str | None, out: Path, *, details: bool
) -> "list[Table | str]":
    from adaptive_ff.report.parameter_tables import details as explained
    from adaptive_ff.report.parameter_tables import map_table, next_step, parameters_table, verdict_lines

    unwritten = [] if refused is None else [f"No scenario is written: {refused}{_left_behind(out)}"]
    tables = [table for table in (parameters_table(found), map_table(found)) if table is not None]
    step = next_step(found, str(out), written=refused is None)
    further = explained(found) if details else []
    return [*tables, columns_taken(columns), *verdict_lines(found), *unwritten, step, *further]


def _left_behind(out: Path) -> str:
    """Say that a scenario which is there already is none of this log; it stays, as it may have been edited."""
    there = [name for name in (SCENARIO, REFERENCE) if (out / name).exists()]
    if not there:
        return ""
    verb = "is" if len(there) == 1 else "are"
    return f". The {' and '.join(there)} in {out} {verb} of an earlier log, not of this one"


def _of_current(found: "LogIdentification") -> list[str]:
    """Warn that a scenario is in amperes where compare and simulate read newtons."""
    if found.units["torque"] != "A":
        return []
    torque = "N" if found.linear else "N m"
    return [
        f"the torque of the log is a current, so {SCENARIO} has A and {found.units['inertia']} where it says {torque} "
        f"and {'kg' if found.linear else 'kg m²'}; for these give --torque-constant, in {torque}/A"
    ]


def _of_voltage(constant: float | None, resistance: float | None, voltage: str | None, linear: bool) -> list[str]:
    """Say how much of the viscous coefficient is the back-EMF."""
    if voltage is None or constant is None or resistance is None:
        return []
    unit = "N s/m" if linear else "N m s/rad"
    return [f"the torque is that of a voltage: {constant**2 / resistance:.4g} {unit} of viscous are the back-EMF"]
