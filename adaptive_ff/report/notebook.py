"""A comparison as it shows in a notebook: its tables, and the picture of its tracking."""

import base64
import io
from html import escape

from rich.table import Row, Table
from rich.text import Text

from adaptive_ff.comparison.comparison import Comparison
from adaptive_ff.report.comparison_plots import plot_comparison
from adaptive_ff.report.comparison_tables import estimates_table, position_table, tracking_table


def comparison_html(comparison: Comparison) -> str:
    """Return tables and the picture of tracking as HTML that needs nothing else."""
    tables = (tracking_table(comparison), position_table(comparison), estimates_table(comparison))
    shown = "".join(table_html(table) for table in tables if table is not None)
    stream = io.BytesIO()
    plot_comparison(comparison)["tracking"].savefig(stream, format="png", dpi=100)
    picture = base64.b64encode(stream.getvalue()).decode("ascii")
    return f'<div>{shown}<img alt="tracking of all controllers" src="data:image/png;base64,{picture}"></div>'


def table_html(table: Table) -> str:
    """Return a table as HTML."""
    aligned = [f' style="text-align: {column.justify}"' for column in table.columns]
    heads = "".join(
        f"<th{look}>{_cell(column.header)}</th>" for look, column in zip(aligned, table.columns, strict=True)
    )
    rows = "".join(
        f"<tr{_marked(kind)}>"
        + "".join(f"<td{look}>{_cell(cell)}</td>" for look, cell in zip(aligned, row, strict=True))
        + "</tr>"
        for kind, row in zip(table.rows, zip(*(column.cells for column in table.columns), strict=True), strict=True)
    )
    return f"<table><caption>{_cell(table.title or '')}</caption><tr>{heads}</tr>{rows}</table>"


def _marked(row: Row) -> str:
    """Return how a row that a terminal prints in bold letters shows here."""
    return ' style="font-weight: bold"' if "bold" in str(row.style or "") else ""


def _cell(content: object) -> str:
    return escape(Text.from_markup(str(content)).plain)
