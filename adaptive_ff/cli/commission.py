"""Command ``adaptive-ff commission``."""

from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer
from rich.progress import Progress
from rich.table import Table

from adaptive_ff.cli.columns import chosen_columns, column_factors, columns_taken, read_columns
from adaptive_ff.cli.options import (
    Formats,
    JsonCopy,
    KnownTorque,
    Report,
    Scale,
    ScenarioFile,
    TorqueConstant,
    TorqueDelay,
    picture_formats,
)
from adaptive_ff.cli.places import places
from adaptive_ff.cli.terminal import Printer, announce_compilation, error_console, progress_bars, warn
from adaptive_ff.errors import InputError

if TYPE_CHECKING:
    from matplotlib.figure import Figure

    from adaptive_ff.identify.result import LogIdentification
    from adaptive_ff.logs.log import Log
    from adaptive_ff.scenario.scenario import Scenario
    from adaptive_ff.studies.bandwidth_study import BandwidthStudy
    from adaptive_ff.studies.commissioning import Gain


def commission_command(
    scenario: ScenarioFile = None,
    log: Annotated[
        Path | None,
        typer.Option(
            help="Log of a real joint (CSV, NPZ, MAT, HDF5, Parquet or MCAP: time, position or velocity, torque or "
            "current) instead of a simulated recording."
        ),
    ] = None,
    time_column: Annotated[
        str | None, typer.Option("--time-column", "--time", help="Column of the log's time, s.")
    ] = None,
    position_column: Annotated[str | None, typer.Option(help="Column of its position, rad.")] = None,
    velocity_column: Annotated[
        str | None, typer.Option(help="Column of its velocity, rad/s, instead of a position.")
    ] = None,
    torque_column: Annotated[str | None, typer.Option(help="Column of its drive's torque, N m.")] = None,
    known_torque: KnownTorque = None,
    scale: Scale = None,
    torque_constant: TorqueConstant = None,
    torque_delay: TorqueDelay = None,
    period: Annotated[float, typer.Option(help="Period of the exciting motion, s.")] = 10.0,
    position: Annotated[
        float | None,
        typer.Option("--position", "--max-position", help="Largest distance of the motion from its start, rad."),
    ] = None,
    velocity: Annotated[
        float | None, typer.Option("--velocity", "--max-velocity", help="Largest velocity, rad/s; chosen if not given.")
    ] = None,
    acceleration: Annotated[
        float | None, typer.Option("--acceleration", "--max-acceleration", help="Largest acceleration, rad/s^2.")
    ] = None,
    torque: Annotated[
        float | None,
        typer.Option("--torque", "--max-torque", help="Largest torque, N m; 0.7 of the drive's if not given."),
    ] = None,
    out: Annotated[Path, typer.Option(help="Folder for all that is found.")] = Path("commissioned"),
    json: JsonCopy = None,
    formats: Formats = "png",
    report: Report = False,
) -> None:
    """Excite, identify, tune and write the scenario, in one go: the recipe for a real joint. Takes minutes."""
    from adaptive_ff.files import write_result
    from adaptive_ff.identify.identification import identify_log
    from adaptive_ff.report.bandwidth_tables import best_table
    from adaptive_ff.report.drawing import write_stamped
    from adaptive_ff.report.html_page import NAME, write_report
    from adaptive_ff.report.parameter_tables import parameters_table, verdict_lines
    from adaptive_ff.scenario.file import to_toml
    from adaptive_ff.scenario.scenario import load_scenario
    from adaptive_ff.simulation.loop import run_in_memory
    from adaptive_ff.studies.commissioning import gain_on_the_true_joint

    drawn, errors = picture_formats(formats), error_console()
    loaded, source = load_scenario(scenario), str(scenario or "built-in scenario")
    linear = loaded.joint.axis == "linear"
    columns = time_column, position_column, velocity_column, torque_column, known_torque
    given, taken = _given(log, columns, scale or [], torque_constant, torque_delay, linear=linear)
    with places(out, json) as (stage, beside):
        announce_compilation(errors, run_in_memory)
        with progress_bars(errors) as progress:
            pictures, gain = {}, None
            if given is None:
                limits = {"position": position, "velocity": velocity, "acceleration": acceleration, "torque": torque}
                given, pictures["excitation"] = _recorded(loaded, limits, period, stage, progress)
                torque_delay = 0.5 * loaded.sampling.period  # the torque of a row is held over the coming period
            found = identify_log(given, torque_delay=torque_delay, linear=linear)
            result, study = _tuned(loaded, found, progress)
            if log is None:
                gain = gain_on_the_true_joint(loaded, result, study)
        pictures |= found.plot(None) | {"tune": study.plot()}
        write_stamped(pictures, stage, drawn, source if log is None else str(log))
        shown: list[Table | str] = [parameters_table(found), best_table(study), *taken, *verdict_lines(found)]
        shown += _taken_from(source, found) if gain is None else _said(gain)
        if report:
            title = f"Commissioning of {source if log is None else log}"
            write_report(stage / NAME, title, shown, pictures, {"Scenario": to_toml(result)})
        (stage / "scenario.toml").write_text(to_toml(result), encoding="utf-8")
        summary = {
            "identification": found.to_dict(),
            "bandwidth": study.to_dict()["controllers"],
            "gain": None if gain is None else vars(gain),
            "scenario": result.model_dump(mode="json", exclude_none=True),
        }
        for target in (stage / "commission.json", *beside.values()):
            write_result(target, summary)
    warn(errors, found.cautions)
    console = Printer()
    console.show(shown)
    console.say(f"scenario.toml, ready for compare and export, commission.json and the pictures are in {out}")


def _given(
    log: Path | None,
    columns: tuple[str | None, ...],
    scale: list[str],
    torque_constant: float | None,
    torque_delay: float | None,
    *,
    linear: bool,
) -> "tuple[Log | None, list[str]]":
    """Read the log that is given, if one is, and say which columns were taken.

    The columns are those of time, position, velocity, torque and known torque.
    """
    if log is None:
        if any(columns) or scale or torque_constant is not None or torque_delay is not None:
            raise InputError("columns, --scale, --torque-constant and --torque-delay are those of a --log; give one")
        return None, []
    time, position, velocity, torque, known = columns
    chosen = chosen_columns(log, time, None, position, velocity, torque, known, ending="-column")
    scales, _ = column_factors(log, chosen, scale, torque_constant, linear=linear, takes_current=False)
    return read_columns(log, chosen, None, scales), [columns_taken(chosen)]


def _recorded(
    scenario: "Scenario", given: dict[str, float | None], period: float, stage: Path, progress: Progress
) -> "tuple[Log, Figure]":
    """Move the simulated joint within limits, those given among them, and write motion and log; return log and picture.

    The period of the motion is in s.
    """
    from adaptive_ff.files import write_csv
    from adaptive_ff.logs.log import read_log
    from adaptive_ff.report.excitation_plot import plot_excitation
    from adaptive_ff.scenario.file import toml_text
    from adaptive_ff.studies.commissioning import record
    from adaptive_ff.studies.exciting_motion import default_limits

    task = progress.add_task("motion", total=1.0)
    limits = default_limits(scenario, **given)
    recorded = record(
        scenario,
        limits,
        period=period,
        workers=None,
        progress=lambda share: progress.update(task, completed=share),
    )
    write_csv(stage / "excitation.csv", recorded.motion.columns(scenario.sampling.period))
    table = toml_text({"reference": recorded.motion.reference.model_dump()})
    (stage / "excitation.toml").write_text(table, encoding="utf-8")
    picture = plot_excitation(recorded.motion, linear=scenario.joint.axis == "linear")
    write_csv(stage / "log.csv", recorded.columns)
    return read_log(stage / "log.csv", time="time", velocity="velocity", torque="torque"), picture


def _tuned(scenario: "Scenario", found: "LogIdentification", progress: Progress) -> "tuple[Scenario, BandwidthStudy]":
    """Return the identified scenario with the bandwidth that suits it, and the study that found it."""
    from adaptive_ff.studies.commissioning import identified_scenario, tuned

    work = progress.add_task("bandwidth", total=1.0)
    identified = identified_scenario(scenario, found)
    return tuned(identified, workers=None, progress=lambda share: progress.update(work, completed=share))


def _taken_from(source: str, found: "LogIdentification") -> list[str]:
    """Return what of the scenario is not from the log, and what of the log is not in the scenario."""
    from adaptive_ff.identify.scenario_text import left_out

    left = left_out(found)
    return [
        f"In scenario.toml sampling, drive, sensor and reference are those of {source}, not of the log; set them.",
        *([f"The log shows {' and '.join(left)} as well; the simulated joint does without."] if left else []),
    ]


def _said(gain: "Gain") -> list[str]:
    """Return what was gained on the simulated joint, and what to do on a real one."""
    return [
        f"On the simulated joint: settled rms error {gain.before:.3g} with the PI loop as given "
        f"({gain.before_bandwidth:.3g} Hz), {gain.best_pi:.3g} with the bandwidth that suits PI "
        f"({gain.best_pi_bandwidth:.3g} Hz), {gain.after:.3g} commissioned ({gain.after_bandwidth:.3g} Hz).",
        "On a real joint: run excitation.csv several times in a row under its own loop, record time, velocity and "
        "torque, and give the log with --log (and half a period as --torque-delay where the torque of a row acts over "
        "the coming period).",
    ]
