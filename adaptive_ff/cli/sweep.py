"""Command ``adaptive-ff sweep``."""

from pathlib import Path
from typing import Annotated

import typer

from adaptive_ff.cli.cluster import Scheduler, workers
from adaptive_ff.cli.options import OUT, Formats, JsonCopy, OwnControllers, Report, ScenarioFile, picture_formats
from adaptive_ff.cli.places import places
from adaptive_ff.cli.terminal import Printer, announce_compilation, error_console, progress_bars
from adaptive_ff.errors import InputError


def sweep_command(
    scenario: ScenarioFile = None,
    own: OwnControllers = None,
    controller: Annotated[
        list[str] | None,
        typer.Option(help="Further controller of the package to run beside them. May be given several times."),
    ] = None,
    runs: Annotated[int, typer.Option(min=1, help="Number of joints to draw.")] = 1000,
    seed: Annotated[int, typer.Option(min=0, help="Seed of the draws.")] = 1,
    out: Annotated[
        Path,
        typer.Option(help="Folder for sweep.json, sweep.png and the worst cases; an interrupted call goes on there."),
    ] = OUT,
    json: JsonCopy = None,
    formats: Formats = "png",
    report: Report = False,
    scheduler: Scheduler = None,
) -> None:
    """Draw joints at random, and show how pi, oracle, adaptive and further controllers fare on them."""
    from rich.table import Table

    from adaptive_ff.comparison.own import named_own
    from adaptive_ff.files import write_result
    from adaptive_ff.report.comparison_tables import classes_table, own_sweep_table, sweep_table
    from adaptive_ff.report.drawing import write_figures
    from adaptive_ff.report.html_page import NAME, write_report
    from adaptive_ff.report.sweep_picture import plot_sweep
    from adaptive_ff.scenario.file import to_toml
    from adaptive_ff.scenario.scenario import load_scenario
    from adaptive_ff.simulation.loop import run_in_memory
    from adaptive_ff.studies.drawn_joints import draw_scenario
    from adaptive_ff.studies.sweep import refusals, summary, sweep

    drawn = picture_formats(formats)
    errors = error_console()
    mine = named_own(own or [])
    loaded = load_scenario(scenario)
    with places(out, json) as (stage, beside), workers(scheduler) as executor:
        announce_compilation(errors, run_in_memory)
        with progress_bars(errors) as progress:
            task = progress.add_task("joints", total=1.0)
            outcomes = sweep(
                loaded,
                runs,
                seed,
                own=mine,
                rivals=controller or [],
                folder=out,
                executor=executor,
                progress=lambda share: progress.update(task, completed=share),
            )
        refused = [f"{count} joints refused: {reason}" for reason, count in refusals(outcomes).items()]
        if all(outcome.refused for outcome in outcomes):
            raise InputError(f"{loaded.name}: none of {runs} joints can be run; {'; '.join(refused)}")
        result = summary(outcomes, seed)
        for rank, case in enumerate(result["worst"], start=1):
            text = to_toml(draw_scenario(loaded, seed, case["draw"]))
            (stage / f"worst-{rank}.toml").write_text(text, encoding="utf-8")
        for file in (stage / "sweep.json", *beside.values()):
            write_result(file, result)
        figure = plot_sweep(outcomes, f"around {loaded.name}, seed {seed}", len(result["worst"]))
        figures = {} if figure is None else {"sweep": figure}
        write_figures(figures, stage, drawn)
        worse = f"{100 * result['worse_than_pi']:.2g} % of the joints that ran"
        shown: list[Table | str] = [
            sweep_table(result),
            classes_table(result),
            *([own_sweep_table(result)] if result["own"] else []),
            f"Whole run more than 5 % worse than pi: {worse}",
            *refused,
        ]
        if report:
            title = f"{runs} joints drawn around {loaded.name}, seed {seed}"
            write_report(stage / NAME, title, shown, figures, {"Scenario that they are drawn around": to_toml(loaded)})
    console = Printer()
    console.show(shown)
    console.say(f"sweep.json, its picture and the worst cases are in {out}")
