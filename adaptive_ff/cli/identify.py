"""Commands for recorded data: ``adaptive-ff identify``, and beside it ``adaptive-ff replay``."""

import os
import warnings
from contextlib import ExitStack
from pathlib import Path
from typing import Annotated

import typer
from rich.console import Console

from adaptive_ff.cli.columns import chosen_columns, read_columns
from adaptive_ff.cli.replay import replay_command
from adaptive_ff.cli.terminal import Printer
from adaptive_ff.errors import InputError
from adaptive_ff.identify.identification import HELD_OUT, identify_log
from adaptive_ff.identify.result import LogIdentification
from adaptive_ff.identify.scenario_text import reference_columns, scenario_text
from adaptive_ff.logs.columns import read_scales
from adaptive_ff.report.files import staged, write_csv, write_json
from adaptive_ff.report.parameter_tables import parameters_table
from adaptive_ff.scenario.scenario import load_scenario

SCENARIO, REFERENCE = "scenario.toml", "reference.csv"
"""Files of the identified joint."""

LONGEST_LIST = 10
"""Most skipped pieces that are printed; the JSON holds all."""


def register(app: typer.Typer) -> None:
    """Add the commands to the application."""
    app.command("identify")(identify_command)
    app.command("replay")(replay_command)


def identify_command(
    log: Annotated[Path, typer.Argument(help="CSV, NPZ, MAT, HDF5 or Parquet file.", show_default=False)],
    time: Annotated[str | None, typer.Option(help="Column of the time, s.")] = None,
    period: Annotated[float | None, typer.Option(help="Constant sample time, s, instead of a column.")] = None,
    position: Annotated[str | None, typer.Option(help="Column of the position, rad; NAME[3] is a table's 4th.")] = None,
    velocity: Annotated[str | None, typer.Option(help="Column of the velocity, rad/s, instead of a position.")] = None,
    torque: Annotated[str | None, typer.Option(help="Column of the drive's torque, N m.")] = None,
    scale: Annotated[
        list[str] | None, typer.Option(help="NAME=FACTOR for a column in other units, such as q=pi/180 or u=-1/48.")
    ] = None,
    bandwidth: Annotated[float | None, typer.Option(help="Band of the regression, Hz; chosen if not given.")] = None,
    held_out: Annotated[float, typer.Option(help="Share of the log, at its end, to validate on.")] = HELD_OUT,
    validate: Annotated[
        Path | None, typer.Option(help="Another log, of the same columns, to validate on; all of LOG is then fitted.")
    ] = None,
    torque_delay: Annotated[
        float, typer.Option(help="Time after its stamp at which a torque acts, s; half a period where it is held.")
    ] = 0.0,
    linear: Annotated[bool, typer.Option("--linear", help="A linear axis: units are m, N and kg.")] = False,
    out: Annotated[Path, typer.Option(help="Folder for plots, identification.json and a scenario.")] = Path("results"),
    json: Annotated[Path | None, typer.Option(help="Write the result there, too.")] = None,
) -> None:
    """Identify inertia and friction of a joint from a recorded log."""
    scales = read_scales(scale or [])
    columns = chosen_columns(log, time, period, position, velocity, torque)
    given = read_columns(log, columns, period, scales)
    other = None if validate is None else read_columns(validate, columns, period, scales)
    with ExitStack() as stack:
        beside = None if json is None else stack.enter_context(staged(json.parent))
        stage = stack.enter_context(staged(out))
        if json is not None and os.path.isdir(json):
            raise InputError(f"{json}: cannot be written: it is a folder")
        found = identify_log(
            given,
            bandwidth=bandwidth,
            held_out=held_out,
            validation=other,
            torque_delay=torque_delay,
            linear=linear,
        )
        refused = _write_scenario(found, stage)
        found.plot(stage)
        result = {**found.to_dict(), "scenario": SCENARIO if refused is None else None}
        write_json(stage / "identification.json", result)
        if json is not None and beside is not None:
            write_json(beside / json.name, result)
    _print(found, out, refused)


def _write_scenario(found: LogIdentification, stage: Path) -> str | None:
    """Write the scenario and its reference; where it cannot be, say why."""
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


def _print(found: LogIdentification, out: Path, refused: str | None) -> None:
    errors = Console(stderr=True, soft_wrap=True, highlight=False)
    for caution in found.cautions:
        errors.print(f"warning: {caution}", markup=False)
    for skip in found.skipped[:LONGEST_LIST]:
        errors.print(f"warning: skipped: samples {skip.start} to {skip.stop}: {skip.reason}", markup=False)
    if len(found.skipped) > LONGEST_LIST:
        errors.print(f"warning: skipped: {len(found.skipped) - LONGEST_LIST} more, listed in identification.json")
    console = Printer()
    console.print(parameters_table(found))
    for sentence in found.verdict:
        console.print(sentence, highlight=False, markup=False)
    if refused is not None:
        console.print(f"No scenario is written: {refused}", highlight=False, markup=False)
    console.print(
        f"Plots, identification.json{'' if refused else f', {SCENARIO} and {REFERENCE}'} are in {out}",
        highlight=False,
        markup=False,
        soft_wrap=True,
    )
