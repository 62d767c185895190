"""Command ``adaptive-ff matrix``."""

from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer
from rich.console import Console

from adaptive_ff.cli.cluster import Scheduler, workers
from adaptive_ff.cli.options import Formats, JsonCopy, OwnControllers, Report, picture_formats
from adaptive_ff.cli.places import places
from adaptive_ff.cli.terminal import Printer, announce_compilation, error_console, progress_bars
from adaptive_ff.errors import InputError

if TYPE_CHECKING:
    from adaptive_ff.studies.matrix import Results

SHOWN = ("oracle", "lagged_batch", "adaptive")
"""Controllers beside ``pi`` where none are chosen: the two yardsticks that matter, and ours."""

ALL = "all"
LEFT_OUT = frozenset({"fixed"})
"""Its parameters stand in a table that these scenarios do not have; the fixed feedforwards are there by other names."""


MOST_COLUMNS = 8
"""Most controllers that a table shows side by side; of more it shows the best rival, and the picture all."""


def matrix_command(
    own: OwnControllers = None,
    only: Annotated[list[str] | None, typer.Option(help="Scenario to run; may be given several times.")] = None,
    controller: Annotated[
        list[str] | None,
        typer.Option(help=f"Controller to run beside pi, or {ALL!r}; by default {', '.join(SHOWN)}. May be repeated."),
    ] = None,
    seeds: Annotated[int, typer.Option(min=1, help="Number of seeds, from 1 on.")] = 5,
    fastest: Annotated[bool, typer.Option(help="Also run everything with the fastest PI loop.")] = False,
    out: Annotated[Path, typer.Option(help="Folder for results; an interrupted call goes on there.")] = Path(
        "results/matrix"
    ),
    json: JsonCopy = None,
    formats: Formats = "png",
    report: Report = False,
    scheduler: Scheduler = None,
) -> None:
    """Run controllers on all scenarios of the package over several seeds, and say who wins where."""
    chosen = controller or list(SHOWN)
    run_and_print(
        own, only, chosen, seeds, fastest, out, json, None, formats=formats, report=report, scheduler=scheduler
    )


def run_and_print(
    own: list[str] | None,
    only: list[str] | None,
    controller: list[str],
    seeds: int,
    fastest: bool,
    out: Path,
    json: Path | None,
    console: Console | None,
    *,
    formats: str = "png",
    report: bool = False,
    scheduler: str | None = None,
) -> "Results":
    """Run the matrix, print its tables, write its files, and return all figures."""
    from adaptive_ff.comparison.comparison import BASELINE
    from adaptive_ff.comparison.own import check_own_names, named_own
    from adaptive_ff.comparison.reference_lines import NOISE_FLOOR
    from adaptive_ff.comparison.registry import CONTROLLERS
    from adaptive_ff.files import write_result
    from adaptive_ff.report.html_page import NAME, write_report
    from adaptive_ff.report.matrix_files import TITLES, by_loop, matrix_rows, write_matrix
    from adaptive_ff.report.matrix_tables import gains_table, ranking_table, standstill_table
    from adaptive_ff.scenario.library import scenario_names
    from adaptive_ff.simulation.loop import run_in_memory
    from adaptive_ff.studies.matrix import Job, run_matrix
    from adaptive_ff.studies.ranking import collect

    drawn = picture_formats(formats)
    mine = named_own(own or [])
    check_own_names(mine, CONTROLLERS)
    known = [*(name for name in CONTROLLERS if name not in LEFT_OUT), NOISE_FLOOR]
    chosen = known if ALL in controller else _chosen("--controller", controller, known)
    scenarios = _chosen("--only", only, scenario_names())
    loops = [False, True] if fastest else [False]
    jobs = [Job(scenario, seed, fast) for fast in loops for scenario in scenarios for seed in range(1, seeds + 1)]
    errors = error_console()
    announce_compilation(errors, run_in_memory)
    with workers(scheduler) as executor, progress_bars(errors) as progress:
        task = progress.add_task("runs", total=1.0)
        results = run_matrix(
            jobs,
            list(dict.fromkeys([BASELINE, *chosen])),
            out,
            own=mine,
            executor=executor,
            progress=lambda share: progress.update(task, completed=share),
        )
    parts = by_loop(results)
    table = ranking_table if len(chosen) + len(mine) > MOST_COLUMNS else gains_table
    shown = [table(collect(part), TITLES[fast]) for fast, part in parts.items()]
    standstill = standstill_table(parts[False])
    shown += [] if standstill is None else [standstill]
    figures = write_matrix(results, out, drawn)
    with places(out, json) as (stage, beside):
        for file in beside.values():
            write_result(file, {"runs": matrix_rows(results)})
        if report:
            write_report(stage / NAME, f"{len(scenarios)} scenarios, seeds 1 to {seeds}", shown, figures)
    console = Printer() if console is None else console  # places decides whether it is quiet
    for one in shown:
        console.print(one)
    console.print(f"Tables, pictures and the runs behind them are in {out}", highlight=False, soft_wrap=True)
    return results


def _chosen(option: str, given: list[str] | None, known: list[str]) -> list[str]:
    for name in given or []:
        if name not in known:
            raise InputError(f"{option}: {name!r} is not known; there are {', '.join(known)}")
    return [name for name in known if not given or name in given]
