"""Friction laws on a measured record: ``python -m benchmarks.friction [RECORD.npz] [--out DIR] [--json FILE]``.

Every law of ``plant`` is fitted to the first half of the record of a reciprocating contact and judged on both halves,
with the share of Coulomb friction's error. A picture shows each law over the displacement, and its fit beside the
measured loop.
"""

import sys
from pathlib import Path
from typing import Annotated

import typer
from rich.box import SIMPLE
from rich.table import Table

from adaptive_ff.files import write_json
from adaptive_ff.report.drawing import write_stamped
from benchmarks.friction.laws import LAWS, Fit, fit_all
from benchmarks.friction.picture import draw
from benchmarks.friction.record import DATA, read_record
from benchmarks.wide import wide_console


def table_of(fits: list[Fit]) -> Table:
    """Return the force errors of the laws; Coulomb friction comes first."""
    table = Table(title="Force error on the measured presliding record, N (rms)", box=SIMPLE)
    for heading in ("law", "parameters", "fitted half", "other half", "of Coulomb's", "asked", "met"):
        table.add_column(heading, justify="left" if heading == "law" else "right")
    asked = {law.name: law.share for law in LAWS}
    for fit in fits:
        share, limit = fit.tested / fits[0].tested, asked.get(fit.law)
        row = (fit.law, f"{len(fit.values)}", f"{fit.fitted:.3g}", f"{fit.tested:.3g}", f"{share:.3f}")
        table.add_row(*row, *(("", "") if limit is None else (f"<= {limit:g}", "yes" if share <= limit else "no")))
    return table


def main(
    record: Annotated[Path, typer.Argument(help="The record, reciprocating_presliding.npz.")] = DATA,
    out: Annotated[Path, typer.Option(help="Folder for the picture.")] = Path("results/friction"),
    json: Annotated[Path | None, typer.Option(help="Write errors and parameters there, too.")] = None,
) -> None:
    """Fit the laws, print their errors and draw them."""
    if not record.is_file():
        print(f"{record}: there is no such record. {__doc__}", file=sys.stderr)
        raise typer.Exit(2)
    measured = read_record(record)
    fits = fit_all(measured)
    console = wide_console()
    console.print(table_of(fits))
    write_stamped({"friction_laws": draw(measured, fits)}, out, ["png"], "python -m benchmarks.friction")
    if json is not None:
        rows = {fit.law: {"fitted": fit.fitted, "tested": fit.tested, "parameters": fit.values} for fit in fits}
        write_json(json, rows)
    console.print(f"The picture is {out / 'friction_laws.png'}", highlight=False)


if __name__ == "__main__":
    typer.run(main)
