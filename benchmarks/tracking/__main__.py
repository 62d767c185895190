"""The scenario matrix: ``python -m benchmarks.tracking [--only NAME] [--seeds N] [--out DIR] [--json FILE]``.

Every controller on every scenario of ``benchmarks/scenarios``, over seeds from 1 on; then again with the fastest PI
loop that a maximum sensitivity of 1.7 and the noise allow. Results are kept under ``--out`` as they come: an
interrupted call goes on where it stopped. Under ``--out`` are then, too: the tables (``matrix.md``), pictures of who
wins where, every run's figures (``runs.csv``) and every scenario with its seed, for ``adaptive-ff compare``.
"""

import csv
from pathlib import Path
from typing import Annotated, Any

import typer
from rich.box import SIMPLE
from rich.console import Console
from rich.progress import Progress
from rich.table import Table

from adaptive_ff.comparison.comparison import BASELINE
from adaptive_ff.comparison.reference_lines import NOISE_FLOOR
from adaptive_ff.comparison.registry import CONTROLLERS
from adaptive_ff.report.files import write_json
from adaptive_ff.scenario.file import to_toml
from benchmarks.tracking.cells import cell_scenario, scenario_names
from benchmarks.tracking.matrix import Job, Results, run_matrix
from benchmarks.tracking.picture import draw_matrix
from benchmarks.tracking.summary import collect, ranking_markdown, ranking_table, standstill_rows
from benchmarks.tracking.targets import targets_table

LEFT_OUT = frozenset({"fixed"})
"""Its parameters stand in a table that these scenarios do not have; the fixed feedforwards are there by other names."""

TITLES = {
    False: "Settled rms error: improvement over pi, median over seeds",
    True: "The same with the fastest PI loop that Ms <= 1.7 and the noise allow",
}


def main(
    only: Annotated[list[str] | None, typer.Option(help="Scenario to run; may be given several times.")] = None,
    controller: Annotated[list[str] | None, typer.Option(help="Controller to run; all by default.")] = None,
    seeds: Annotated[int, typer.Option(min=1, help="Number of seeds, from 1 on.")] = 20,
    out: Annotated[Path, typer.Option(help="Folder for results.")] = Path("results/tracking"),
    json: Annotated[Path | None, typer.Option(help="Write all figures there, too.")] = None,
    fastest: Annotated[bool, typer.Option(help="Also run everything with the fastest PI loop.")] = True,
) -> None:
    """Run the matrix and say who wins where."""
    scenarios = _chosen("--only", only, scenario_names())
    known = [name for name in CONTROLLERS if name not in LEFT_OUT]
    controllers = _chosen("--controller", controller, [*known, NOISE_FLOOR])
    controllers = list(dict.fromkeys([BASELINE, *controllers]))
    console = Console()
    jobs = [
        Job(scenario, seed, fast)
        for fast in ([False, True] if fastest else [False])
        for scenario in scenarios
        for seed in range(1, seeds + 1)
    ]
    with Progress(console=Console(stderr=True), transient=True) as progress:
        task = progress.add_task("runs", total=1.0)
        results = run_matrix(jobs, controllers, out, progress=lambda share: progress.update(task, completed=share))
    text = ""
    for fast in sorted({job.fastest for job in jobs}):
        part = {job: found for job, found in results.items() if job.fastest == fast}
        cells = collect(part)
        console.print(ranking_table(cells, TITLES[fast]))
        text += f"{TITLES[fast]}\n\n{ranking_markdown(cells)}\n"
        draw_matrix(cells, controllers, out / f"matrix_{'fastest' if fast else 'own'}_loop.png", TITLES[fast])
    _print_standstill(console, {job: found for job, found in results.items() if not job.fastest})
    targets = targets_table(results)
    if targets is not None:
        console.print(targets)
    (out / "matrix.md").write_text(text, encoding="utf-8")
    _write_runs(results, out)
    if json is not None:
        write_json(json, {"runs": _rows(results)})
    console.print(f"Tables, pictures and the runs behind them are in {out}", highlight=False)


def _chosen(option: str, given: list[str] | None, known: list[str]) -> list[str]:
    for name in given or []:
        if name not in known:
            raise typer.BadParameter(f"{name!r} is not known; there are {', '.join(known)}", param_hint=option)
    return [name for name in known if not given or name in given]


def _print_standstill(console: Console, results: Results) -> None:
    rows = standstill_rows(results)
    if not rows:
        return
    table = Table(title="Peak-to-peak true velocity at standstill, mrad/s, median over seeds", box=SIMPLE)
    table.add_column("controller")
    for scenario in rows:
        table.add_column(scenario, justify="right")
    for name in next(iter(rows.values())):
        table.add_row(name, *(f"{1e3 * row[name]:.3g}" if name in row else "failed" for row in rows.values()))
    console.print(table)


def _rows(results: Results) -> list[dict[str, Any]]:
    return [
        {"scenario": job.scenario, "seed": job.seed, "fastest": job.fastest, "controller": name, **figures}
        for job, found in results.items()
        for name, figures in found.items()
    ]


def _write_runs(results: Results, out: Path) -> None:
    rows = _rows(results)
    fields = list(dict.fromkeys(key for row in rows for key in row))
    with (out / "runs.csv").open("w", newline="", encoding="utf-8") as stream:
        writer = csv.DictWriter(stream, fields)
        writer.writeheader()
        writer.writerows(rows)
    folder = out / "scenarios"
    folder.mkdir(exist_ok=True)
    for job in results:
        name = f"{job.scenario}-{'fastest' if job.fastest else 'own'}-{job.seed}.toml"
        (folder / name).write_text(to_toml(cell_scenario(job.scenario, job.seed, job.fastest)), encoding="utf-8")


if __name__ == "__main__":
    typer.run(main)
