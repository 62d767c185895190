"""A study of bandwidths as tables."""

import math

from rich.box import SIMPLE
from rich.table import Table

from adaptive_ff.comparison.comparison import BASELINE
from adaptive_ff.report.scaling import scale_for, shown
from adaptive_ff.scenario.axis_units import axis_unit
from adaptive_ff.studies.bandwidth_study import BandwidthStudy


def loops_table(study: BandwidthStudy) -> Table:
    """Return what the PI loop is like at each bandwidth: margins, noise, and whether it holds the steepest friction."""
    axis = study.scenario.joint.axis
    factor, speed = scale_for([loop.noise_velocity for loop in study.loops], axis_unit(axis, "rad/s"))
    share, force = scale_for([loop.noise_torque for loop in study.loops], axis_unit(axis, "N m"))
    columns = (
        "Hz",
        "sensitivity",
        "phase",
        "gain",
        f"torque, {force}".replace("N m", "N\u00a0m"),
        f"velocity, {speed}",
    )
    title = "PI loop over its bandwidth: margins, and what sensor noise makes (rms)"
    table = Table(title=title, box=SIMPLE, title_style="bold")
    for heading in columns:
        table.add_column(heading, justify="right")
    table.add_column("steepest friction")
    for loop in study.loops:
        table.add_row(
            f"{loop.bandwidth:.3g}",
            f"{loop.maximum_sensitivity:.2f}",
            f"{loop.phase_margin:.0f}°",
            f"{loop.gain_margin:.3g}",
            shown(share * loop.noise_torque),
            shown(factor * loop.noise_velocity),
            "hunts" if loop.hunts else "held",
        )
    return table


def errors_table(study: BandwidthStudy) -> Table:
    """Return the error that each controller leaves at each bandwidth, the least of each marked."""
    unit = axis_unit(study.scenario.joint.axis, "rad/s")
    factor, speed = scale_for([e for one in study.own.values() for e in one.errors], unit)
    title = f"Settled rms error, {speed}, on the seeds that it is tuned on; * the least"
    table = Table(title=title, box=SIMPLE, title_style="bold")
    table.add_column("Hz", justify="right", no_wrap=True)
    for name in study.own:
        table.add_column(name, justify="right", overflow="fold")
    for place, loop in enumerate(study.loops):
        cells = []
        for one in study.own.values():
            error = one.errors[place]
            mark = "*" if one.bandwidths[place] == one.best else " "
            cells.append(f"{shown(factor * error)}{mark}" if math.isfinite(error) else "fails ")
        table.add_row(f"{loop.bandwidth:.3g}", *cells)
    return table


def best_table(study: BandwidthStudy) -> Table:
    """Return what each controller reaches at its own best bandwidth, and in the loop of the scenario."""
    factor, speed = scale_for(study.own_errors.values(), axis_unit(study.scenario.joint.axis, "rad/s"))
    feedback = study.scenario.feedback
    common = "" if feedback.is_auto else ("gains" if math.isnan(feedback.hertz) else f"{feedback.hertz:.3g} Hz")
    table = Table(
        title=f"Settled rms error, {speed}, on other seeds, each at its own best bandwidth",
        box=SIMPLE,
        title_style="bold",
    )
    table.add_column("controller", no_wrap=True)
    headings = ["own, Hz", "error", f"{BASELINE} / own"]
    if common:
        headings += [f"at {common}", f"{BASELINE} / own"]
    for heading in headings:
        table.add_column(heading, justify="right")
    for name, one in study.own.items():
        cells = [f"{one.best:.3g}{' (end)' if one.at_an_end else ''}"]
        for errors in (study.own_errors, study.common_errors):
            if name in errors:
                error = errors[name]
                cells += [shown(factor * error), f"{errors[BASELINE] / error:.2f}" if error > 0.0 else "-"]
        table.add_row(name, *cells, style="bold" if name == "adaptive" else None)
    return table
