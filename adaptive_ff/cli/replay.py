"""Command ``adaptive-ff replay``."""

from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer
from rich.console import Console

from adaptive_ff.cli.columns import chosen_columns, column_factors, columns_taken, read_columns
from adaptive_ff.cli.options import (
    OUT,
    Formats,
    JsonCopy,
    KnownTorque,
    Linear,
    LogFile,
    Period,
    Position,
    Report,
    Scale,
    Time,
    Torque,
    TorqueConstant,
    TorqueDelay,
    Velocity,
    picture_formats,
)
from adaptive_ff.cli.places import places
from adaptive_ff.cli.terminal import Printer, announce_compilation, error_console, progress_bars, warn_of_skips
from adaptive_ff.errors import InputError

if TYPE_CHECKING:
    from rich.table import Table

    from adaptive_ff.logs.log import Log
    from adaptive_ff.replay.result import Replay

BAND = 20.0
"""Default of ``--band``, Hz; that of ``replay_log``, which the tests compare."""


def replay_command(
    log: LogFile,
    time: Time = None,
    period: Period = None,
    position: Position = None,
    velocity: Velocity = None,
    torque: Torque = None,
    known_torque: KnownTorque = None,
    torque_constant: TorqueConstant = None,
    reference_velocity: Annotated[str | None, typer.Option(help="Column of the reference velocity, rad/s.")] = None,
    reference_position: Annotated[
        str | None, typer.Option(help="Column of the reference position, rad, instead of a velocity.")
    ] = None,
    feedforward: Annotated[
        str | None, typer.Option(help="Column of the feedforward that the machine had, N m, to compare with.")
    ] = None,
    scale: Scale = None,
    inertia: Annotated[
        float | None,
        typer.Option(help="Inertia that the controller assumes, kg m^2; that of the fixed model if not given."),
    ] = None,
    stribeck_velocity: Annotated[float | None, typer.Option(help="Stribeck velocity that it assumes, rad/s.")] = None,
    memory: Annotated[float | None, typer.Option(help="Its memory, s of sliding motion; 5 if not given.")] = None,
    identify: Annotated[
        str | None,
        typer.Option(
            help="What it identifies: symmetric, offset (if not given), directions (all friction by them), gravity or "
            "directions_and_gravity."
        ),
    ] = None,
    ripple_period: Annotated[
        list[float] | None,
        typer.Option(
            help="Period of a torque over the position that it identifies, rad; those of the fixed model if not given. "
            "May be given several times."
        ),
    ] = None,
    loop_bandwidth: Annotated[
        float | None, typer.Option(help="Crossover of its loop, Hz; 10, or a tenth of the sampling frequency.")
    ] = None,
    rest_speed: Annotated[
        float | None, typer.Option(help="The reference rests below this speed, rad/s; 0.005 of its largest.")
    ] = None,
    start_path: Annotated[
        float | None,
        typer.Option(help="A slower one that speeds up moves from this path on, rad; the noise of the position."),
    ] = None,
    torque_delay: TorqueDelay = None,
    velocity_cutoff: Annotated[
        float | None, typer.Option(help="Low-pass behind differences of the position, Hz; where its noise asks for it.")
    ] = None,
    velocity_lag: Annotated[
        float | None, typer.Option(help="Time by which the velocity lags, s; that of these, zero where it is measured.")
    ] = None,
    motion_lead: Annotated[
        float | None,
        typer.Option(help="Time by which the motion runs ahead of the reference, s; that of the log, if distinct."),
    ] = None,
    bandwidth: Annotated[float | None, typer.Option(help="Band in which the fixed model is fitted, Hz.")] = None,
    band: Annotated[float, typer.Option(help="Band in which torques are judged, Hz.")] = BAND,
    state: Annotated[Path | None, typer.Option(help="State to start from, as --save-state wrote it.")] = None,
    save_state: Annotated[Path | None, typer.Option(help="Write the state at the end there.")] = None,
    linear: Linear = False,
    out: Annotated[Path, typer.Option(help="Folder for plots and replay.json.")] = OUT,
    json: JsonCopy = None,
    formats: Formats = "png",
    report: Report = False,
) -> None:
    """Replay a recorded log, and show which torque adaptive feedforward would have left to the feedback."""
    from adaptive_ff.files import write_result
    from adaptive_ff.replay.parts import RECORDED, REFERENCE_POSITION, REFERENCE_VELOCITY
    from adaptive_ff.replay.state import read_state
    from adaptive_ff.report.drawing import write_figures
    from adaptive_ff.report.html_page import NAME, write_report

    drawn = picture_formats(formats)
    if reference_velocity is not None and reference_position is not None:
        raise InputError("--reference-velocity and --reference-position are both given; give one of them")
    columns = chosen_columns(log, time, period, position, velocity, torque, known_torque)
    named = {
        REFERENCE_VELOCITY: reference_velocity,
        REFERENCE_POSITION: reference_position,
        RECORDED: feedforward,
    }
    extra = {name: column for name, column in named.items() if column is not None}
    scales, is_current = column_factors(log, columns, scale or [], torque_constant, linear=linear, further=extra)
    given = read_columns(log, columns, period, scales, extra)
    saved = None if state is None else read_state(state)
    errors = error_console()
    with places(out, json, save_state) as (stage, beside):
        found = _run(
            given,
            errors,
            inertia=inertia,
            stribeck_velocity=stribeck_velocity,
            memory=memory,
            identify=identify,
            ripple_periods=None if ripple_period is None else tuple(ripple_period),
            loop_bandwidth=loop_bandwidth,
            rest_speed=rest_speed,
            start_path=start_path,
            torque_delay=torque_delay,
            velocity_cutoff=velocity_cutoff,
            velocity_lag=velocity_lag,
            motion_lead=motion_lead,
            bandwidth=bandwidth,
            band=band,
            state=saved,
            linear=linear,
            is_current=is_current,
        )
        figures, shown = found.plot(None), _shown(found, columns)
        write_figures(figures, stage, drawn)
        if report:
            write_report(stage / NAME, f"Replay of {log}", shown, figures)
        for file in (stage / "replay.json", *([beside[json]] if json is not None else [])):
            write_result(file, {**found.to_dict(), "columns": columns})
        if save_state is not None:
            beside[save_state].write_text(found.state_to_json(), encoding="utf-8")
    warn_of_skips(errors, found.skipped, "replay.json")
    console = Printer()
    console.show(shown)
    console.say(f"Plots and replay.json are in {out}")


def _run(log: "Log", errors: Console, **options: object) -> "Replay":
    from adaptive_ff.replay.replay import replay_log
    from adaptive_ff.replay.watching import watch

    announce_compilation(errors, watch)
    with progress_bars(errors) as progress:
        task = progress.add_task("replay", total=1.0)
        return replay_log(log, progress=lambda share: progress.update(task, completed=share), **options)  # type: ignore[arg-type]


def _shown(found: "Replay", columns: dict[str, str]) -> "list[Table | str]":
    from adaptive_ff.report.replay_table import left_table

    sentences = [columns_taken(columns), *found.notes]
    for name, estimates in found.estimates.items():
        values = ", ".join(f"{key} {value:.4g} {found.units[key]}" for key, value in estimates.items())
        sentences.append(f"Estimates at the end, {name}: {values}")
    return [left_table(found), *sentences]
