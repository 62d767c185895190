"""Command ``adaptive-ff compare``."""

import math
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer
from rich.console import Console

from adaptive_ff.cli.options import OUT, JsonCopy, ScenarioFile
from adaptive_ff.cli.places import places
from adaptive_ff.cli.terminal import Printer, announce_compilation, error_console, progress_bars, warn
from adaptive_ff.errors import InputError

if TYPE_CHECKING:
    from adaptive_ff.comparison.comparison import Comparison
    from adaptive_ff.scenario.scenario import Scenario

WORSE = 1
"""Exit status where a regression gate fails."""


def compare_command(
    scenario: ScenarioFile = None,
    reference: Annotated[
        Path | None,
        typer.Option(help="Recorded reference (CSV: time and velocity or position), instead of the file's."),
    ] = None,
    out: Annotated[Path, typer.Option(help="Folder for plots (PNG), time series (CSV) and result.json.")] = OUT,
    json: JsonCopy = None,
    baseline: Annotated[
        Path | None, typer.Option(help="Earlier result (JSON); status 1 where tracking got worse than it.")
    ] = None,
    tolerance: Annotated[str, typer.Option(help="How much worse a figure may be, as in 5%.")] = "5%",
) -> int:
    """Run a joint with each controller and show by how much friction feedforward improves tracking."""
    from adaptive_ff.comparison.baseline import read_baseline, regressions
    from adaptive_ff.comparison.registry import make_controller
    from adaptive_ff.report.files import write_csv, write_result
    from adaptive_ff.scenario.scenario import load_scenario

    earlier = None if baseline is None else read_baseline(baseline)
    allowed = _share("tolerance", tolerance)
    errors = error_console()
    loaded = load_scenario(scenario, reference=reference)
    source = scenario or "built-in scenario"
    try:
        for name in loaded.controllers:
            make_controller(loaded, name)
    except ValueError as error:
        raise InputError(f"{source}: {error}") from error
    warn(errors, loaded.cautions())
    with places(out, json) as (stage, beside):
        try:
            comparison = _run(loaded, errors)
        except ArithmeticError as error:
            raise InputError(f"{source}: the simulation fails: {error}") from error
        for name, run in comparison.runs.items():
            write_csv(stage / f"{name}.csv", run.columns())
        comparison.plot(stage)
        for file in (stage / "result.json", *beside.values()):
            write_result(file, comparison.to_dict())
    _print(comparison, out)
    worse = [] if earlier is None else regressions(comparison, earlier, allowed)
    for sentence in worse:
        errors.print(f"worse than {baseline}: {sentence}", markup=False)
    return WORSE if worse else 0


def _share(name: str, text: str) -> float:
    """Read a share such as ``5%`` or ``0.05``."""
    try:
        share = float(text.removesuffix("%")) * (0.01 if text.endswith("%") else 1.0)
    except ValueError:
        share = math.nan
    if not (math.isfinite(share) and share >= 0.0):
        raise InputError(f"--{name} = {text!r} is not allowed: it must be a share such as 5% or 0.05, zero or more")
    return share


def _run(scenario: "Scenario", errors: Console) -> "Comparison":
    from adaptive_ff.comparison.comparison import compare
    from adaptive_ff.simulation.loop import run_compiled

    announce_compilation(errors, run_compiled)
    with progress_bars(errors) as progress:
        tasks = {name: progress.add_task(name, total=1.0) for name in scenario.controllers}
        return compare(scenario, progress=lambda name, share: progress.update(tasks[name], completed=share))


def _print(comparison: "Comparison", out: Path) -> None:
    from adaptive_ff.report.comparison_tables import estimates_table, position_table, tracking_table

    console = Printer()
    console.print(tracking_table(comparison))
    for table in (position_table(comparison), estimates_table(comparison)):
        if table is not None:
            console.print(table)
    console.say(f"Plots, time series and result.json are in {out}")
