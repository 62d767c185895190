"""Command ``adaptive-ff tune``."""

from pathlib import Path
from typing import Annotated

import typer
from rich.table import Table

from adaptive_ff.cli.options import OUT, Formats, JsonCopy, Report, ScenarioFile, picture_formats
from adaptive_ff.cli.places import places
from adaptive_ff.cli.terminal import Printer, announce_compilation, error_console, progress_bars


def tune_command(
    scenario: ScenarioFile = None,
    controller: Annotated[
        list[str] | None,
        typer.Option(help="Controller to study beside pi; by default the observers and adaptive. May be repeated."),
    ] = None,
    seeds: Annotated[int, typer.Option(min=1, max=100, help="Number of seeds to report on, from 1 on.")] = 5,
    tuning_seeds: Annotated[int, typer.Option(min=1, help="Number of seeds to choose on, from 101 on.")] = 3,
    out: Annotated[Path, typer.Option(help="Folder for the picture, tune.csv and tune.json.")] = OUT,
    json: JsonCopy = None,
    formats: Formats = "png",
    report: Report = False,
) -> None:
    """Find the bandwidth that suits each controller: margins, noise and error over the bandwidth of the PI loop."""
    from adaptive_ff.comparison.own_bandwidth import FIRST_TUNING_SEED
    from adaptive_ff.files import write_csv, write_result
    from adaptive_ff.report.bandwidth_tables import best_table, errors_table, loops_table
    from adaptive_ff.report.drawing import write_stamped
    from adaptive_ff.report.html_page import NAME, write_report
    from adaptive_ff.scenario.file import to_toml
    from adaptive_ff.scenario.scenario import load_scenario
    from adaptive_ff.simulation.loop import run_in_memory
    from adaptive_ff.studies.bandwidth_study import STUDIED, study_bandwidths

    drawn = picture_formats(formats)
    loaded, errors = load_scenario(scenario), error_console()
    with places(out, json) as (stage, beside):
        announce_compilation(errors, run_in_memory)
        with progress_bars(errors) as progress:
            task = progress.add_task("bandwidths", total=1.0)
            study = study_bandwidths(
                loaded,
                controller or STUDIED,
                tuning_seeds=range(FIRST_TUNING_SEED, FIRST_TUNING_SEED + tuning_seeds),
                reported_seeds=range(1, seeds + 1),
                workers=None,
                progress=lambda share: progress.update(task, completed=share),
            )
        write_csv(stage / "tune.csv", study.columns())
        source, figures = str(scenario or "built-in scenario"), {"tune": study.plot()}
        shown: list[Table | str] = [loops_table(study), errors_table(study), best_table(study)]
        if loaded.sensor.encoder_resolution is not None:
            shown.append("Margins are those of the loop without the filter that makes a velocity of encoder readings.")
        write_stamped(figures, stage, drawn, source)
        if report:
            write_report(stage / NAME, f"Bandwidths for {source}", shown, figures, {"Scenario": to_toml(loaded)})
        for file in (stage / "tune.json", *beside.values()):
            write_result(file, study.to_dict())
    console = Printer()
    console.show(shown)
    console.say(f'Picture, tune.csv and tune.json are in {out}; bandwidth = "auto" in a scenario uses the best ones.')
