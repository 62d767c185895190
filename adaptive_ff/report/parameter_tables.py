"""The parameters of an identified log as a table for a terminal."""

import numpy as np
from rich.box import SIMPLE
from rich.table import Table

from adaptive_ff.identify.reported import interval_words
from adaptive_ff.identify.result import LogIdentification
from adaptive_ff.identify.terms import SQUARE_STICTION

FEWEST = 9
"""Rows of a map at least."""

ALWAYS = ("friction_lag", "stiction")
"""Parameters that are shown even where the model does without them."""

SHORT = {SQUARE_STICTION: "the shape of stiction"}
"""Words of terms whose names do not say what they stand for."""


def parameters_table(found: LogIdentification) -> Table:
    """Return the parameters of the model with their intervals, one a row, and what is confounded beside them."""
    title = f"{found.samples} samples, {found.used} used, band {found.bandwidth:.3g} Hz"
    table = Table(title=title, box=SIMPLE, title_style="bold")
    table.add_column("parameter", no_wrap=True)
    table.add_column("value", justify="right", no_wrap=True)
    table.add_column(f"{100.0 * found.confidence:g} % from", justify="right", no_wrap=True)
    table.add_column("to", justify="right", no_wrap=True)
    table.add_column("")
    for name, reported in found.parameters.items():
        estimate, identifiable, used, confounded = reported
        if not used and name not in ALWAYS:
            continue
        remark = "" if reported.is_known else "not apart from zero" if used else "not identifiable"
        if confounded:
            remark = f"confounded with {', '.join(SHORT.get(name, name.replace('_', ' ')) for name in confounded)}"
        style = None if identifiable else "dim"
        table.add_row(
            f"{name}, {found.units[name]}", f"{estimate.value:.4g}", *interval_words(estimate, 4), remark, style=style
        )
    share = None if found.position_map is None else found.position_map.load_share
    if share is not None:
        numbers = (f"{share.value:.4g}", *interval_words(share, 4))
        table.add_row(f"load_friction, 1/({found.units['torque']})", *numbers, "")
    return table


def map_table(found: LogIdentification) -> Table | None:
    """Return friction and force over position with their intervals; None where the model has no map of them."""
    learnt = found.position_map
    if learnt is None or (learnt.friction is None and learnt.force is None):
        return None
    unit, torque = found.units["velocity"].removesuffix("/s"), found.units["torque"]
    table = Table(title="Friction and force over position, beside the parameters above", box=SIMPLE, title_style="bold")
    table.add_column(f"position, {unit}", justify="right", no_wrap=True)
    curves = {"friction over its mean": learnt.friction, f"force, {torque}": learnt.force}
    shown = {heading: curve for heading, curve in curves.items() if curve is not None}
    for heading in shown:
        for column in (heading, f"{100.0 * found.confidence:g} % from", "to"):
            table.add_column(column, justify="right", no_wrap=True)
    for place in np.linspace(0, learnt.position.size - 1, max(found.map_asked.hats, FEWEST)).round().astype(int):
        numbers = [f"{series[place]:.3g}" for curve in shown.values() for series in curve]
        table.add_row(f"{learnt.position[place]:.3g}", *numbers)
    return table
