"""An exciting motion as a table."""

from rich.box import SIMPLE
from rich.table import Table

from adaptive_ff.report.scaling import shown
from adaptive_ff.studies.motion import Excitation


def motion_table(motion: Excitation, *, linear: bool = False) -> Table:
    """Return what a motion needs beside its limits."""
    unit = "m" if linear else "rad"
    units = {
        "position": unit,
        "velocity": f"{unit}/s",
        "acceleration": f"{unit}/s^2",
        "torque": "N" if linear else "N m",
    }
    table = Table(title=f"Motion of {motion.reference.period:g} s", box=SIMPLE, title_style="bold")
    table.add_column("largest")
    table.add_column("value", justify="right")
    table.add_column("limit", justify="right")
    for name, value in motion.largest.items():
        limit = getattr(motion.limits, name)
        table.add_row(f"{name}, {units[name]}", shown(value), "-" if limit is None else shown(limit))
    return table


def intervals_table(motion: Excitation) -> Table:
    """Return the intervals that a motion gives over those of a minute of multisine."""
    table = Table(title="95 % intervals over those of 60 s of multisine", box=SIMPLE, title_style="bold")
    for name in motion.sizes:
        table.add_column(name.replace("_", " "), justify="right")
    table.add_row(*(f"{size:.2f}" for size in motion.sizes.values()))
    return table
