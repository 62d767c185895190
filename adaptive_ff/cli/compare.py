"""Command ``adaptive-ff compare``."""

from collections.abc import Mapping
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer
from rich.console import Console

from adaptive_ff.cli.common import SETTINGS
from adaptive_ff.cli.gate import Gate
from adaptive_ff.cli.options import OUT, Formats, JsonCopy, OwnControllers, Report, ScenarioFile, picture_formats
from adaptive_ff.cli.places import of_earlier_runs, places
from adaptive_ff.cli.terminal import Printer, announce_compilation, error_console, progress_bars, warn
from adaptive_ff.errors import InputError

if TYPE_CHECKING:
    from rich.table import Table

    from adaptive_ff.comparison.comparison import Comparison
    from adaptive_ff.comparison.own import Own
    from adaptive_ff.scenario.scenario import Scenario

COLUMNS = (
    "settled: the last half of the run, or of the time after the last change; pi / own: settled error of pi over that "
    "of the controller, above 1 is better than pi; sum |du|: how much the command moves in all"
)
"""What the columns of the tables of errors mean."""


def compare_command(
    scenario: ScenarioFile = None,
    reference: Annotated[
        Path | None,
        typer.Option(help="Recorded reference (CSV: time and velocity or position), instead of the file's."),
    ] = None,
    own: OwnControllers = None,
    out: Annotated[Path, typer.Option(help="Folder for plots, time series (CSV) and result.json.")] = OUT,
    json: JsonCopy = None,
    formats: Formats = "png",
    report: Report = False,
    baseline: Annotated[
        Path | None, typer.Option(help="Earlier result (JSON); status 1 where tracking got worse than it.")
    ] = None,
    tolerance: Annotated[
        list[str] | None,
        typer.Option(
            help="How much worse figures may be: 5% (the default) or 0.05 for all; METRIC=10%, CONTROLLER=2% or "
            "CONTROLLER.METRIC=20% for some. May be given several times."
        ),
    ] = None,
    guard: Annotated[
        list[str] | None,
        typer.Option(help="Controller to guard; by default all of the baseline but the oracle and the rivals."),
    ] = None,
    metric: Annotated[list[str] | None, typer.Option(help="Figure to guard, such as rms_error_settled; all.")] = None,
    thin: Annotated[
        int | None,
        typer.Option(
            min=1,
            help="Keep one of so many samples in series and plots; figures are of the whole run. By default all are "
            "kept up to two million solver steps; 1 for all of a longer run.",
        ),
    ] = None,
) -> int:
    """Run a joint with each controller and show by how much friction feedforward improves tracking."""
    from adaptive_ff.comparison.own import check_own_names, named_own
    from adaptive_ff.comparison.registry import CONTROLLERS
    from adaptive_ff.files import write_csv, write_result
    from adaptive_ff.report.comparison_plots import PICTURES
    from adaptive_ff.report.drawing import write_figures
    from adaptive_ff.report.html_page import NAME, write_report
    from adaptive_ff.scenario.file import to_toml
    from adaptive_ff.scenario.scenario import load_scenario

    drawn = picture_formats(formats)
    errors = error_console()
    mine = named_own(own or [])
    check_own_names(mine, CONTROLLERS)
    loaded = load_scenario(scenario, reference=reference)
    gate = None if baseline is None else Gate(baseline, loaded, tolerance, guard, metric)
    if gate is None and (tolerance or guard or metric):
        raise InputError("--tolerance, --guard and --metric need a --baseline to compare with")
    source = scenario or "built-in scenario"
    if loaded.feedback.is_auto and not SETTINGS.quiet:
        errors.print("Looking for the bandwidth that suits each controller.")
    _check_controllers(loaded, mine, str(source))
    warn(errors, loaded.cautions())
    with places(out, json) as (stage, beside):
        try:
            comparison = _run(loaded, mine, errors, thin)
        except ArithmeticError as error:
            raise InputError(f"{source}: the simulation fails: {error}") from error
        for name, run in comparison.runs.items():
            write_csv(stage / f"{name}.csv", run.columns())
        figures, shown = comparison.plot(None), _tables(comparison)
        write_figures(figures, stage, drawn)
        if report:
            title = f"Controllers on {source}, seed {loaded.seed}"
            write_report(stage / NAME, title, shown, figures, {"Scenario": to_toml(loaded)})
        for file in (stage / "result.json", *beside.values()):
            write_result(file, comparison.to_dict())
        earlier = of_earlier_runs(out, stage, PICTURES, [*(f"{name}.csv" for name in CONTROLLERS), NAME])
    console = Printer()
    console.show(shown)
    console.say(f"Plots, time series and result.json are in {out}")
    console.show(earlier)
    return 0 if gate is None else gate.judge(comparison, errors)


def _check_controllers(scenario: "Scenario", own: "Mapping[str, Own]", source: str) -> None:
    """Raise ``InputError``, before anything runs, where a controller cannot be made."""
    from adaptive_ff.comparison.registry import make_controller

    try:
        for name in (*scenario.controllers, *own):
            make_controller(scenario, name, own)
    except ValueError as error:
        raise InputError(f"{source}: {error}") from error


def _run(scenario: "Scenario", own: "Mapping[str, Own]", errors: Console, thin: int | None) -> "Comparison":
    from adaptive_ff.comparison.comparison import compare
    from adaptive_ff.simulation.loop import run_in_memory

    announce_compilation(errors, run_in_memory)
    with progress_bars(errors) as progress:
        tasks = {name: progress.add_task(name, total=1.0) for name in (*scenario.controllers, *own)}

        def report(name: str, share: float) -> None:
            progress.update(tasks[name], completed=share)

        return compare(scenario, own=own, progress=report, thin=thin)


def _tables(comparison: "Comparison") -> "list[Table | str]":
    from adaptive_ff.report.comparison_tables import estimates_table, position_table, tracking_table

    tables = [tracking_table(comparison), position_table(comparison), estimates_table(comparison)]
    shown: list[Table | str] = [*(table for table in tables if table is not None), COLUMNS]
    if comparison.bandwidths:
        best = ", ".join(f"{name} {hertz:.3g} Hz" for name, hertz in comparison.bandwidths.items())
        shown.append(f"Each controller in the loop that suits it, chosen on other seeds: {best}")
    return shown
