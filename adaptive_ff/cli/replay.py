"""Command ``adaptive-ff replay``."""

import os
from contextlib import ExitStack
from pathlib import Path
from typing import Annotated

import typer
from rich.console import Console
from rich.progress import BarColumn, Progress, TextColumn, TimeRemainingColumn

from adaptive_ff.cli.columns import chosen_columns, read_columns
from adaptive_ff.cli.terminal import Printer
from adaptive_ff.errors import InputError
from adaptive_ff.logs.columns import read_scales
from adaptive_ff.logs.log import Log
from adaptive_ff.replay.parts import RECORDED, REFERENCE_POSITION, REFERENCE_VELOCITY
from adaptive_ff.replay.replay import BAND, replay_log
from adaptive_ff.replay.result import Replay
from adaptive_ff.replay.state import read_state
from adaptive_ff.replay.watching import watch
from adaptive_ff.report.files import staged, write_json
from adaptive_ff.report.replay_table import left_table
from controllers import is_cached

LONGEST_LIST = 10
"""Most skipped pieces that are printed; the JSON holds all."""


def replay_command(
    log: Annotated[Path, typer.Argument(help="CSV, NPZ, MAT, HDF5 or Parquet file.", show_default=False)],
    time: Annotated[str | None, typer.Option(help="Column of the time, s.")] = None,
    period: Annotated[float | None, typer.Option(help="Constant sample time, s, instead of a column.")] = None,
    position: Annotated[str | None, typer.Option(help="Column of the position, rad; NAME[3] is a table's 4th.")] = None,
    velocity: Annotated[str | None, typer.Option(help="Column of the velocity, rad/s, instead of a position.")] = None,
    torque: Annotated[str | None, typer.Option(help="Column of the drive's torque, N m.")] = None,
    reference_velocity: Annotated[str | None, typer.Option(help="Column of the reference velocity, rad/s.")] = None,
    reference_position: Annotated[
        str | None, typer.Option(help="Column of the reference position, rad, instead of a velocity.")
    ] = None,
    feedforward: Annotated[
        str | None, typer.Option(help="Column of the feedforward that the machine had, N m, to compare with.")
    ] = None,
    scale: Annotated[
        list[str] | None, typer.Option(help="NAME=FACTOR for a column in other units, such as q=pi/180 or u=-1/48.")
    ] = None,
    inertia: Annotated[
        float | None, typer.Option(help="Inertia that the controller is told, kg m^2; that of the fixed model if not.")
    ] = None,
    stribeck_velocity: Annotated[float | None, typer.Option(help="Stribeck velocity that it is told, rad/s.")] = None,
    memory: Annotated[float | None, typer.Option(help="Its memory, s of sliding motion; 5 if not given.")] = None,
    identify: Annotated[
        str | None,
        typer.Option(help="What it identifies: symmetric, offset (if not given) or directions (all friction by them)."),
    ] = None,
    loop_bandwidth: Annotated[
        float | None, typer.Option(help="Crossover of its loop, Hz; 10, or a tenth of the sampling frequency.")
    ] = None,
    rest_speed: Annotated[
        float | None, typer.Option(help="The reference rests below this speed, rad/s; 0.005 of its largest.")
    ] = None,
    torque_delay: Annotated[
        float | None,
        typer.Option(help="Time after its stamp at which a torque acts, s; half a period where it is held."),
    ] = None,
    velocity_cutoff: Annotated[
        float | None, typer.Option(help="Low-pass behind differences of the position, Hz; none if not given.")
    ] = None,
    bandwidth: Annotated[float | None, typer.Option(help="Band in which the fixed model is fitted, Hz.")] = None,
    band: Annotated[float, typer.Option(help="Band in which torques are judged, Hz.")] = BAND,
    state: Annotated[Path | None, typer.Option(help="State to start from, as --save-state wrote it.")] = None,
    save_state: Annotated[Path | None, typer.Option(help="Write the state at the end there.")] = None,
    linear: Annotated[bool, typer.Option("--linear", help="A linear axis: units are m, N and kg.")] = False,
    out: Annotated[Path, typer.Option(help="Folder for plots and replay.json.")] = Path("results"),
    json: Annotated[Path | None, typer.Option(help="Write the result there, too.")] = None,
) -> None:
    """Replay a recorded log, and show which torque adaptive feedforward would have left to the feedback."""
    if reference_velocity is not None and reference_position is not None:
        raise InputError("--reference-velocity and --reference-position are both given; give one of them")
    columns = chosen_columns(log, time, period, position, velocity, torque)
    named = {
        REFERENCE_VELOCITY: reference_velocity,
        REFERENCE_POSITION: reference_position,
        RECORDED: feedforward,
    }
    extra = {name: column for name, column in named.items() if column is not None}
    given = read_columns(log, columns, period, read_scales(scale or []), extra)
    saved = None if state is None else read_state(state)
    errors = Console(stderr=True, soft_wrap=True, highlight=False)
    with ExitStack() as stack:
        places = {path: stack.enter_context(staged(path.parent)) for path in (json, save_state) if path is not None}
        stage = stack.enter_context(staged(out))
        for path in places:
            if os.path.isdir(path):
                raise InputError(f"{path}: cannot be written: it is a folder")
        found = _run(
            given,
            errors,
            inertia=inertia,
            stribeck_velocity=stribeck_velocity,
            memory=memory,
            identify=identify,
            loop_bandwidth=loop_bandwidth,
            rest_speed=rest_speed,
            torque_delay=torque_delay,
            velocity_cutoff=velocity_cutoff,
            bandwidth=bandwidth,
            band=band,
            state=saved,
            linear=linear,
        )
        found.plot(stage)
        write_json(stage / "replay.json", found.to_dict())
        if json is not None:
            write_json(places[json] / json.name, found.to_dict())
        if save_state is not None:
            (places[save_state] / save_state.name).write_text(found.state_to_json(), encoding="utf-8")
    _print(found, errors, out)


def _run(log: Log, errors: Console, **options: object) -> Replay:
    if not is_cached(watch):
        errors.print("First run on this machine: the controllers are compiled, once (some 15 to 30 s).")
    columns = (TextColumn("{task.description}"), BarColumn(), TimeRemainingColumn())
    with Progress(*columns, console=errors, transient=True, disable=not errors.is_terminal) as progress:
        task = progress.add_task("replay", total=1.0)
        return replay_log(log, progress=lambda share: progress.update(task, completed=share), **options)  # type: ignore[arg-type]


def _print(found: Replay, errors: Console, out: Path) -> None:
    for skip in found.skipped[:LONGEST_LIST]:
        errors.print(f"warning: skipped: samples {skip.start} to {skip.stop}: {skip.reason}", markup=False)
    if len(found.skipped) > LONGEST_LIST:
        errors.print(f"warning: skipped: {len(found.skipped) - LONGEST_LIST} more, listed in replay.json")
    console = Printer()
    console.print(left_table(found))
    for note in found.notes:
        console.print(note, highlight=False, markup=False)
    for name, estimates in found.estimates.items():
        shown = ", ".join(f"{key} {value:.4g}" for key, value in estimates.items())
        console.print(f"Estimates at the end, {name}: {shown}", highlight=False, markup=False)
    console.print(f"Plots and replay.json are in {out}", highlight=False, markup=False, soft_wrap=True)
