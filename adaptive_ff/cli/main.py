"""Command line: ``adaptive-ff``."""

import math
import os
import sys
import warnings
from contextlib import ExitStack
from importlib.metadata import version
from io import TextIOWrapper
from pathlib import Path
from typing import Annotated, TextIO

import typer
from rich.console import Console
from rich.progress import BarColumn, Progress, TextColumn, TimeRemainingColumn

from adaptive_ff.cli.export import export_command
from adaptive_ff.cli.identify import register as register_measured
from adaptive_ff.cli.terminal import Printer
from adaptive_ff.comparison.baseline import read_baseline, regressions
from adaptive_ff.comparison.comparison import Comparison, compare
from adaptive_ff.comparison.drawn_joints import draw_scenario, summary, sweep
from adaptive_ff.comparison.registry import make_controller
from adaptive_ff.errors import InputError
from adaptive_ff.report.comparison_tables import estimates_table, sweep_table, tracking_table
from adaptive_ff.report.files import staged, write_csv, write_json
from adaptive_ff.scenario.file import to_toml
from adaptive_ff.scenario.scenario import Scenario, load_scenario
from adaptive_ff.simulation.loop import run_compiled
from controllers import is_cached

WORSE = 1
BAD_INPUT = 2

app = typer.Typer(
    help="Adaptive friction-compensating velocity control of robot and machine joints.",
    add_completion=False,
    no_args_is_help=True,
    pretty_exceptions_enable=False,
)
register_measured(app)
app.command("export")(export_command)


@app.callback()
def _application() -> None:
    """Adaptive friction-compensating velocity control of robot and machine joints."""


@app.command("version")
def version_command() -> None:
    """Print the version."""
    typer.echo(version("adaptive-ff"))


@app.command("compare")
def compare_command(
    scenario: Annotated[Path | None, typer.Argument(help="Scenario file (TOML); the built-in one by default.")] = None,
    reference: Annotated[
        Path | None,
        typer.Option(help="Recorded reference (CSV: time and velocity or position), instead of the file's."),
    ] = None,
    out: Annotated[Path, typer.Option(help="Folder for plots (PNG), time series (CSV) and result.json.")] = Path(
        "results"
    ),
    json: Annotated[Path | None, typer.Option(help="Write the result there, too.")] = None,
    baseline: Annotated[
        Path | None, typer.Option(help="Earlier result (JSON); status 1 where tracking got worse than it.")
    ] = None,
    tolerance: Annotated[str, typer.Option(help="How much worse a figure may be, as in 5%.")] = "5%",
) -> int:
    """Run a joint with each controller and show by how much friction feedforward improves tracking."""
    earlier = None if baseline is None else read_baseline(baseline)
    allowed = _share("tolerance", tolerance)
    errors = Console(stderr=True, soft_wrap=True, highlight=False)
    loaded = load_scenario(scenario, reference=reference)
    source = scenario or "built-in scenario"
    try:
        for name in loaded.controllers:
            make_controller(loaded, name)
    except ValueError as error:
        raise InputError(f"{source}: {error}") from error
    for caution in loaded.cautions():
        errors.print(f"warning: {caution}", markup=False)
    with ExitStack() as stack:
        beside = None if json is None else stack.enter_context(staged(json.parent))
        stage = stack.enter_context(staged(out))
        if json is not None and os.path.isdir(json):
            raise InputError(f"{json}: cannot be written: it is a folder")
        try:
            comparison = _run(loaded, errors)
        except ArithmeticError as error:
            raise InputError(f"{source}: the simulation fails: {error}") from error
        result = comparison.to_dict()
        for name, run in comparison.runs.items():
            write_csv(stage / f"{name}.csv", run.columns())
        comparison.plot(stage)
        write_json(stage / "result.json", result)
        if json is not None and beside is not None:
            write_json(beside / json.name, result)
    _print(comparison, out)
    worse = [] if earlier is None else regressions(comparison, earlier, allowed)
    for sentence in worse:
        errors.print(f"worse than {baseline}: {sentence}", markup=False)
    return WORSE if worse else 0


@app.command("sweep")
def sweep_command(
    scenario: Annotated[Path | None, typer.Argument(help="Scenario file (TOML); the built-in one by default.")] = None,
    runs: Annotated[int, typer.Option(min=1, help="Number of joints to draw.")] = 1000,
    seed: Annotated[int, typer.Option(min=0, help="Seed of the draws.")] = 1,
    out: Annotated[Path, typer.Option(help="Folder for sweep.json and the worst cases as scenario files.")] = Path(
        "results"
    ),
    json: Annotated[Path | None, typer.Option(help="Write the result there, too.")] = None,
) -> None:
    """Draw joints at random, and show how pi, oracle and adaptive fare on them."""
    errors = Console(stderr=True, soft_wrap=True, highlight=False)
    loaded = load_scenario(scenario)
    with ExitStack() as stack:
        beside = None if json is None else stack.enter_context(staged(json.parent))
        stage = stack.enter_context(staged(out))
        _announce_compilation(errors)
        with _progress(errors) as progress:
            task = progress.add_task("joints", total=1.0)
            outcomes = sweep(loaded, runs, seed, progress=lambda share: progress.update(task, completed=share))
        result = summary(outcomes, seed)
        for rank, case in enumerate(result["worst"], start=1):
            text = to_toml(draw_scenario(loaded, seed, case["draw"]))
            (stage / f"worst-{rank}.toml").write_text(text, encoding="utf-8")
        write_json(stage / "sweep.json", result)
        if json is not None and beside is not None:
            write_json(beside / json.name, result)
    console = Printer()
    console.print(sweep_table(result))
    console.print(
        f"Whole run more than 5 % worse than pi: {100 * result['worse_than_pi']:.2g} % of the joints that ran"
    )
    console.print(f"sweep.json and the worst cases are in {out}", highlight=False, markup=False, soft_wrap=True)


def _share(name: str, text: str) -> float:
    """Read a share such as ``5%`` or ``0.05``."""
    try:
        share = float(text.removesuffix("%")) * (0.01 if text.endswith("%") else 1.0)
    except ValueError:
        share = math.nan
    if not (math.isfinite(share) and share >= 0.0):
        raise InputError(f"--{name} = {text!r} is not allowed: it must be a share such as 5% or 0.05, zero or more")
    return share


def _run(scenario: Scenario, errors: Console) -> Comparison:
    _announce_compilation(errors)
    with _progress(errors) as progress:
        tasks = {name: progress.add_task(name, total=1.0) for name in scenario.controllers}
        return compare(scenario, progress=lambda name, share: progress.update(tasks[name], completed=share))


def _announce_compilation(errors: Console) -> None:
    if not is_cached(run_compiled):
        errors.print("First run on this machine: the controllers are compiled, once (some 15 to 30 s).")


def _progress(errors: Console) -> Progress:
    columns = (TextColumn("{task.description}"), BarColumn(), TimeRemainingColumn())
    return Progress(*columns, console=errors, transient=True, disable=not errors.is_terminal)


def _print(comparison: Comparison, out: Path) -> None:
    console = Printer()
    console.print(tracking_table(comparison))
    estimates = estimates_table(comparison)
    if estimates is not None:
        console.print(estimates)
    console.print(f"Plots, time series and result.json are in {out}", highlight=False, markup=False, soft_wrap=True)


def main() -> None:
    """Run the command line; bad input ends it with status 2 and one line."""
    if isinstance(sys.stdout, TextIOWrapper):
        sys.stdout.reconfigure(errors="replace")  # a terminal may not know all characters
    with warnings.catch_warnings():
        warnings.showwarning = _show_warning
        try:
            status = app(standalone_mode=False)
        except KeyboardInterrupt:
            status = 130
        except (InputError, ArithmeticError, MemoryError, OSError) as error:
            status = _refuse(str(error) or type(error).__name__)
        except Exception as error:
            # a usage error of typer has a message for one line, after help an empty one; anything else is a defect
            message = getattr(error, "format_message", None)
            if message is None:
                raise
            context = getattr(error, "ctx", None)
            hint = "" if context is None else f"; {context.command_path} --help shows what is allowed"
            status = _refuse(message().rstrip(".") + hint) if message() else BAD_INPUT
    sys.exit(status)


def _refuse(message: str) -> int:
    print(f"adaptive-ff: {' '.join(message.split())}", file=sys.stderr)
    return BAD_INPUT


def _show_warning(
    message: Warning | str,
    category: type[Warning],
    filename: str,
    lineno: int,
    file: TextIO | None = None,
    line: str | None = None,
) -> None:
    del category, filename, lineno, file, line
    print(f"adaptive-ff: warning: {' '.join(str(message).split())}", file=sys.stderr)
