"""The parameters of an identified log as a table for a terminal."""

import math

from rich.box import SIMPLE
from rich.table import Table

from adaptive_ff.identify.result import LogIdentification

ALWAYS = ("friction_lag", "stiction")
"""Parameters that are shown even where the model does without them."""


def parameters_table(found: LogIdentification) -> Table:
    """Return the parameters of the model with their intervals, one a row, and what is confounded beside them."""
    title = f"{found.samples} samples, {found.used} used, band {found.bandwidth:.3g} Hz"
    table = Table(title=title, box=SIMPLE, title_style="bold")
    table.add_column("parameter", no_wrap=True)
    table.add_column("value", justify="right", no_wrap=True)
    table.add_column(f"{100.0 * found.confidence:g} % from", justify="right", no_wrap=True)
    table.add_column("to", justify="right", no_wrap=True)
    table.add_column("")
    for name, (estimate, identifiable, used, confounded) in found.parameters.items():
        if not used and name not in ALWAYS:
            continue
        remark = "" if identifiable and used else "not identifiable" if not used else "not apart from zero"
        if confounded:
            remark = f"confounded with {', '.join(name.replace('_', ' ') for name in confounded)}"
        ends = (f"{end:.3g}" if math.isfinite(end) else "∞" for end in (estimate.lower, estimate.upper))
        style = None if identifiable else "dim"
        table.add_row(f"{name}, {found.units[name]}", f"{estimate.value:.4g}", *ends, remark, style=style)
    return table
