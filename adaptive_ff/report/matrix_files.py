"""The scenario matrix as tables and files: pictures, every run's figures, and every scenario for ``compare``."""

import csv
from pathlib import Path
from typing import Any

from matplotlib.figure import Figure

from adaptive_ff.report.study_pictures import plot_matrix
from adaptive_ff.report.table import Table
from adaptive_ff.report.tables import MOST_COLUMNS, MOST_ROWS, gains_table, present, ranking_table, standstill_table
from adaptive_ff.scenario.file import to_toml
from adaptive_ff.studies.matrix import Results, cell_scenario, collect

TITLES = {
    False: "Settled rms error: improvement over pi, median over seeds",
    True: "The same with the fastest PI loop that Ms <= 1.7 and the noise allow",
}
"""Headings without and with the fastest PI loop."""


def by_loop(results: Results) -> dict[bool, Results]:
    """Return the results with the scenarios' own PI loops, and those with the fastest ones."""
    loops = sorted({job.fastest for job in results})
    return {fast: {job: found for job, found in results.items() if job.fastest == fast} for fast in loops}


def matrix_tables(results: Results) -> list[Table]:
    """Return what fits a terminal: every controller on every scenario where they are few, else means over groups."""
    tables = []
    for fast, part in by_loop(results).items():
        cells = collect(part)
        few = len(cells) <= MOST_ROWS and max(map(len, cells.values())) <= MOST_COLUMNS
        tables.append((gains_table if few else ranking_table)(cells, TITLES[fast]))
    if len({job.scenario for job in results}) <= MOST_ROWS:
        tables += present(standstill_table(by_loop(results)[False]))
    return tables


def matrix_figures(results: Results) -> dict[str, Figure]:
    """Return a picture a loop by name; none of PI alone."""
    seeds = sorted({job.seed for job in results})
    source = f"scenarios of the package, seeds {seeds[0]} to {seeds[-1]}"
    figures: dict[str, Figure] = {}
    for fast, part in by_loop(results).items():
        controllers = list(dict.fromkeys(name for found in part.values() for name in found))
        figure = plot_matrix(collect(part), controllers, TITLES[fast], source)
        if figure is not None:
            figures[f"matrix_{'fastest' if fast else 'own'}_loop"] = figure
    return figures


def write_matrix(results: Results, folder: Path) -> None:
    """Write ``matrix.md``, ``runs.csv`` and the scenarios into a folder."""
    loops = by_loop(results)
    cells = {TITLES[fast]: collect(part) for fast, part in loops.items()}
    tables = [make(part, title) for title, part in cells.items() for make in (ranking_table, gains_table)]
    tables += present(standstill_table(loops[False]))
    folder.mkdir(parents=True, exist_ok=True)
    (folder / "matrix.md").write_text("\n".join(one.markdown() for one in tables), encoding="utf-8")
    rows = matrix_rows(results)
    with (folder / "runs.csv").open("w", newline="", encoding="utf-8") as stream:
        writer = csv.DictWriter(stream, list(dict.fromkeys(key for row in rows for key in row)))
        writer.writeheader()
        writer.writerows(rows)
    scenarios = folder / "scenarios"
    scenarios.mkdir(exist_ok=True)
    for job in results:
        name = f"{job.scenario}-{'fastest' if job.fastest else 'own'}-{job.seed}.toml"
        (scenarios / name).write_text(to_toml(cell_scenario(job.scenario, job.seed, job.fastest)), encoding="utf-8")


def matrix_rows(results: Results) -> list[dict[str, Any]]:
    """Return the figures of every run, a row each."""
    return [
        {"scenario": job.scenario, "seed": job.seed, "fastest": job.fastest, "controller": name, **figures}
        for job, found in results.items()
        for name, figures in found.items()
    ]
