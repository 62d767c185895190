"""The parameters of an identified log as a table for a terminal."""

import math

from rich.box import SIMPLE
from rich.table import Table

from adaptive_ff.identify.result import LogIdentification


def parameters_table(found: LogIdentification) -> Table:
    """Return the parameters with their intervals, one a row."""
    title = f"{found.samples} samples, {found.used} used, band {found.bandwidth:.3g} Hz"
    table = Table(title=title, box=SIMPLE, title_style="bold")
    table.add_column("parameter", no_wrap=True)
    table.add_column("value", justify="right")
    table.add_column(f"{100.0 * found.confidence:g} % from", justify="right")
    table.add_column("to", justify="right")
    table.add_column("", no_wrap=True)
    for name, (estimate, identifiable, used, confounded) in found.parameters.items():
        remark = "" if identifiable and used else "not identifiable" if not used else "not apart from zero"
        if confounded:
            remark = f"confounded with {', '.join(confounded)}"
        ends = (f"{end:.3g}" if math.isfinite(end) else "∞" for end in (estimate.lower, estimate.upper))
        style = None if identifiable else "dim"
        table.add_row(f"{name}, {found.units[name]}", f"{estimate.value:.4g}", *ends, remark, style=style)
    return table
