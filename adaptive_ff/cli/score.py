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
from adaptive_ff.cli.terminal import Printer, announce_compilation, error_console, progress_bars, warn

if TYPE_CHECKING:
    from adaptive_ff.identify.open_loop.score import Score


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
    """Train a model on one log and simulate another one from its torque alone, in open loop. Takes minutes."""
    from adaptive_ff.files import write_result
    from adaptive_ff.identify.open_loop.score import score_log
    from adaptive_ff.identify.open_loop.slopes import follow_with_slopes
    from adaptive_ff.logs.columns import read_scales, with_units
    from adaptive_ff.report.drawing import write_figures
    from adaptive_ff.report.html_page import NAME, write_report

    drawn = picture_formats(formats)
    columns = chosen_columns(train, time, period, position, None, torque, known_torque)
    scales = read_scales(scale or [])
    motion = {role: column for role, column in columns.items() if role in ("time", "position")}
    warn_of_units(with_units(train, motion), motion, scales, linear=linear)  # the torque may have any unit
    logs = [read_columns(path, columns, period, scales) for path in (train, test)]
    errors = error_console()
    with places(out, json) as (stage, beside):
        announce_compilation(errors, follow_with_slopes)
        with progress_bars(errors) as progress:
            task = progress.add_task("score", total=1.0)
            score = score_log(
                *logs,
                linear=linear,
                torque_delay=torque_delay or 0.0,
                position_periods=known_periods(position_period, gear_ratio),
                position_hats=position_hats,
                progress=lambda share: progress.update(task, completed=share),
            )
        figures, shown = score.plot(None), _sentences(score, columns, train, test, linear)
        write_figures(figures, stage, drawn)
        if report:
            write_report(stage / NAME, f"Model of {train}, simulated on {test}", shown, figures)
        for file in (stage / "score.json", *beside.values()):
            write_result(file, {**score.to_dict(), "columns": columns})
    warn(errors, score.cautions)
    console = Printer()
    console.show(shown)
    console.say(f"score.json and its picture are in {out}")


def _sentences(score: "Score", columns: dict[str, str], train: Path, test: Path, linear: bool) -> list[str]:
    unit = "mm" if linear else "mrad"
    best = score.chosen
    explained = [score.explanation] if score.explanation else []
    mapped = f", friction over position ({best.mapped} coefficients)" if best.mapped else ""
    return [
        columns_taken(columns),
        f"Mean of {len(best.structures)} models of {train}: viscous friction by direction in {best.by_direction:.0%} "
        f"of it{mapped}; {best.parameters:.3g} parameters in effect, {1e3 * best.error:.3g} {unit} rms on what was "
        "held out.",
        f"Open loop on {test}: {1e3 * score.rms:.3g} {unit} rms, fit {score.fit:.4g} %; in windows of 1 s "
        f"{1e3 * score.windows:.3g} {unit} rms. The whole log of the training: {1e3 * score.training_rms:.3g} {unit}.",
        *explained,
    ]
