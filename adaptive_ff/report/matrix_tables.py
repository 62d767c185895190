"""The scenario matrix as tables for a terminal."""

import numpy as np
from rich.box import SIMPLE
from rich.table import Table

from adaptive_ff.comparison.comparison import BASELINE
from adaptive_ff.comparison.reference_lines import NOISE_FLOOR
from adaptive_ff.comparison.registry import CONTROLLERS
from adaptive_ff.studies.matrix import Results
from adaptive_ff.studies.ranking import HEADINGS, Cells, grouped, ranking_row, standstill_rows


def ranking_table(cells: Cells, title: str) -> Table:
    """Return the table for a terminal, a section for each group."""
    table = Table(title=title, box=SIMPLE, title_style="bold")
    for heading in HEADINGS:
        name = heading in ("scenario", "best rival")
        table.add_column(heading, justify="left" if name else "right", no_wrap=name, min_width=5)
    for group, names in grouped(cells).items():
        table.add_row(f"[bold]{group}[/bold]")
        for scenario in names:
            row = ranking_row(scenario, cells[scenario])
            table.add_row("  " + row[0], *row[1:], style="red" if row[-1].startswith("lost") else None)
        table.add_section()
    return table


def gains_table(cells: Cells, title: str) -> Table:
    """Return the improvement of every controller over PI, medians over the seeds, a section for each group."""
    names = [name for name in dict.fromkeys(key for row in cells.values() for key in row) if name != BASELINE]
    table = Table(title=title, box=SIMPLE, title_style="bold")
    table.add_column("scenario", no_wrap=True)
    table.add_column("pi, mrad/s", justify="right")
    for name in names:
        table.add_column(name, justify="right", style=None if name in (*CONTROLLERS, NOISE_FLOOR) else "bold cyan")
    for group, members in grouped(cells).items():
        table.add_row(f"[bold]{group}[/bold]")
        for scenario in members:
            row = cells[scenario]
            shown = (f"{np.median(row[name].gain):.3g}" if name in row else "failed" for name in names)
            table.add_row(f"  {scenario}", f"{1e3 * row[BASELINE].median:.3g}", *shown)
        table.add_section()
    return table


def standstill_table(results: Results) -> Table | None:
    """Return what moved at standstill; None where the reference of no scenario stands still."""
    rows = standstill_rows(results)
    if not rows:
        return None
    table = Table(title="Peak-to-peak true velocity at standstill, mrad/s, median over seeds", box=SIMPLE)
    table.add_column("controller")
    for scenario in rows:
        table.add_column(scenario, justify="right")
    for name in next(iter(rows.values())):
        table.add_row(name, *(f"{1e3 * row[name]:.3g}" if name in row else "failed" for row in rows.values()))
    return table
