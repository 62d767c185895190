"""Command ``adaptive-ff excite``."""

from pathlib import Path
from typing import Annotated

import typer

from adaptive_ff.cli.options import OUT, Formats, JsonCopy, Report, ScenarioFile, picture_formats
from adaptive_ff.cli.places import places
from adaptive_ff.cli.terminal import Printer, announce_compilation, error_console, progress_bars

LimitOption = float | None


def excite_command(
    scenario: ScenarioFile = None,
    period: Annotated[float, typer.Option(help="Length of the motion, s.")] = 10.0,
    position: Annotated[
        LimitOption, typer.Option(help="Largest distance from the start, rad; none if not given.")
    ] = None,
    velocity: Annotated[LimitOption, typer.Option(help="Largest velocity, rad/s; chosen if not given.")] = None,
    acceleration: Annotated[LimitOption, typer.Option(help="Largest acceleration, rad/s^2.")] = None,
    torque: Annotated[LimitOption, typer.Option(help="Largest torque, N m; 0.7 of the drive's if not given.")] = None,
    fastest: Annotated[
        LimitOption, typer.Option(help="Largest frequency, Hz; 4 or 0.4 of the loop's bandwidth if not given.")
    ] = None,
    out: Annotated[Path, typer.Option(help="Folder for excitation.csv, .toml, .json and the picture.")] = OUT,
    json: JsonCopy = None,
    formats: Formats = "png",
    report: Report = False,
) -> None:
    """Find a motion that makes the parameters of a joint identifiable, within its limits. Takes minutes."""
    from adaptive_ff.files import write_csv, write_result
    from adaptive_ff.report.drawing import write_stamped
    from adaptive_ff.report.excitation_plot import plot_excitation
    from adaptive_ff.report.excitation_table import intervals_table, motion_table
    from adaptive_ff.report.html_page import NAME, write_report
    from adaptive_ff.scenario.file import to_toml, toml_text
    from adaptive_ff.scenario.scenario import load_scenario
    from adaptive_ff.simulation.loop import run_in_memory
    from adaptive_ff.studies.exciting_motion import default_limits, exciting_motion

    drawn = picture_formats(formats)
    loaded, errors = load_scenario(scenario), error_console()
    linear = loaded.joint.axis == "linear"
    with places(out, json) as (stage, beside):
        limits = default_limits(loaded, position=position, velocity=velocity, acceleration=acceleration, torque=torque)
        announce_compilation(errors, run_in_memory)
        with progress_bars(errors) as progress:
            task = progress.add_task("motions", total=1.0)
            motion = exciting_motion(
                loaded,
                limits,
                period=period,
                fastest=fastest,
                workers=None,
                progress=lambda share: progress.update(task, completed=share),
            )
        write_csv(stage / "excitation.csv", motion.columns(loaded.sampling.period))
        content = {"reference": motion.reference.model_dump()}
        (stage / "excitation.toml").write_text(toml_text(content), encoding="utf-8")
        pictures = {"excitation": plot_excitation(motion, linear=linear)}
        source = str(scenario or "built-in scenario")
        shown = [motion_table(motion, linear=linear), intervals_table(motion)]
        write_stamped(pictures, stage, drawn, source)
        if report:
            write_report(stage / NAME, f"Exciting motion for {source}", shown, pictures, {"Scenario": to_toml(loaded)})
        for file in (stage / "excitation.json", *beside.values()):
            write_result(file, motion.to_dict())
    console = Printer()
    console.show(shown)
    console.say(f"excitation.csv, the table [reference] in excitation.toml, and the picture are in {out}")
