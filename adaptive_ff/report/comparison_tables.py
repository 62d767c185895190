"""Results as tables for a terminal."""

from typing import Any

from rich.box import SIMPLE
from rich.table import Table

from adaptive_ff.comparison.comparison import BASELINE, Comparison
from adaptive_ff.comparison.registry import CONTROLLERS
from adaptive_ff.comparison.run import Run
from adaptive_ff.friction.model import PER_DIRECTION, unit_of
from adaptive_ff.report.scaling import DEVIATIONS, scale_for, shown
from adaptive_ff.scenario.axis_units import axis_unit
from adaptive_ff.scenario.truth import last_model, true_waves
from adaptive_ff.studies.drawn_joints import CLASSES, HUNTING
from adaptive_ff.studies.sweep import QUANTILES, QUANTITIES


def tracking_table(comparison: Comparison) -> Table:
    """Return the errors of all controllers, one a row."""
    metrics = {name: run.metrics for name, run in comparison.runs.items()}
    axis = comparison.scenario.joint.axis
    typical = [metrics[BASELINE]] if BASELINE in metrics else list(metrics.values())
    factor, speed = scale_for([one.rms_error_settled for one in typical], axis_unit(axis, "rad/s"))
    share, torque = scale_for([one.torque_variation for one in typical], axis_unit(axis, "N m"))
    what = "force" if axis == "linear" else "torque"
    title = f"Velocity error, {speed} (rms), and {what} variation, {torque}"
    table = Table(title=title, box=SIMPLE, title_style="bold")
    table.add_column("controller", no_wrap=True)
    for heading in ("settled", f"{BASELINE} / own", "settled max", "first 5 s", "whole run", "sum |du|"):
        table.add_column(heading, justify="right", no_wrap=True, min_width=6)
    improvement = comparison.improvement
    for name, one in metrics.items():
        errors = (one.max_error_settled, one.rms_error_start, one.rms_error)
        table.add_row(
            name,
            shown(factor * one.rms_error_settled),
            f"{improvement[name]:.2f}" if name in improvement else "-",
            *(shown(factor * error) for error in errors),
            shown(share * one.torque_variation),
            style=_style(name),
        )
    return table


def position_table(comparison: Comparison) -> Table | None:
    """Return the position errors of all controllers, one a row, or None where there is no position loop."""
    found = {name: run.position_metrics for name, run in comparison.runs.items() if run.position_metrics is not None}
    if not found:
        return None
    typical = [found[BASELINE]] if BASELINE in found else list(found.values())
    radians = axis_unit(comparison.scenario.joint.axis, "rad")
    factor, unit = scale_for([one.rms_position_error_settled for one in typical], radians)
    table = Table(title=f"Position error, {unit} (rms)", box=SIMPLE, title_style="bold")
    table.add_column("controller", no_wrap=True)
    for heading in ("settled", f"{BASELINE} / own", "settled max", "whole run", "max"):
        table.add_column(heading, justify="right", no_wrap=True, min_width=6)
    base = found[BASELINE].rms_position_error_settled if BASELINE in found else None
    for name, metrics in found.items():
        settled = metrics.rms_position_error_settled
        others = (metrics.max_position_error_settled, metrics.rms_position_error, metrics.max_position_error)
        table.add_row(
            name,
            shown(factor * settled),
            f"{base / settled:.2f}" if base is not None and settled > 0.0 else "-",
            *(shown(factor * error) for error in others),
            style=_style(name),
        )
    return table


def estimates_table(comparison: Comparison) -> Table | None:
    """Return the final estimates beside the true parameters, or None where nothing is estimated."""
    runs = [run for run in comparison.runs.values() if run.estimates]
    if not runs:
        return None
    title = "Parameters at the end of the run"
    if any(run.uncertainties for run in runs):
        title += f", ± {DEVIATIONS:g} standard deviations"
    table = Table(title=title, box=SIMPLE, title_style="bold")
    table.add_column("parameter")
    table.add_column("true", justify="right")
    for run in runs:
        table.add_column(run.name, justify="right")
    model = last_model(comparison.scenario)
    waves = true_waves(comparison.scenario)
    truth = model._asdict() | waves
    there = dict.fromkeys(name for run in runs for name in run.estimates)
    known = [name for name in (*PER_DIRECTION, *waves, "stribeck_velocity") if name in there]
    for name in known + [name for name in there if name not in known]:  # own controllers may estimate anything
        cells = (_estimate(run, name) for run in runs)
        true = f"{truth[name]:.4g}" if name in known else "-"
        unit = unit_of(name) and axis_unit(comparison.scenario.joint.axis, unit_of(name))
        table.add_row(f"{name}, {unit}" if unit else name, true, *cells)
    return table


def _estimate(run: Run, name: str) -> str:
    """Return a final estimate as text, with how far it may be off where the controller says so."""
    if name not in run.estimates:
        return "-"
    value = f"{run.final_estimates[name]:.4g}"
    if name not in run.uncertainties:
        return value
    return f"{value} ± {DEVIATIONS * run.uncertainties[name][-1]:.2g}"


def sweep_table(result: dict[str, Any]) -> Table:
    """Return the distributions that a sweep found."""
    table = Table(title=f"{result['draws']} draws, {result['refused']} of them refused", box=SIMPLE, title_style="bold")
    table.add_column("quantile", no_wrap=True)
    for name in result["quantiles"]:
        table.add_column(QUANTITIES[name], justify="right")
    for quantile in QUANTILES:
        label = {0.0: "least", 0.5: "median", 1.0: "most"}.get(quantile, f"{100 * quantile:g} %")
        values = (quantiles[str(quantile)] for quantiles in result["quantiles"].values())
        table.add_row(label, *(f"{value:.3g}" for value in values))
    return table


def own_sweep_table(result: dict[str, Any]) -> Table:
    """Return how own controllers, and further ones of the package, fared in a sweep."""
    table = Table(title="Further controllers", box=SIMPLE, title_style="bold")
    table.add_column("controller", no_wrap=True)
    quantiles = ("0.0", "0.05", "0.5", "0.95", "1.0")
    for heading in ("settled: pi / own", "whole run: own / pi"):
        table.add_column(f"{heading}: least, 5 %, median, 95 %, most", justify="right")
    table.add_column("failed", justify="right")
    for name, found in result["own"].items():
        cells = (
            ", ".join(f"{found[key][one]:.3g}" for one in quantiles) if key in found else "-"
            for key in ("improvement", "whole_run")
        )
        table.add_row(name, *cells, str(found["failed"]), style="bold cyan")
    return table


def classes_table(result: dict[str, Any]) -> Table:
    """Return what a sweep found by how steeply friction falls; where that is more than Kp, PI itself hunts."""
    table = Table(title="By the steepest fall of friction", box=SIMPLE, title_style="bold")
    table.add_column("friction falls by", no_wrap=True)
    names = ("joints", "settled: pi / adaptive", "least", "first 5 s: adaptive / pi", "settled worse than pi")
    for name in (*names, "whole run 5 % worse"):
        table.add_column(name, justify="right")
    for name, found in result["classes"].items():
        table.add_row(
            name + (" (pi hunts)" if CLASSES[name] >= HUNTING else ""),
            str(found["joints"]),
            *(f"{found[key]:.3g}" for key in ("improvement", "least_improvement", "start")),
            *(str(found[key]) for key in ("worse_settled", "worse_whole_run")),
        )
    return table


def _style(name: str) -> str | None:
    """Return how a controller is highlighted: the adaptive one, and a user's own."""
    if name not in CONTROLLERS:
        return "bold cyan"
    return "bold" if name == "adaptive" else None
