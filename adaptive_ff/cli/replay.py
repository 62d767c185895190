"""Command ``adaptive-ff replay``."""

from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

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
from adaptive_ff.cli.terminal import Printer, announce_compilation, error_console, warn_of_skips
from adaptive_ff.errors import InputError

if TYPE_CHECKING:
    from rich.table import Table

    from adaptive_ff.replay.replay import Replay

BAND = 20.0
"""Default of ``--band``; that of ``replay_log``, which the tests compare."""

REPLACED = {
    "reference_velocity": "columns run along the measured motion; leave it out",
    "reference_position": "columns run along the measured motion; leave it out",
    "loop_bandwidth": "--band is that of the response as well",
    "rest_speed": "standstill is told by the noise of the motion",
    "start_path": "standstill is told by the noise of the motion",
    "velocity_cutoff": "--band is that of the motion as well",
    "velocity_lag": "the motion is filtered without delay",
    "motion_lead": "columns run along the measured motion, which leads nothing",
}
"""Options of former versions, and what stands in their place."""


def _former(name: str) -> Any:
    """Return an option that is taken only to say what replaces it."""
    return typer.Option(f"--{name.replace('_', '-')}", hidden=True)


def replay_command(
    log: LogFile,
    time: Time = None,
    period: Period = None,
    position: Position = None,
    velocity: Velocity = None,
    torque: Torque = None,
    known_torque: KnownTorque = None,
    torque_constant: TorqueConstant = None,
    feedforward: Annotated[
        str | None, typer.Option(help="Column of the feedforward that the machine had, N m, to compare with.")
    ] = None,
    scale: Scale = None,
    inertia: Annotated[float | None, typer.Option(help="Inertia that is assumed, kg m^2; learnt if not given.")] = None,
    stribeck_velocity: Annotated[float | None, typer.Option(help="Stribeck velocity that is assumed, rad/s.")] = None,
    memory: Annotated[float | None, typer.Option(help="Memory, s of sliding motion; 5 if not given.")] = None,
    identify: Annotated[
        str,
        typer.Option(help="What is learnt: symmetric, offset, directions, gravity or directions_and_gravity."),
    ] = "offset",
    ripple_period: Annotated[
        list[float] | None,
        typer.Option(help="Period of a torque over the position that is learnt, rad. May be given several times."),
    ] = None,
    torque_delay: TorqueDelay = None,
    bandwidth: Annotated[float | None, typer.Option(help="Band in which the fixed model is fitted, Hz.")] = None,
    band: Annotated[float, typer.Option(help="Band in which torques are judged, Hz.")] = BAND,
    state: Annotated[Path | None, typer.Option(help="State to start from, as --save-state wrote it.")] = None,
    save_state: Annotated[Path | None, typer.Option(help="Write the state at the end there.")] = None,
    linear: Linear = False,
    out: Annotated[Path, typer.Option(help="Folder for plots and replay.json.")] = OUT,
    json: JsonCopy = None,
    formats: Formats = "png",
    report: Report = False,
    reference_velocity: Annotated[str | None, _former("reference_velocity")] = None,
    reference_position: Annotated[str | None, _former("reference_position")] = None,
    loop_bandwidth: Annotated[str | None, _former("loop_bandwidth")] = None,
    rest_speed: Annotated[str | None, _former("rest_speed")] = None,
    start_path: Annotated[str | None, _former("start_path")] = None,
    velocity_cutoff: Annotated[str | None, _former("velocity_cutoff")] = None,
    velocity_lag: Annotated[str | None, _former("velocity_lag")] = None,
    motion_lead: Annotated[str | None, _former("motion_lead")] = None,
) -> None:
    """Replay a recorded log, and show which torque adaptive feedforward would have left to the feedback."""
    from adaptive_ff.files import write_result
    from adaptive_ff.replay.learning import learn_in_place
    from adaptive_ff.replay.replay import FEEDFORWARD, read_state, replay_log
    from adaptive_ff.report.drawing import write_figures
    from adaptive_ff.report.html_page import NAME, write_report

    given_former = locals()
    for name, instead in REPLACED.items():
        if given_former[name] is not None:
            raise InputError(f"--{name.replace('_', '-')} is no longer taken: {instead}")
    drawn = picture_formats(formats)
    columns = chosen_columns(log, time, period, position, velocity, torque, known_torque)
    extra = {} if feedforward is None else {FEEDFORWARD: feedforward}
    scales, is_current = column_factors(log, columns, scale or [], torque_constant, linear=linear, further=extra)
    given = read_columns(log, columns, period, scales, extra)
    saved = None if state is None else read_state(state)
    errors = error_console()
    with places(out, json, save_state) as (stage, beside):
        announce_compilation(errors, learn_in_place)
        found = replay_log(
            given,
            inertia=inertia,
            stribeck_velocity=stribeck_velocity,
            memory=memory,
            identify=identify,
            ripple_periods=tuple(ripple_period or ()),
            torque_delay=torque_delay,
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


def _shown(found: "Replay", columns: dict[str, str]) -> "list[Table | str]":
    from adaptive_ff.report.replay_table import left_table

    sentences = [columns_taken(columns), *found.notes]
    for name, estimates in found.estimates.items():
        values = ", ".join(f"{key} {value:.4g} {found.units[key]}" for key, value in estimates.items())
        sentences.append(f"Estimates at the end, {name}: {values}")
    return [left_table(found), *sentences]
