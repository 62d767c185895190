"""Results as tables for a terminal."""

from rich.table import Table

from adaptive_ff.compare import BASELINE, Comparison
from adaptive_ff.lineup import true_model
from adaptive_ff.model import ESTIMATED

UNITS = {
    "inertia": "kg m²",
    "coulomb": "N m",
    "stiction": "N m",
    "viscous": "N m s/rad",
    "friction_lag": "s",
}


def tracking_table(comparison: Comparison) -> Table:
    """Return the errors of all controllers, one a row."""
    table = Table(title="Velocity error, reference minus true velocity, mrad/s")
    table.add_column("controller")
    for heading in ("settled rms", f"{BASELINE} / own", "settled max", "first 5 s rms", "whole run rms"):
        table.add_column(heading, justify="right")
    table.add_column("torque variation, N m", justify="right")
    improvement = comparison.improvement
    for name, run in comparison.runs.items():
        metrics = run.metrics
        errors = (metrics.max_error_settled, metrics.rms_error_start, metrics.rms_error)
        table.add_row(
            name,
            _milli(metrics.rms_error_settled),
            f"{improvement[name]:.2f}" if name in improvement else "-",
            *(_milli(error) for error in errors),
            f"{metrics.torque_variation:.0f}",
            style="bold" if name == "adaptive" else None,
        )
    return table


def estimates_table(comparison: Comparison) -> Table | None:
    """Return the final estimates beside the true parameters, or None where nothing is estimated."""
    runs = [run for run in comparison.runs.values() if run.estimates]
    if not runs:
        return None
    table = Table(title="Parameters at the end of the run")
    table.add_column("parameter")
    table.add_column("true", justify="right")
    for run in runs:
        table.add_column(run.name, justify="right")
    changes = comparison.scenario.change
    scale = changes[-1].friction_scale if changes else 1.0
    model = true_model(comparison.scenario)
    for name in ESTIMATED:
        true = getattr(model, name) * (scale if name in ("coulomb", "stiction", "viscous") else 1.0)
        values = (run.final_estimates.get(name) for run in runs)
        table.add_row(
            f"{name}, {UNITS[name]}", f"{true:.4g}", *("-" if value is None else f"{value:.4g}" for value in values)
        )
    return table


def _milli(value: float) -> str:
    return f"{1e3 * value:.3g}"
